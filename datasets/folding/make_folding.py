#!/usr/bin/env python3
"""Writes the scenes in which a cloth meets itself: datasets/README.md tells of them.

  datasets/folding/make_folding.py [FOLDER] [--build BUILD]

FOLDER is where this script stands, unless given. With BUILD, where `simulate` and `motion` are, slide.obj and shake.obj
are settled anew. The same bytes are written every time. Lengths are in m, times in s.
"""

import argparse
import json
import math
import pathlib
import subprocess
import tempfile

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


# Of a strip that lies folded, its lower half held: columns, rows, length, width, and how much of it is held.
STRIP = {"columns": 41, "rows": 5, "length": 0.4, "width": 0.06, "held": 0.2}
STIFF = {**FABRIC, "k_bend": 1e-4}


def half_circle():
    """The strip with a crease of 25 mm radius, above its lower half."""
    radius, held = 0.025, STRIP["held"]
    places = []
    for row in range(STRIP["rows"]):
        for column in range(STRIP["columns"]):
            way = STRIP["length"] * column / (STRIP["columns"] - 1)
            angle = (way - held) / radius
            if way <= held:
                x, z = 0.2 - way, 0.0
            elif angle < math.pi:
                x, z = -radius * math.sin(angle), radius * (1.0 - math.cos(angle))
            else:
                x, z = way - held - math.pi * radius, 2.0 * radius
            places.append((x, STRIP["width"] * row / (STRIP["rows"] - 1), z))
    return numpy.array(places)


def held_nodes():
    columns = STRIP["columns"]
    last = round(STRIP["held"] / STRIP["length"] * (columns - 1))
    return [column + columns * row for row in range(STRIP["rows"]) for column in range(last + 1)]


def strip_scene(name, degrees, duration):
    """Starts as NAME.obj, whose rest shape is flat."""
    slope = math.radians(degrees)
    return {"clothid_scene": 2, "time_step": 0.005, "duration": duration,
            "gravity": [round(9.81 * math.sin(slope), 6), 0, round(-9.81 * math.cos(slope), 6)],
            "mesh": {"obj": f"{name}.obj", "rest": "uv"}, "initial": {"positions": "rest"}, "handles": held_nodes(),
            "self_contact": SELF, "materials": STIFF}


def slide():
    """On a slope of 18 degrees the upper half slides down on the lower one."""
    return strip_scene("slide", 18.0, 0.3)


def shake():
    """On a slope of 10 degrees, where it would stay, the lower half goes to and fro: the upper one slides by jerks."""
    scene = strip_scene("shake", 10.0, 0.7)
    scene["handles"] = {"nodes": scene["handles"], "path": "shake.path.csv"}
    places = half_circle()[held_nodes()]
    lines = ["time," + ",".join(f"x{i},y{i},z{i}" for i in range(len(places)))]
    for knot in range(29):
        time = 0.025 * knot
        rise = min(1.0, time / 0.15)
        shift = round(0.003 * rise * rise * (3.0 - 2.0 * rise) * math.sin(10.0 * math.pi * time), 6)
        lines.append(f"{time:g}," + ",".join(f"{x + shift:.6g},{y:.6g},{z:.6g}" for x, y, z in places))
    return scene, "\n".join(lines) + "\n"


def settle(build, scene, file):
    """Lets the strip of `scene` come to rest, its layers 2.2 mm farther apart than thick: nearer ones are neighbours."""
    scene = dict(scene)
    scene.update({"duration": 1.5, "handles": held_nodes(),
                  "mesh": {"grid": {"nodes": [STRIP["columns"], STRIP["rows"]],
                                    "size": [STRIP["length"], STRIP["width"]]}},
                  "initial": {"positions": "start.npy"}, "self_contact": {"mu": 0.8, "thickness": 0.0042},
                  "materials": {**STIFF, "drag": 2.0}})
    with tempfile.TemporaryDirectory() as name:
        work = pathlib.Path(name)
        numpy.save(work / "start.npy", half_circle())
        (work / "scene.json").write_text(json.dumps(scene))
        subprocess.run([build / "simulate", "--scene", work / "scene.json", "--frame_rate", "2", "--output",
                        work / "settled.bin"], check=True)
        subprocess.run([build / "motion", "convert", work / "settled.bin", work / "settled.npy"], check=True)
        places = numpy.load(work / "settled.npy")[-1]
    file.write_text(folded_obj(places))


def folded_obj(places):
    columns, rows = STRIP["columns"], STRIP["rows"]
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in places]
    for row in range(rows):
        for column in range(columns):
            lines.append(f"vt {STRIP['length'] * column / (columns - 1):g} {STRIP['width'] * row / (rows - 1):g}")
    for row in range(rows - 1):
        for column in range(columns - 1):
            a = row * columns + column + 1
            b, c, d = a + 1, a + columns + 1, a + columns
            for face in ((a, b, c), (a, c, d)) if (row + column) % 2 == 0 else ((a, b, d), (b, c, d)):
                lines.append("f " + " ".join(f"{node}/{node}" for node in face))
    return "\n".join(lines) + "\n"


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
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, nargs="?", default=pathlib.Path(__file__).resolve().parent)
    parser.add_argument("--build", type=pathlib.Path)
    options = parser.parse_args()
    folder = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    scenes = {"wrap": wrap(), "slide": slide()}
    for name, make in (("fold", fold), ("shake", shake)):
        scenes[name], path = make()
        (folder / f"{name}.path.csv").write_text(path)
    scenes["crumple"], places = crumple()
    numpy.save(folder / "crumple.start.npy", places)
    for name, scene in scenes.items():
        (folder / f"{name}.scene.json").write_text(json.dumps(scene, indent=1) + "\n")
    if options.build:
        for name in ("slide", "shake"):
            settle(options.build, scenes[name], folder / f"{name}.obj")


if __name__ == "__main__":
    main()
