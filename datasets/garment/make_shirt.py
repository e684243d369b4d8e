#!/usr/bin/env python3
"""Writes a shirt that is sewn from two panels and worn by a body that moves: datasets/README.md tells of it.

  datasets/garment/make_shirt.py [FOLDER [SPACING]]

FOLDER is where this script stands, unless given; SPACING is the distance of nodes (0.05; 0.0145 gives 4940 nodes). The
same bytes are written every time. Lengths are in m, times in s, angles in rad.
"""

import json
import math
import pathlib
import sys

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
                if 0 <= column < self.columns or row >= self.rows - self.cuff:
                    self.add_cell(column, row)

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
        halves = [(a, b, c), (a, c, d)] if (column + row) % 2 == 0 else [(a, b, d), (b, c, d)]
        self.faces += [half if self.side < 0 else half[::-1] for half in halves]

    def seams(self):
        """The chains along which it is sewn: either side, under the arm, over the sleeve to the neck."""
        armpit, shoulder = self.rows - self.cuff, (self.columns - self.neck) // 2
        for across in (lambda i: i, lambda i: self.columns - i):
            yield [self.nodes[across(0), row] for row in range(armpit + 1)]
            yield [self.nodes[across(-i), armpit] for i in range(self.sleeve + 1)]
            yield [self.nodes[across(i - self.sleeve), self.rows] for i in range(self.sleeve + shoulder + 1)]


def about(axis, angle):
    return [axis[0] * math.sin(angle / 2), axis[1] * math.sin(angle / 2), axis[2] * math.sin(angle / 2),
            math.cos(angle / 2)]


def product(a, b):
    x, y, z, w = a
    p, q, r, s = b
    return [w * p + x * s + y * r - z * q, w * q - x * r + y * s + z * p, w * r + x * q - y * p + z * s,
            w * s - x * p - y * q - z * r]


def path(pose):
    """Rows of a path: the body stands until the shirt is on, then `pose` of the time since then."""
    rows = []
    for step in range(STEPS + 1):
        place, turn = pose(max(step / RATE - 0.8, 0.0))
        rows.append([round(number, 9) for number in [step / RATE, *place, *turn]])
    return rows


def sway(t):
    return [0.06 * math.sin(2 * t), 0.04 * (1 - math.cos(2 * t)), 0.0]


def trunk(t):
    return sway(t), about((0, 0, 1), 0.3 * math.sin(2 * t))


def arm(side):
    def pose(t):
        (x, y, z), turn = trunk(t)
        angle = 0.3 * math.sin(2 * t)
        place = [x + side * ARM * math.cos(angle), y + side * ARM * math.sin(angle), z + SHOULDER]
        return place, product(turn, about((0, 1, 0), side * 0.25 * (1 - math.cos(1.5 * t))))
    return pose


def capsule(name, start, end, radius, pose):
    return {"name": name, "type": "capsule", "from": start, "to": end, "radius": radius, "mu": 0.3,
            "contact_distance": 0.003, "path": path(pose)}


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent)
    spacing = float(sys.argv[2]) if len(sys.argv) > 2 else 0.05
    front = Panel(spacing, 0, -1, 0.0)
    back = Panel(spacing, len(front.places), 1, 3.0)
    lines = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in front.places + back.places]
    lines += [f"vt {u:.6g} {v:.6g}" for u, v in front.map + back.map]
    lines += ["f " + " ".join(f"{node + 1}/{node + 1}" for node in face) for face in front.faces + back.faces]
    (folder / "shirt.obj").write_text("\n".join(lines) + "\n")
    scene = {
        "clothid_scene": 2, "time_step": 1 / RATE, "duration": STEPS / RATE,
        "mesh": {"obj": "shirt.obj", "rest": "uv",
                 "seams": [{"a": a, "b": b, "closes": CLOSES} for a, b in zip(front.seams(), back.seams())]},
        "obstacles": [
            capsule("torso", [0, 0, -0.62], [0, 0, -0.15], 0.13, trunk),
            capsule("shoulders", [-ARM, 0, SHOULDER], [ARM, 0, SHOULDER], 0.075, trunk),
            capsule("left", [0, 0, 0], [-0.42, 0, 0], 0.05, arm(-1)),
            capsule("right", [0, 0, 0], [0.42, 0, 0], 0.05, arm(1))],
        "materials": {"density": 0.18, "k_stretch": 200, "k_bend": 2e-5, "damping": 0.5, "drag": 0.05}}
    text = json.dumps(scene, indent=None, separators=(", ", ": "))
    (folder / "shirt.scene.json").write_text(text.replace(', "mesh"', ',\n"mesh"').replace('{"name"', '\n{"name"')
                                             .replace(', "materials"', ',\n"materials"') + "\n")


if __name__ == "__main__":
    main()
