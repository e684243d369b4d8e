#!/usr/bin/env python3
"""Makes recordings for a benchmark of predictions: six motions of each of three fabrics, by a model that fits lack.

  PYTHONPATH=build/release/python datasets/transfer/transfer_set.py --output transfer
      [--fabrics light,medium,heavy] [--motions swing,shake,drape,pull,slide,fold]

Writes for each of them FABRIC_MOTION.motion.bin, seen at 50 Hz with noise of 2 mm by who fits it,
FABRIC_MOTION.truth.npy, (T, N, 3) m of the same frames without noise, and FABRIC_MOTION.scene.json, what is known of it
beforehand. What is there already is left alone. datasets/transfer/README.md says what the truth has and fits do not.
"""
import argparse
import json
import math
import os
import pathlib

os.environ.setdefault("OMP_NUM_THREADS", "1")

import clothid  # noqa: E402
import numpy as np  # noqa: E402

NODES, SIZE = 11, 0.3  # of the scene that fits have, m
STEP, DURATION, FRAME_RATE, NOISE = 0.01, 1.5, 50.0, 0.002  # s, s, Hz, m
FINER_STEPS, FINER_CELLS = 4, 3  # of the truth: steps of 2.5 ms, 31 x 31 nodes
MU = {"light": 0.25, "medium": 0.35, "heavy": 0.45}

# Yarns that stiffen, air that brakes across the cloth more than along it, and a seam across its middle, two cells of
# the scene's mesh wide, that bends `seam` times as hard.
FABRICS = {
    "light": {"density": 0.08, "k_warp": 90, "k_weft": 60, "k_shear": 25, "stiffening_warp": 8, "stiffening_weft": 5,
              "k_bend": 1e-5, "seam": 20, "drag": 0.0, "drag_normal": 0.25, "drag_tangential": 0.03, "damping": 0.01},
    "medium": {"density": 0.16, "k_warp": 160, "k_weft": 110, "k_shear": 40, "stiffening_warp": 10,
               "stiffening_weft": 6, "k_bend": 5e-5, "seam": 15, "drag": 0.0, "drag_normal": 0.35,
               "drag_tangential": 0.05, "damping": 0.02},
    "heavy": {"density": 0.3, "k_warp": 300, "k_weft": 220, "k_shear": 80, "stiffening_warp": 15, "stiffening_weft": 10,
              "k_bend": 2e-4, "seam": 10, "drag": 0.0, "drag_normal": 0.5, "drag_tangential": 0.08, "damping": 0.04},
}
# What is believed before a fit: the fabrics weigh what they weigh, all else is a guess.
GUESS = {"bending": "patches", "k_stretch": 120, "k_bend": 1e-4, "drag": 0.1, "damping": 0.01}

EDGE = list(range(NODES))
CORNERS = [0, NODES - 1]


def grid(origin, axes=((1, 0, 0), (0, 1, 0))):
    return {"grid": {"nodes": [NODES, NODES], "size": [SIZE, SIZE], "origin": list(origin),
                     "axes": [list(axis) for axis in axes]}}


def poses(place, turn=lambda time: 0.0):
    """A body's path: place(t) m, turned about y by turn(t) rad."""
    rows = []
    for time in np.linspace(0.0, DURATION, 76):
        half = 0.5 * turn(time)
        rows.append([float(time), *map(float, place(time)), 0.0, math.sin(half), 0.0, math.cos(half)])
    return rows


