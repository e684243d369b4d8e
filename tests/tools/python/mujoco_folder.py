"""Where MuJoCo is for the tests: as WebAssembly, in a folder of the build that npm fills once."""

import shutil
import subprocess
import unittest

from small_scene import BUILD

MUJOCO = "@mujoco/mujoco@3.14.0"


def mujoco_folder():
    """The folder. Skips the test where node or the package is not to be had."""
    folder = BUILD / "tests/mujoco"
    if shutil.which("node") is None or shutil.which("npm") is None:
        raise unittest.SkipTest("the package nodejs or npm is absent")
    if not (folder / "node_modules/@mujoco/mujoco").exists():
        folder.mkdir(parents=True, exist_ok=True)
        try:
            subprocess.run(["npm", "install", "--no-audit", "--no-fund", "--prefix", folder, MUJOCO], check=True,
                           capture_output=True, timeout=60)
        except (subprocess.CalledProcessError, subprocess.TimeoutExpired):
            raise unittest.SkipTest(f"npm cannot install {MUJOCO}") from None
    return folder
