#!/usr/bin/env python3
"""Writes the shirt as it is worn, at rest on a body that then sways: seams are joined, a file has the start.

  datasets/garment/wear_shirt.py BUILD [FOLDER [SPACING]]

`simulate` of the folder BUILD dresses the body with the shirt of make_shirt.py, its nodes 0.05 or 0.03 m apart, and
lets it settle for 2 s, with the true mu and k_stretch. For a SPACING below that (0.0145 gives 4940 nodes) the worn
shirt is interpolated through the UV map, and nodes that are then inside the body are moved out of it. FOLDER is where
this script stands, unless given; shirt.obj is written there, too. Lengths are in m, times in s, angles in rad.
"""

import csv
import math
import pathlib
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from garment import smooth, write_scene  # noqa: E402
from make_shirt import CLOSES, body, panels, sewing, write_panels  # noqa: E402
from npy_file import write_npy  # noqa: E402

COARSE, FINEST_DRESSED = 0.05, 0.03  # distance of nodes
SETTLED, DURATION = 2.0, 10 / 3
STEP, ROWS = 1 / 60, 1 / 30
MATERIALS = {"density": 0.18, "k_stretch": 150, "k_bend": 1e-3, "damping": 0.5, "drag": 0.05}
MU = 0.3


def stand(_):
    return [0.0, 0.0, 0.0], 0.0, 0.0


def sway(t):
    """Once a second, by 30 mm and 9 degrees, the arms by 11: slow enough for the cloth to follow."""
    share, phase = smooth((t - 0.1) / 0.4), 2 * math.pi * (t - 0.1)
    return [0.03 * share * math.sin(phase), 0.0, 0.0], 0.15 * share * math.sin(phase), 0.1 * share * (
        1 - math.cos(phase))


def run(program, *flags):
    subprocess.run([program, *flags], check=True, stdout=sys.stderr)


def dress(cloth, build):
    """Where the nodes of a shirt end that is thrown on a body at rest, those of a seam in the middle between both."""
    seams = sewing(*cloth, closes=CLOSES)
    steps = round(SETTLED / STEP)
    scene = {"clothid_scene": 2, "time_step": STEP, "duration": SETTLED, "mesh": {"obj": "shirt.obj", **seams},
             "obstacles": body(stand, [0.0, SETTLED], MU), "materials": {**MATERIALS, "drag": 0.3}}
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        write_panels(folder / "shirt.obj", cloth)
        write_scene(folder / "shirt.scene.json", scene)
        run(build / "simulate", "--scene", folder / "shirt.scene.json", "--output", folder / "worn.bin")
        run(build / "motion", "convert", folder / "worn.bin", folder / "worn.csv", "--frames", f"{steps}:{steps + 1}")
        with open(folder / "worn.csv", encoding="ascii") as rows:
            worn = [[float(row[axis]) for axis in "xyz"] for row in csv.DictReader(rows)]
    for seam in seams["seams"]:
        for a, b in zip(seam["a"], seam["b"]):
            worn[a] = worn[b] = [0.5 * (x + y) for x, y in zip(worn[a], worn[b])]
    return worn


def on_coarse(panel, fine, column, row):
    """Where a node of the finer panel lies on the coarser one, whose parts are other numbers of cells."""
    armpit, coarse_armpit = fine.rows - fine.cuff, panel.rows - panel.cuff
    if column < 0:
        x = column * panel.sleeve / fine.sleeve
    elif column <= fine.columns:
        x = column * panel.columns / fine.columns
    else:
        x = panel.columns + (column - fine.columns) * panel.sleeve / fine.sleeve
    if row <= armpit:
        return x, row * coarse_armpit / armpit
    return x, coarse_armpit + (row - armpit) * panel.cuff / fine.cuff


def interpolated(panel, fine, worn):
    """The places of the nodes of the finer panel, bilinear in the cells of the coarser one."""
    places = []
    for column, row in fine.nodes:
        x, y = on_coarse(panel, fine, column, row)
        candidates = [(i, j) for i in (math.floor(x), math.ceil(x) - 1) for j in (math.floor(y), math.ceil(y) - 1)]
        i, j = next(cell for cell in candidates
                    if -panel.sleeve <= cell[0] < panel.columns + panel.sleeve and 0 <= cell[1] < panel.rows
                    and panel.has_cell(*cell))
        corners = [(i, j, (1 - x + i) * (1 - y + j)), (i + 1, j, (x - i) * (1 - y + j)),
                   (i, j + 1, (1 - x + i) * (y - j)), (i + 1, j + 1, (x - i) * (y - j))]
        places.append([sum(weight * worn[panel.nodes[c, r]][axis] for c, r, weight in corners) for axis in range(3)])
    return places


def moved_out(place, capsules):
    """`place`, out of every capsule of a body at rest."""
    for capsule in capsules:
        origin = capsule["path"][0][1:4]
        start, end = ([a + b for a, b in zip(origin, capsule[key])] for key in ("from", "to"))
        axis = [b - a for a, b in zip(start, end)]
        share = sum((p - a) * d for p, a, d in zip(place, start, axis)) / sum(d * d for d in axis)
        nearest = [a + min(max(share, 0.0), 1.0) * d for a, d in zip(start, axis)]
        distance, least = math.dist(place, nearest), capsule["radius"] + capsule["contact_distance"]
        if distance < least:
            place = [n + (p - n) * least / distance for p, n in zip(place, nearest)]
    return place


def main():
    build = pathlib.Path(sys.argv[1])
    folder = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else pathlib.Path(__file__).parent)
    spacing = float(sys.argv[3]) if len(sys.argv) > 3 else COARSE
    cloth = dressed = panels(max(spacing, FINEST_DRESSED))
    places = dress(dressed, build)
    if spacing < FINEST_DRESSED:
        cloth = panels(spacing)
        places = [place for coarse, fine in zip(dressed, cloth) for place in interpolated(coarse, fine, places)]
    mesh = {"obj": "shirt.obj", **sewing(*cloth, fold=True)}
    gone = {node for seam in mesh["seams"] for node in seam["b"]}
    capsules = body(stand, [0.0])
    write_npy(folder / "worn_shirt.start.npy",
              [moved_out(place, capsules) for node, place in enumerate(places) if node not in gone])
    write_panels(folder / "shirt.obj", cloth)
    write_scene(folder / "worn_shirt.scene.json", {
        "clothid_scene": 2, "time_step": STEP, "duration": DURATION, "mesh": mesh,
        "initial": {"positions": "worn_shirt.start.npy"},
        "obstacles": body(sway, [ROWS * row for row in range(round(DURATION / ROWS) + 1)], 0.6),
        "materials": {**MATERIALS, "k_stretch": 450}})


if __name__ == "__main__":
    main()
