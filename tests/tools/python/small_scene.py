"""What the tests of the Python module share: scenes that simulate in milliseconds, and the programs."""

import os
import pathlib
import subprocess

SOURCE = pathlib.Path(os.environ["CLOTHID_SOURCE_DIR"])
BUILD = pathlib.Path(os.environ["CLOTHID_BINARY_DIR"])


def hung(nodes=4, steps=5, time_step=0.01):
    """A square of cloth, held along its first row."""
    return {
        "clothid_scene": 1,
        "time_step": time_step,
        "duration": steps * time_step,
        "mesh": {"grid": {"nodes": [nodes, nodes], "size": [0.2, 0.2]}},
        "initial": {"positions": "rest"},
        "handles": list(range(nodes)),
        "materials": {"density": 0.15, "k_stretch": 100, "k_bend": 0, "drag": 0},
    }


def over_ball(nodes=6, steps=20):
    """The same, falling over a sphere."""
    scene = hung(nodes, steps)
    scene["obstacles"] = [
        {"name": "ball", "type": "sphere", "center": [0.1, 0.15, -0.105], "radius": 0.1, "mu": 0.3}
    ]
    return scene


def run(program, *arguments):
    """One of the built programs; its output."""
    return subprocess.run([BUILD / program, *arguments], check=True, capture_output=True, text=True).stdout
