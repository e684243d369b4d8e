#!/usr/bin/env python3
"""Writes the scenes of usual tests of cloth, whose sizes are those of the standards: datasets/README.md lists them.

  datasets/experiments/make_experiments.py [FOLDER]

FOLDER is where this script stands, unless given. The same bytes are written every time. Lengths are in m, times in s.
"""

import json
import math
import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from npy_file import write_npy  # noqa: E402

SIDE, NODES = 0.3, 16  # of a square cloth and along each of its edges
TOP_ROW = list(range(NODES))
ACROSS, DOWN = [1, 0, 0], [0, 0, -1]


def scene(duration, mesh, time_step=0.01, **more):
    """A scene of a fabric of medium weight and bending stiffness in still air."""
    materials = {"drag": 0.2, **more.pop("materials", {})}
    return {"clothid_scene": 2, "fabric": "medium", "time_step": time_step, "integrator": "sdirk2",
            "duration": duration, "mesh": mesh, **more, "materials": materials}


def grid(nodes, size, origin, axes):
    return {"grid": {"nodes": nodes, "size": size, "origin": origin, "axes": axes}}


def square(origin, axes):
    return grid([NODES, NODES], [SIDE, SIDE], origin, axes)


def smooth(t):
    """0 before t = 0, 1 after t = 1, with a continuous velocity."""
    t = min(max(t, 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


def times(duration, step):
    return [step * i for i in range(round(duration / step) + 1)]


class Folder:
    """Writes scenes and what belongs to them into one folder."""

    def __init__(self, path):
        self.path = path

    def write(self, name, content):
        lines = ",\n".join(f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in content.items())
        self._write_text(f"{name}.scene.json", "{\n" + lines + "\n}\n")

    def path_of_handles(self, name, nodes, rows):
        """Writes rows (time, [position of each handle]) as the path of `nodes`; returns the key `handles`."""
        columns = [f"{axis}{i}" for i in range(len(nodes)) for axis in "xyz"]
        lines = [",".join(["time", *columns])]
        for time, positions in rows:
            lines.append(",".join(f"{round(value, 6):.10g}" for value in (time, *sum(positions, ()))))
        self._write_text(f"{name}.path.csv", "\n".join(lines) + "\n")
        return {"nodes": nodes, "path": f"{name}.path.csv"}

    def positions(self, name, nodes):
        """Writes the positions of all nodes; returns the file's name."""
        write_npy(self.path / f"{name}.npy", nodes)
        return f"{name}.npy"

    def mesh(self, name, nodes, faces):
        lines = ["v " + " ".join(f"{value:.10g}" for value in node) for node in nodes]
        lines += ["f " + " ".join(str(i + 1) for i in face) for face in faces]
        self._write_text(f"{name}.obj", "\n".join(lines) + "\n")
        return {"obj": f"{name}.obj"}

    def _write_text(self, name, text):
        (self.path / name).write_text(text, encoding="utf-8", newline="\n")


def swing(folder):
    """Held by its upper edge and let go 30 degrees from the vertical."""
    angle = math.radians(30.0)
    out = [0, round(math.sin(angle), 9), round(-math.cos(angle), 9)]
    folder.write("swing", scene(1.5, square([-SIDE / 2, 0, 0], [ACROSS, out]), handles=TOP_ROW))


def shake(folder, name, frequency, stroke):
    """Held by two corners that move to and fro across the cloth."""
    corners = [0, NODES - 1]
    rows = []
    for time in times(2.0, 0.02):
        y = stroke * (1.0 - math.cos(2.0 * math.pi * frequency * time)) / 2.0
        rows.append((time, [(-SIDE / 2, y, 0.0), (SIDE / 2, y, 0.0)]))
    handles = folder.path_of_handles(name, corners, rows)
    folder.write(name, scene(2.0, square([-SIDE / 2, 0, 0], [ACROSS, DOWN]), handles=handles))


def sphere(folder):
    """Falls flat on a sphere, a little beside its middle, drapes and slides."""
    ball = {"name": "ball", "type": "sphere", "center": [0, 0, 0], "radius": 0.1, "mu": 0.3}
    mesh = square([-SIDE / 2 + 0.03, -SIDE / 2 + 0.015, 0.101], [ACROSS, [0, 1, 0]])
    folder.write("sphere", scene(0.7, mesh, obstacles=[ball]))


def over_edge(along, radius):
    """(y, z) at the way `along` a profile that is level up to 0, then a quarter of a circle, then vertical."""
    angle = min(max(along / radius, 0.0), math.pi / 2)
    beyond = max(along - radius * math.pi / 2, 0.0)
    return min(along, 0.0) + radius * math.sin(angle), radius * (math.cos(angle) - 1.0) - beyond


def step_over_edge(along, spacing, radius):
    """How far along that profile the next node is, `spacing` away in a straight line: an edge of the mesh is a chord."""
    low, high = along, along + 2.0 * spacing
    for _ in range(60):
        middle = 0.5 * (low + high)
        if math.dist(over_edge(along, radius), over_edge(middle, radius)) < spacing:
            low = middle
        else:
            high = middle
    return high


def edge(folder):
    """Lies on a table and hangs over its edge, whose radius is 25 mm; its end on the table is pulled back by 115 mm.

    The table is a box, and its contact distance makes the edge round. The cloth starts without strain, at rest.
    """
    nodes, size, flat, radius, speed, starts = [5, 51], [0.1, 0.4], 0.18, 0.025, 0.05, 0.2
    spacing = size[1] / (nodes[1] - 1)
    profile, along = [(-flat, 0.0)], -flat
    for _ in range(nodes[1] - 1):
        along = step_over_edge(along, spacing, radius)
        profile.append(over_edge(along, radius))
    columns = [size[0] * (i / (nodes[0] - 1) - 0.5) for i in range(nodes[0])]
    start = [(x, round(y, 9), round(z, 9)) for y, z in profile for x in columns]
    rows = []
    for time in times(2.4, 0.05):
        gone = time - starts / 2 if time > starts else time * time / (2.0 * starts)
        rows.append((time, [(x, -flat - speed * gone, 0.0) for x in columns]))
    handles = folder.path_of_handles("edge", list(range(nodes[0])), rows) | {"clamp": True}
    low, high = [-0.3, -0.6, -0.6], [0.3, 0.0, -radius]
    corners = [[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    box = {"name": "table", "type": "mesh", "vertices": corners,
           "faces": [list(face) for a, b, c, d in quads for face in ((a, b, c), (a, c, d))], "mu": 0.3,
           "contact_distance": radius}
    mesh = grid(nodes, size, [-size[0] / 2, -flat, 0], [ACROSS, [0, 1, 0]])
    initial = {"positions": folder.positions("edge.start", start)}
    folder.write("edge", scene(2.4, mesh, time_step=0.02, initial=initial, handles=handles, obstacles=[box],
                               materials={"damping": 0.3}))


def incline(folder):
    """Lies on an incline of 25 degrees and slides where mu is below tan 25 degrees = 0.466."""
    angle = math.radians(25.0)
    slope = {"name": "slope", "type": "plane", "point": [0, 0, 0],
             "normal": [round(math.sin(angle), 9), 0, round(math.cos(angle), 9)], "mu": 0.3}
    down = [round(math.cos(angle), 9), 0, round(-math.sin(angle), 9)]
    folder.write("incline", scene(1.0, square([0, -SIDE / 2, 0], [down, [0, 1, 0]]), obstacles=[slope]))


def cantilever(folder):
    """ASTM D1388, option A: a strip of 25 mm, slid out over the edge until its tip is 41.5 degrees below it.

    That is an overhang of twice the bending length, 39 mm of the medium fabric. What lies under the slide is left out:
    the row of nodes at the edge clamps the strip, which starts straight.
    """
    nodes, size = [7, 17], [0.025, 0.039]
    mesh = grid(nodes, size, [-size[0] / 2, 0, 0], [ACROSS, [0, 1, 0]])
    folder.write("cantilever", scene(1.0, mesh, handles={"nodes": list(range(nodes[0])), "clamp": True}))


def tensile(folder):
    """ISO 13934-1: a strip 50 mm wide, 200 mm between the jaws, which move apart at 100 mm/min; here by 4 %."""
    nodes, size, speed, duration = [6, 25], [0.05, 0.2], 0.1 / 60.0, 4.8
    columns = [size[0] * (i / (nodes[0] - 1) - 0.5) for i in range(nodes[0])]
    held = list(range(nodes[0])) + list(range(nodes[0] * (nodes[1] - 1), nodes[0] * nodes[1]))
    rows = [(time, [(x, 0.0, speed * time) for x in columns] + [(x, 0.0, -size[1]) for x in columns])
            for time in times(duration, 0.4)]
    handles = folder.path_of_handles("tensile", held, rows) | {"clamp": True}
    folder.write("tensile", scene(duration, grid(nodes, size, [-size[0] / 2, 0, 0], [ACROSS, DOWN]), time_step=0.04,
                                  handles=handles))


def cusick(folder):
    """ISO 9073-9: a circular specimen of 30 cm hangs over a disc of 18 cm, held on it by a second disc.

    Nodes between the discs are handles; the edge is in the middle between the last two rings that are held. The free
    ring starts with six low waves, without which chance would choose the folds.
    """
    disc, specimen, free_rings, held_rings, around, waves = 0.09, 0.15, 6, 4, 48, 6
    width = (specimen - disc) / (free_rings + 0.5)
    radii = [0.035] + [specimen - width * i for i in reversed(range(free_rings + held_rings))]
    flat, start = [(0.0, 0.0, 0.0)], [(0.0, 0.0, 0.0)]
    for radius in radii:
        beyond = max(radius - disc - width / 2, 0.0) / (specimen - disc)
        for i in range(around):
            angle = 2.0 * math.pi * i / around
            x, y = round(radius * math.cos(angle), 9), round(radius * math.sin(angle), 9)
            flat.append((x, y, 0.0))
            start.append((x, y, round(0.003 * beyond**2 * math.cos(waves * angle), 9)))
    faces = [(0, 1 + i, 1 + (i + 1) % around) for i in range(around)]
    for ring in range(len(radii) - 1):
        for i in range(around):
            a, b = 1 + ring * around + i, 1 + ring * around + (i + 1) % around
            quad = (a, a + around, b + around, b)
            diagonals = ((0, 1, 2), (0, 2, 3)) if (i + ring) % 2 == 0 else ((0, 1, 3), (1, 2, 3))
            faces += [tuple(quad[k] for k in corners) for corners in diagonals]
    held = list(range(1 + around * (1 + held_rings)))
    mesh = folder.mesh("cusick", flat, faces)
    initial = {"positions": folder.positions("cusick.start", start)}
    folder.write("cusick", scene(1.0, mesh, initial=initial, handles=held))


def table(folder):
    """Hangs 10 mm over a table; its upper edge goes down in an arc, lays the cloth out and drags it on by 40 mm."""
    top = {"name": "table", "type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1], "mu": 0.3}
    start, lay, drag = 0.31, 1.2, 0.4
    rows = []
    for time in times(lay + drag, 0.05):
        angle = math.pi / 2 * smooth(time / lay)
        y = start * math.sin(angle) + 0.04 * smooth((time - lay) / drag)
        z = start * math.cos(angle)
        rows.append((time, [(SIDE * (i / (NODES - 1) - 0.5), y, z) for i in range(NODES)]))
    handles = folder.path_of_handles("table", TOP_ROW, rows)
    folder.write("table", scene(lay + drag, square([-SIDE / 2, 0, start], [ACROSS, DOWN]), handles=handles,
                                obstacles=[top]))


def main():
    folder = Folder(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent)
    swing(folder)
    shake(folder, "shake_slow", 1.0, 0.06)
    shake(folder, "shake_fast", 2.5, 0.03)
    for write in (sphere, edge, incline, cantilever, tensile, cusick, table):
        write(folder)


if __name__ == "__main__":
    main()
