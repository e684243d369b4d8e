"""A recording of a cloth that MuJoCo simulates: the truth of another program.

    npm install --prefix FOLDER @mujoco/mujoco@3.14.0
    python3 mujoco_flex.py FOLDER SCENE.json mu=0.2,k_stretch=60 OUTPUT.motion.bin

The cloth starts at rest, and obstacles are planes: the export knows no velocity, and MuJoCo keeps the nodes a radius
away from what they touch, so planes are moved back by it.
"""

import copy
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree
from typing import Any, Dict, List, Optional, Tuple

import clothid
import numpy as np
from numpy.typing import NDArray

RADIUS = 1e-3  # m, what the export gives to a cloth that has no thickness
RATE = 100  # frames per second


def model_of(scene: Dict[str, Any], parameters: Dict[str, float], time_step: float, time_constant: float) -> str:
    """The exported model, with its time step and the time constant of its contacts (the first number of solref), s."""
    moved = copy.deepcopy(scene)
    for obstacle in moved.get("obstacles", []):
        normal = np.array(obstacle["normal"])
        obstacle["point"] = (np.array(obstacle["point"]) - RADIUS * normal / np.linalg.norm(normal)).tolist()
    text = clothid.export(moved, parameters, "mujoco")["export_mujoco.xml"]
    text = re.sub(r'timestep="[^"]*"', f'timestep="{time_step:g}"', text)
    return text.replace('condim="3"/>', f'condim="3" solref="{time_constant:g} 1"/>')


def with_moving_handles(model: str, handles: List[int]) -> Tuple[str, NDArray[np.float64]]:
    """The model with the nodes `handles` as bodies that `poses` moves, and where they start, (H, 3) m, in the order of
    their poses."""
    starts = []
    for node in handles:
        found = re.search(f'<body name="n{node}" pos="([^"]*)">', model)
        assert found is not None
        starts.append([float(number) for number in found.group(1).split()])
        model = model.replace(found.group(0), found.group(0)[:-1] + ' mocap="true">')
    return model, np.array(starts)


def positions_of(model: str, seconds: float, folder: pathlib.Path,
                 poses: Optional[NDArray[np.float64]] = None) -> NDArray[np.float64]:
    """Positions of the nodes, (T, N, 3) m, in the order of the scene. folder: where npm has put MuJoCo. poses: (S, 7 M),
    x, y, z, qw, qx, qy, qz of every body that moves, in their order, at the start of every step."""
    flex = xml.etree.ElementTree.fromstring(model).find("deformable/flex")
    assert flex is not None
    order = [int(name[1:]) for name in flex.attrib["body"].split()]  # n5 is node 5
    program = shutil.copy(pathlib.Path(__file__).with_suffix(".mjs"), folder)
    with tempfile.TemporaryDirectory() as scratch:
        files = [pathlib.Path(scratch) / name for name in ("model.xml", "poses.json")]
        files[0].write_text(model, encoding="utf-8")
        files[1].write_text(json.dumps([] if poses is None else poses.tolist()), encoding="utf-8")
        printed = subprocess.run(["node", program, files[0], str(seconds), str(RATE), files[1]], check=True,
                                 stdout=subprocess.PIPE)
    frames = np.array(json.loads(printed.stdout)).reshape(-1, len(order), 3)
    positions = np.empty_like(frames)
    positions[:, order] = frames
    return positions


def record(scene: Dict[str, Any], parameters: Dict[str, float], folder: pathlib.Path, time_step: float = 5e-5,
           time_constant: float = 0.005) -> clothid.Motion:
    positions = positions_of(model_of(scene, parameters, time_step, time_constant), scene["duration"], folder)
    unmeasured = {key: value for key, value in scene.items() if key != "duration"}
    return clothid.Motion(positions, scene=unmeasured, frame_rate=RATE, provenance=f"MuJoCo 3.14.0, steps of {time_step:g} s")


def main() -> None:
    folder, scene, values, output = sys.argv[1:]
    parameters = {name: float(value) for name, value in (item.split("=") for item in values.split(","))}
    record(json.loads(pathlib.Path(scene).read_text(encoding="utf-8")), parameters, pathlib.Path(folder)).save(output)


if __name__ == "__main__":
    main()
