"""Builds a wheel of clothid: the package, its compiled module and clothid's own libraries beside it.

    pip wheel --no-build-isolation --no-deps tools/python

builds all of clothid in build/wheel; with CLOTHID_BUILD_DIR=build/release what is already built there is taken. Ceres
and SuiteSparse are those of the system, so the wheel runs where tools/setup ran. Nothing is written beside the sources.
"""

import os
import pathlib
import re
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

os.environ.setdefault("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count() or 1))  # make takes one processor by itself
ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(os.environ.get("CLOTHID_BUILD_DIR", ROOT / "build" / "wheel")).resolve()


def version():
    found = re.search(r"project\(clothid VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))
    return found.group(1)


class CMakeBuild(build_ext):
    """Has CMake build the module and install it with its libraries."""

    def build_extension(self, extension):
        if not (BUILD / "CMakeCache.txt").exists():
            subprocess.run(["cmake", "-S", ROOT, "-B", BUILD, "-DCMAKE_BUILD_TYPE=Release",
                            "-DCLOTHID_BUILD_TESTS=OFF", f"-DPython3_EXECUTABLE={sys.executable}"], check=True)
        subprocess.run(["cmake", "--build", BUILD, "--target", "clothid_python"], check=True)
        folder = pathlib.Path(self.build_lib).resolve()
        subprocess.run(["cmake", "--install", BUILD, "--component", "wheel", "--strip", "--prefix", folder], check=True)
        # A wheel has no links: the names that the linker looks for become the files.
        for link in folder.glob("clothid/*.so.*"):
            if link.is_symlink():
                link.resolve().replace(link)


work = BUILD / "python_wheel"
work.mkdir(parents=True, exist_ok=True)
setup(
    name="clothid",
    version=version(),
    description="Fits friction and stiffness of cloth to recorded motion",
    license="Apache-2.0; binaries link GPL parts of SuiteSparse",
    packages=["clothid"],
    package_dir={"clothid": "package"},
    package_data={"clothid": ["py.typed", "*.pyi"]},
    ext_modules=[Extension("clothid._clothid", [])],
    cmdclass={"build_ext": CMakeBuild},
    install_requires=["numpy"],
    python_requires=">=3.9",
    zip_safe=False,
    options={"build": {"build_base": str(work)}, "egg_info": {"egg_base": str(work)}},
)
