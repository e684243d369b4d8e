#!/usr/bin/env python3
"""Writes the scenes in which a cloth meets itself: datasets/README.md tells of them.

  datasets/folding/make_folding.py [FOLDER]

FOLDER is where this script stands, unless given. The same bytes are written every time. Lengths are in m, times in s.
"""

import json
import math
import pathlib
import sys

import numpy

TABLE = {"name": "table", "type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1], "mu": 0.5, "contact_distance": 0.001}
FABRIC = {"density": 0.2, "k_stretch": 60, "k_bend": 2e-5, "drag": 0.05, "damping": 0.05}
SELF = {"mu": 0.3, "thickness": 0.002}


def fold_path(width, rows):
    """A gripper takes one edge over to the other half, puts it down and drags it to and fro."""
    keys = [(0.0, 0.0, 0.001), (0.15, 0.02, 0.05), (0.35, 0.12, 0.12), (0.6, 0.24, 0.05), (0.75, 0.27, 0.006),
            (0.9, 0.27, 0.006), (1.2, 0.21, 0.006), (1.5, 0.26, 0.006), (1.6, 0.26, 0.006)]
    lines = ["time," + ",".join(f"x{i},y{i},z{i}" for i in range(rows))]
    for time, x, z in keys:
        places = (f"{x:g},{width * i / (rows - 1):.6f},{z:g}" for i in range(rows))
        lines.append(f"{time:g}," + ",".join(places))
    return "\n".join(lines) + "\n"


def fold():
    columns, rows, length, width = 19, 10, 0.36, 0.18
    scene = {"clothid_scene": 2, "time_step": 0.005, "duration": 1.6,
             "mesh": {"grid": {"nodes": [columns, rows], "size": [length, width], "origin": [0, 0, 0.001]}},
             "handles": {"nodes": [columns * i for i in range(rows)], "path": "fold.path.csv"},
             "obstacles": [TABLE], "self_contact": SELF, "materials": FABRIC}
    return scene, fold_path(width, rows)


def slide():
    """A strip that lies folded, its lower half held, on a slope of 30 degrees: the upper half slides down on it."""
    columns, rows, length, width, radius, held = 25, 5, 0.36, 0.06, 0.01, 0.16
    places = []
    for row in range(rows):
        for column in range(columns):
            way = length * column / (columns - 1)
            angle = (way - held) / radius
            if way <= held:
                x, z = 0.2 - way, 0.0
            elif angle < math.pi:
                x, z = 0.04 - radius * math.sin(angle), radius * (1.0 - math.cos(angle))
            else:
                x, z = 0.04 + (way - held - math.pi * radius), 2.0 * radius
            places.append((x, width * row / (rows - 1), z))
    nodes = [column + columns * row for row in range(rows) for column in range(columns)
             if length * column / (columns - 1) <= held]
    slope = math.radians(30.0)
    scene = {"clothid_scene": 2, "time_step": 0.005, "duration": 0.5,
             "gravity": [round(9.81 * math.sin(slope), 6), 0, round(-9.81 * math.cos(slope), 6)],
             "mesh": {"grid": {"nodes": [columns, rows], "size": [length, width]}},
             "initial": {"positions": "slide.start.npy"}, "handles": nodes, "self_contact": SELF, "materials": FABRIC}
    return scene, numpy.array(places)


def wrap():
    """A cloth falls on a ball that stands on a table, and wraps it."""
    ball = {"name": "ball", "type": "sphere", "center": [0.2, 0.2, 0.06], "radius": 0.06, "mu": 0.3,
            "contact_distance": 0.001}
    return {"clothid_scene": 2, "time_step": 0.01, "duration": 2.0,
            "mesh": {"grid": {"nodes": [25, 25], "size": [0.4, 0.4], "origin": [0, 0, 0.14]}},
            "obstacles": [ball, TABLE], "self_contact": SELF, "materials": FABRIC}


def crumple():
    """A cloth that stands upright, not quite straight, is dropped on a table."""
    nodes, size = 15, 0.3
    places = []
    for row in range(nodes):
        for column in range(nodes):
            x, z = size * column / (nodes - 1), size * row / (nodes - 1)
            places.append((x, 0.01 * math.sin(9.0 * x + 7.0 * z) + 0.1 * z, 0.01 + z))
    scene = {"clothid_scene": 2, "time_step": 0.005, "duration": 0.6,
             "mesh": {"grid": {"nodes": [nodes, nodes], "size": [size, size]}},
             "initial": {"positions": "crumple.start.npy"},
             "obstacles": [TABLE], "self_contact": SELF, "materials": FABRIC}
    return scene, numpy.array(places)


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent
    folder.mkdir(parents=True, exist_ok=True)
    scenes = {"wrap": wrap()}
    scenes["fold"], path = fold()
    (folder / "fold.path.csv").write_text(path)
    for name, make in (("slide", slide), ("crumple", crumple)):
        scenes[name], places = make()
        numpy.save(folder / f"{name}.start.npy", places)
    for name, scene in scenes.items():
        (folder / f"{name}.scene.json").write_text(json.dumps(scene, indent=1) + "\n")


if __name__ == "__main__":
    main()
