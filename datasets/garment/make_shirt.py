#!/usr/bin/env python3
"""Writes a shirt that is sewn from two panels and worn by a body that moves: datasets/README.md tells of it.

  datasets/garment/make_shirt.py [FOLDER [SPACING]]

FOLDER is where this script stands, unless given; SPACING is the distance of nodes (0.05; 0.0145 gives 4940 nodes). The
same bytes are written every time. Lengths are in m, times in s, angles in rad.
"""

import math
import pathlib
import sys

sys.dont_write_bytecode = True
from garment import about, capsule, cut_cell, path, product, write_obj, write_scene  # noqa: E402

WIDTH, HEIGHT, SLEEVE, CUFF, NECK = 0.56, 0.70, 0.25, 0.20, 0.15  # of a panel
DEPTH, ABOVE = 0.14, 0.06  # of the panels from the middle of the body, and above its shoulders, at the start
CLOSES = 0.12  # when the seams are closed
RATE, STEPS = 60, 200
ARM = 0.13  # from the middle of the body to where an arm begins
SHOULDER = -0.13


class Panel:
    """A T of square cells, each cut into two triangles; nodes by column and row, from the hem up."""

    def __init__(self, spacing, first_node, side, shift):
        self.columns, self.rows = round(WIDTH / spacing), round(HEIGHT / spacing)
        self.sleeve, self.cuff = round(SLEEVE / spacing), round(CUFF / spacing)
        neck = round(NECK / spacing)
        self.neck = neck + (self.columns - neck) % 2
        self.nodes, self.places, self.map, self.faces = {}, [], [], []
        self.spacing, self.first_node, self.side, self.shift = spacing, first_node, side, shift
        for row in range(self.rows):
            for column in range(-self.sleeve, self.columns + self.sleeve):
                if self.has_cell(column, row):
                    self.add_cell(column, row)

    def has_cell(self, column, row):
        return 0 <= column < self.columns or row >= self.rows - self.cuff

    def node(self, column, row):
        if (column, row) not in self.nodes:
            self.nodes[column, row] = self.first_node + len(self.places)
            x, z = (column - self.columns / 2) * self.spacing, (row - self.rows) * self.spacing
            self.places.append((x, self.side * DEPTH, z + ABOVE))
            self.map.append((self.shift - self.side * x, z))
        return self.nodes[column, row]

    def add_cell(self, column, row):
        a, b = self.node(column, row), self.node(column + 1, row)
        c, d = self.node(column + 1, row + 1), self.node(column, row + 1)
        halves = cut_cell(a, b, c, d, (column + row) % 2 == 0)
        self.faces += [half if self.side < 0 else half[::-1] for half in halves]

    def seams(self):
        """The chains along which it is sewn: either side, under the arm, over the sleeve to the neck."""
        armpit, shoulder = self.rows - self.cuff, (self.columns - self.neck) // 2
        for across in (lambda i: i, lambda i: self.columns - i):
            yield [self.nodes[across(0), row] for row in range(armpit + 1)]
            yield [self.nodes[across(-i), armpit] for i in range(self.sleeve + 1)]
            yield [self.nodes[across(i - self.sleeve), self.rows] for i in range(self.sleeve + shoulder + 1)]


def panels(spacing):
    """Front and back, whose nodes come after those of the front."""
    front = Panel(spacing, 0, -1, 0.0)
    return front, Panel(spacing, len(front.places), 1, 3.0)


def body(motion, times, mu=0.3):
    """Its four capsules. `motion(t)` is the place of the trunk, its turn about z and how far the arms are lowered."""
    def trunk(t):
        place, turn, _ = motion(t)
        return place, about((0, 0, 1), turn)

    def arm(side):
        def pose(t):
            (x, y, z), turn, lowered = motion(t)
            place = [x + side * ARM * math.cos(turn), y + side * ARM * math.sin(turn), z + SHOULDER]
            return place, product(about((0, 0, 1), turn), about((0, 1, 0), side * lowered))
        return pose

    return [capsule("torso", [0, 0, -0.62], [0, 0, -0.15], 0.13, path(trunk, times), mu),
            capsule("shoulders", [-ARM, 0, SHOULDER], [ARM, 0, SHOULDER], 0.075, path(trunk, times), mu),
            capsule("left", [0, 0, 0], [-0.42, 0, 0], 0.05, path(arm(-1), times), mu),
            capsule("right", [0, 0, 0], [0.42, 0, 0], 0.05, path(arm(1), times), mu)]


def sway(t):
    """The body stands until the shirt is on."""
    t = max(t - 0.8, 0.0)
    return [0.06 * math.sin(2 * t), 0.04 * (1 - math.cos(2 * t)), 0.0], 0.3 * math.sin(2 * t), 0.25 * (
        1 - math.cos(1.5 * t))


def sewing(front, back, **how):
    """The keys of `mesh` but the file."""
    return {"rest": "uv", "seams": [{"a": a, "b": b, **how} for a, b in zip(front.seams(), back.seams())]}


def write_panels(file, cloth):
    front, back = cloth
    write_obj(file, front.places + back.places, front.map + back.map, front.faces + back.faces)


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent)
    cloth = panels(float(sys.argv[2]) if len(sys.argv) > 2 else 0.05)
    write_panels(folder / "shirt.obj", cloth)
    write_scene(folder / "shirt.scene.json", {
        "clothid_scene": 2, "time_step": 1 / RATE, "duration": STEPS / RATE,
        "mesh": {"obj": "shirt.obj", **sewing(*cloth, closes=CLOSES)},
        "obstacles": body(sway, [step / RATE for step in range(STEPS + 1)]),
        "materials": {"density": 0.18, "k_stretch": 200, "k_bend": 2e-5, "damping": 0.5, "drag": 0.05}})


if __name__ == "__main__":
    main()