def smooth(time, begin, end):
    """0 before `begin`, 1 after `end`, without a jump of its rate."""
    share = min(max((time - begin) / (end - begin), 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)


def fold_angle(time):
    return 0.85 * math.pi * smooth(time, 0.1, 1.2)


MOTIONS = {
    "swing": {"mesh": grid((0, 0, 0)), "handles": EDGE},
    "shake": {"mesh": grid((0, 0, 0), ((1, 0, 0), (0, 0, -1))),
              "handles": {"nodes": EDGE, "poses": poses(
                  lambda t: (0, 0.05 * smooth(t, 0, 0.3) * math.sin(2 * math.pi * 2 * t), 0))}},
    "drape": {"mesh": grid((-0.14, -0.16, 0.115)), "obstacles": [
        {"type": "sphere", "center": [0, 0, 0], "radius": 0.1}]},
    "pull": {"mesh": grid((-0.05, -0.15, 0.002)), "handles": {"nodes": EDGE[:1] + EDGE[-1:], "poses": None},
             "obstacles": [{"type": "table", "center": [0.2, 0, 0], "normal": [0, 0, 1], "size": [0.44, 0.6],
                            "thickness": 0.04}]},
    "slide": {"mesh": grid((0, 0, 0.002)), "gravity": [9.81 * math.sin(math.radians(32)), 0,
                                                      -9.81 * math.cos(math.radians(32))],
              "obstacles": [{"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1]},
                            {"type": "capsule", "name": "bar", "from": [0.45, -0.5, 0], "to": [0.45, 0.8, 0],
                             "radius": 0.02}]},
    "fold": {"mesh": grid((0, 0, 0.002)), "handles": {"nodes": [0, NODES * (NODES - 1)], "poses": poses(
        lambda t: (0.15 - 0.15 * math.cos(fold_angle(t)), 0, 0.15 * math.sin(fold_angle(t))))},
             "obstacles": [{"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1]}]},
}
# Pulled off a table by the edge that hangs over, at the left.
MOTIONS["pull"]["handles"] = {"nodes": [NODES * row for row in range(NODES)], "poses": poses(
    lambda t: (-0.1 * smooth(t, 0, 1.2), 0, -0.15 * smooth(t, 0, 1.2)))}


def scene_of(fabric, motion):
    """What who fits or predicts knows."""
    scene = {"clothid_scene": 2, "time_step": STEP, "duration": DURATION, "initial": {"positions": "rest"},
             **MOTIONS[motion], "materials": {"density": FABRICS[fabric]["density"], **GUESS}}
    scene["obstacles"] = [{**obstacle, "mu": MU[fabric]} for obstacle in scene.get("obstacles", [])]
    return scene


def finer_handles(nodes):
    """Of the finer mesh; nodes between two handles of a grid line are handles, too."""
    held = np.zeros((NODES, NODES), dtype=bool)
    held.flat[nodes] = True
    fine = np.zeros((FINER_CELLS * (NODES - 1) + 1,) * 2, dtype=bool)
    fine[::FINER_CELLS, ::FINER_CELLS] = held
    for i in range(1, FINER_CELLS):
        fine[i::FINER_CELLS, ::FINER_CELLS] = held[:-1] & held[1:]
        fine[::FINER_CELLS, i::FINER_CELLS] = held[:, :-1] & held[:, 1:]
    return np.flatnonzero(fine).tolist()


def finer_mesh(scene):
    count = FINER_CELLS * (NODES - 1) + 1
    fine = {**scene, "mesh": {"grid": {**scene["mesh"]["grid"], "nodes": [count, count]}}}
    handles = scene.get("handles", [])
    fine["handles"] = ({**handles, "nodes": finer_handles(handles["nodes"])} if isinstance(handles, dict)
                       else finer_handles(handles))
    return fine


def truth_scene(fabric, motion):
    constants = dict(FABRICS[fabric])
    seam = constants.pop("seam")
    scene = {**finer_mesh(scene_of(fabric, motion)), "time_step": STEP / FINER_STEPS}
    rigidity = np.full((2 * NODES - 1, 2 * NODES - 1), constants.pop("k_bend"))
    rigidity[:, NODES - 2:NODES + 1] *= seam
    scene["materials"] = {"membrane": "yarn", "bending": "patches", "k_bend": float(np.exp(np.log(rigidity).mean())),
                          **constants}
    scene["fields"] = {"k_bend": rigidity.tolist()}
    return scene


def true_frames(fabric, motion):
    """(T, N, 3) m, of the nodes of the scene at its frame rate."""
    scene = truth_scene(fabric, motion)
    every = round(1.0 / (FRAME_RATE * scene["time_step"]))
    frames = np.asarray(clothid.Rollout(scene).positions)[::every]
    columns, rows = scene["mesh"]["grid"]["nodes"]
    grid = frames.reshape(len(frames), rows, columns, 3)[:, ::FINER_CELLS, ::FINER_CELLS]
    return grid.reshape(len(frames), -1, 3)


def handles_of(scene):
    handles = scene.get("handles", [])
    return handles["nodes"] if isinstance(handles, dict) else handles


def make(fabric, motion, folder):
    """The files of one of them."""
    truth_file, recording = folder / f"{fabric}_{motion}.truth.npy", folder / f"{fabric}_{motion}.motion.bin"
    scene = scene_of(fabric, motion)
    (folder / f"{fabric}_{motion}.scene.json").write_text(json.dumps(scene), encoding="utf-8")
    if truth_file.exists() and recording.exists():
        return
    truth = true_frames(fabric, motion)
    seed = [sorted(FABRICS).index(fabric), sorted(MOTIONS).index(motion)]
    seen = truth + NOISE * np.random.default_rng(seed).normal(size=truth.shape)
    fitted = {key: value for key, value in scene.items() if key != "duration"}
    clothid.Motion(seen, scene=fitted, frame_rate=FRAME_RATE, sigma=np.full(truth.shape[1], NOISE)).save(recording)
    np.save(truth_file, truth.astype(np.float32))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=pathlib.Path, required=True)
    parser.add_argument("--fabrics", default=",".join(FABRICS))
    parser.add_argument("--motions", default=",".join(MOTIONS))
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    for fabric in options.fabrics.split(","):
        for motion in options.motions.split(","):
            make(fabric, motion, options.output)


if __name__ == "__main__":
    main()
