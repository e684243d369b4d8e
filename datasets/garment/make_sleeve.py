#!/usr/bin/env python3
"""Writes two scenes of a sleeve that is sewn along one seam to a tube: datasets/README.md tells of them. The same bytes
are written every time.

- sleeve: on an arm that moves to and fro and dips. One end is fixed to the arm, the rest slides on it.
- cuff: the arm stands still, and the other end is turned up over the sleeve, let down on it and drawn to and fro.

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
LOWERED = RADIUS - ARM - DISTANCE - 0.0005  # of its axis: the tube touches the arm above
DURATION, RATE = 1.2, 50
FABRIC = {"density": 0.2, "k_stretch": 100, "k_bend": 3e-4, "damping": 0.3, "drag": 0.1}


def motion(t):
    """The arm goes to and fro along itself, 1.5 times a second, and dips by 15 degrees."""
    along = 0.04 * smooth(t / 0.5) * math.sin(3 * math.pi * t)
    return [along, 0, 0], about((0, 1, 0), math.radians(15) * smooth((t - 0.1) / 0.8))


def node(around, along):
    return along * (AROUND + 1) + around


def place(x, around, radius):
    angle = 2 * math.pi * around / AROUND + SEAM
    return x, -radius * math.sin(angle), -radius * math.cos(angle) - LOWERED


def cuff_path():
    """The free end widens to 70 mm, goes back by 120 mm, over the sleeve, and narrows to 62 mm, which touches it."""
    lines = ["time," + ",".join(f"x{i},y{i},z{i}" for i in range(AROUND))]
    for step in range(round(DURATION * 20) + 1):
        t = step / 20
        radius = RADIUS + 0.015 * smooth(t / 0.2) - 0.008 * smooth((t - 0.6) / 0.15)
        x = LENGTH / 2 - 0.12 * smooth((t - 0.1) / 0.5)
        x += 0.012 * math.sin(4 * math.pi * (t - 0.75)) * smooth((t - 0.75) / 0.1)
        lines.append(f"{t:g}," + ",".join(f"{number:.6f}" for i in range(AROUND) for number in place(x, i, radius)))
    return "\n".join(lines) + "\n"


def tube():
    """The places of the nodes, those in the UV map, and the triangles."""
    edge = 2 * RADIUS * math.sin(math.pi / AROUND)
    places, uv_map, faces = [], [], []
    for j in range(ALONG + 1):
        for i in range(AROUND + 1):
            places.append(place(LENGTH * (j / ALONG - 0.5), i, RADIUS))
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
    scene = {"clothid_scene": 2, "time_step": 0.01, "duration": DURATION,
             "mesh": {"obj": "sleeve.obj", "rest": "uv", "seams": [seam]}, "initial": {"positions": "rest"}}
    arm = [[-0.3, 0, 0], [0.3, 0, 0], ARM]
    write_scene(folder / "sleeve.scene.json", {
        **scene, "handles": {"nodes": list(range(AROUND)), "attach": "arm"},
        "obstacles": [capsule("arm", *arm, rows, 0.7, DISTANCE)], "materials": FABRIC})
    (folder / "cuff.path.csv").write_text(cuff_path())
    end = [ALONG * AROUND + i for i in range(AROUND)]  # of the sewn tube
    write_scene(folder / "cuff.scene.json", {
        **scene, "handles": [{"nodes": list(range(AROUND))}, {"nodes": end, "path": "cuff.path.csv"}],
        "obstacles": [capsule("arm", *arm, None, 0.3, DISTANCE)], "self_contact": {"mu": 0.3, "thickness": 0.003},
        "materials": FABRIC})


if __name__ == "__main__":
    main()
