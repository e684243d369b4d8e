#!/usr/bin/env python3
"""Writes a sleeve, sewn along one seam to a tube, on an arm that moves to and fro and dips: datasets/README.md tells of
it. One end is fixed to the arm, the rest slides on it. The same bytes are written every time.

  datasets/garment/make_sleeve.py [FOLDER]

FOLDER is where this script stands, unless given. Lengths are in m, times in s, angles in rad.
"""

import math
import pathlib
import sys

sys.dont_write_bytecode = True
from garment import about, capsule, cut_cell, path, smooth, write_obj, write_scene  # noqa: E402

AROUND, ALONG = 24, 16  # cells
RADIUS, LENGTH = 0.055, 0.25  # of the tube
ARM, DISTANCE = 0.05, 0.002  # radius of the arm, thickness of the cloth
SEAM = 0.6  # how far around the seam lies, from below: nothing is symmetric
DURATION, RATE = 1.2, 50


def motion(t):
    """The arm goes to and fro along itself, 1.5 times a second, and dips by 15 degrees."""
    along = 0.04 * smooth(t / 0.5) * math.sin(3 * math.pi * t)
    return [along, 0, 0], about((0, 1, 0), math.radians(15) * smooth((t - 0.1) / 0.8))


def node(around, along):
    return along * (AROUND + 1) + around


def tube():
    """The places of the nodes, those in the UV map, and the triangles; the tube touches the arm above."""
    edge, lowered = 2 * RADIUS * math.sin(math.pi / AROUND), RADIUS - ARM - DISTANCE - 0.0005
    places, uv_map, faces = [], [], []
    for j in range(ALONG + 1):
        for i in range(AROUND + 1):
            angle = 2 * math.pi * i / AROUND + SEAM
            places.append((LENGTH * (j / ALONG - 0.5), -RADIUS * math.sin(angle), -RADIUS * math.cos(angle) - lowered))
            uv_map.append((edge * i, LENGTH * j / ALONG))
    for j in range(ALONG):
        for i in range(AROUND):
            faces += cut_cell(node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1), (i + j) % 2 == 0)
    return places, uv_map, faces


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent)
    write_obj(folder / "sleeve.obj", *tube(), digits=9)
    seam = {"a": [node(0, j) for j in range(ALONG + 1)], "b": [node(AROUND, j) for j in range(ALONG + 1)]}
    rows = path(motion, [step / RATE for step in range(round(DURATION * RATE) + 1)])
    write_scene(folder / "sleeve.scene.json", {
        "clothid_scene": 2, "time_step": 0.01, "duration": DURATION,
        "mesh": {"obj": "sleeve.obj", "rest": "uv", "seams": [seam]}, "initial": {"positions": "rest"},
        "handles": {"nodes": list(range(AROUND)), "attach": "arm"},
        "obstacles": [capsule("arm", [-0.3, 0, 0], [0.3, 0, 0], ARM, rows, 0.7, DISTANCE)],
        "materials": {"density": 0.2, "k_stretch": 100, "k_bend": 3e-4, "damping": 0.3, "drag": 0.1}})


if __name__ == "__main__":
    main()
