"""What the scripts of this folder share: cloth that is cut and sewn, bodies that move, the files of both.

Lengths are in m, times in s, angles in rad.
"""

import json
import math


def smooth(t):
    """0 before t = 0, 1 after t = 1, with a continuous acceleration."""
    t = min(max(t, 0.0), 1.0)
    return t * t * t * (10 - 15 * t + 6 * t * t)


def about(axis, angle):
    return [axis[0] * math.sin(angle / 2), axis[1] * math.sin(angle / 2), axis[2] * math.sin(angle / 2),
            math.cos(angle / 2)]


def product(a, b):
    x, y, z, w = a
    p, q, r, s = b
    return [w * p + x * s + y * r - z * q, w * q - x * r + y * s + z * p, w * r + x * q - y * p + z * s,
            w * s - x * p - y * q - z * r]


def path(pose, times):
    """The rows of a path: `pose(time)` is (place, turn)."""
    rows = []
    for time in times:
        place, turn = pose(time)
        rows.append([round(number, 9) for number in [time, *place, *turn]])
    return rows


def capsule(name, start, end, radius, rows, mu=0.3, distance=0.003):
    """`rows`: its path; None: it stands still."""
    shape = {"name": name, "type": "capsule", "from": start, "to": end, "radius": radius, "mu": mu,
             "contact_distance": distance}
    return shape if rows is None else {**shape, "path": rows}


def cut_cell(a, b, c, d, even):
    """The two triangles of a cell with these corners in turn, whose diagonal changes from cell to cell."""
    return [(a, b, c), (a, c, d)] if even else [(a, b, d), (b, c, d)]


def write_obj(file, places, uv_map, faces, digits=6):
    lines = [f"v {x:.{digits}g} {y:.{digits}g} {z:.{digits}g}" for x, y, z in places]
    lines += [f"vt {u:.{digits}g} {v:.{digits}g}" for u, v in uv_map]
    lines += ["f " + " ".join(f"{node + 1}/{node + 1}" for node in face) for face in faces]
    file.write_text("\n".join(lines) + "\n")


def write_scene(file, scene):
    text = json.dumps(scene, indent=None, separators=(", ", ": "))
    file.write_text(text.replace(', "mesh"', ',\n"mesh"').replace('{"name"', '\n{"name"')
                    .replace(', "materials"', ',\n"materials"') + "\n")
