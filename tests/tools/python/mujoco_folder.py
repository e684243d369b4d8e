"""Where MuJoCo is for the tests: as WebAssembly, in a folder of the build that npm fills once."""

import fcntl
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from small_scene import BUILD

VERSION = "3.14.0"
FOLDER = BUILD / f"tests/mujoco-{VERSION}"


def install(folder: pathlib.Path) -> None:
    """Makes the folder whole or not at all, so that nobody reads files that are still being written."""
    package = f"@mujoco/mujoco@{VERSION}"
    with tempfile.TemporaryDirectory(dir=folder.parent) as scratch:
        filled = pathlib.Path(scratch) / "filled"
        filled.mkdir()
        try:
            subprocess.run(["npm", "install", "--no-audit", "--no-fund", "--prefix", filled, package], check=True,
                           capture_output=True, timeout=60)
        except (subprocess.CalledProcessError, subprocess.TimeoutExpired):
            raise unittest.SkipTest(f"npm cannot install {package}") from None
        filled.rename(folder)


def mujoco_folder() -> pathlib.Path:
    """The folder; tests that run side by side share it. Skips the test where node or the package is not to be had."""
    if shutil.which("node") is None or shutil.which("npm") is None:
        raise unittest.SkipTest("the package nodejs or npm is absent")
    FOLDER.parent.mkdir(parents=True, exist_ok=True)
    with open(f"{FOLDER}.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # until the file is closed
        if not FOLDER.exists():
            install(FOLDER)
    return FOLDER
