"""A wheel works without the build folder: in a folder of its own, moved, and with its own libraries.

It is made of what stands in the build folder. With CLOTHID_WHEEL_BUILD=FOLDER, a new one, everything is built there
first, as `pip wheel` does it for a user: some ten minutes.
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

from small_scene import BUILD, SOURCE, over_ball, run

WHEEL_BUILD = os.environ.get("CLOTHID_WHEEL_BUILD", str(BUILD))

FIT = """
import json, sys, clothid
result = clothid.identify(clothid.Motion.load(sys.argv[1]), fit=["mu"])
maps = {line.split()[-1] for line in open("/proc/self/maps") if "clothid" in line}
print(json.dumps([result.values, clothid.__file__, sorted(maps)]))
"""


class WheelTest(unittest.TestCase):
    def setUp(self):
        if subprocess.run([sys.executable, "-c", "import setuptools, pip, wheel"], capture_output=True).returncode != 0:
            self.skipTest("a package is absent: python3-pip, python3-setuptools or python3-wheel")
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def pip(self, *arguments):
        done = subprocess.run([sys.executable, "-m", "pip", "--disable-pip-version-check", *arguments],
                              cwd=self.folder, capture_output=True, text=True,
                              env={**os.environ, "CLOTHID_BUILD_DIR": WHEEL_BUILD, "PYTHONPATH": "",
                                   "PYTHONDONTWRITEBYTECODE": "1"})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def expect_page_fits_the_drape(self, place):
        page = (SOURCE / "tools/python/README.md").read_text(encoding="utf-8")
        (self.folder / "datasets").symlink_to(SOURCE / "datasets")
        block = re.search(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL).group(1)
        printed = subprocess.run([sys.executable, "-B", "-c", block], cwd=self.folder, check=True, capture_output=True,
                                 text=True, env={"PYTHONPATH": str(place)}).stdout
        self.assertAlmostEqual(float(re.search(r"\nmu +([0-9.]+) ", printed)[1]), 0.24, delta=1e-5)
        self.assertTrue((self.folder / "report.html").exists())

    def test_wheel_fits_in_a_clean_folder(self):
        before = sorted(path.relative_to(SOURCE) for path in (SOURCE / "tools/python").rglob("*"))
        self.pip("wheel", "--no-index", "--no-build-isolation", "--no-deps", "--wheel-dir", "wheels",
                 SOURCE / "tools/python")
        self.assertEqual(sorted(path.relative_to(SOURCE) for path in (SOURCE / "tools/python").rglob("*")), before)
        (wheel,) = (self.folder / "wheels").glob("clothid-*.whl")
        self.pip("install", "--no-index", "--no-deps", "--no-compile", "--target", "installed", wheel)
        place = self.folder / "elsewhere"
        shutil.move(self.folder / "installed", place)
        self.assertTrue((place / "clothid/py.typed").exists() and (place / "clothid/_clothid.pyi").exists())
        (self.folder / "scene.json").write_text(json.dumps(over_ball()), encoding="utf-8")
        recording = self.folder / "recording.motion.bin"
        run("simulate", "--scene", self.folder / "scene.json", "--set", "mu=0.2", "--output", recording)
        run("identify", "--target", recording, "--fit", "mu", "--output", self.folder / "result")
        told = json.loads((self.folder / "result/result.json").read_text(encoding="utf-8"))
        printed = subprocess.run([sys.executable, "-B", "-c", FIT, recording], cwd=self.folder, check=True,
                                 capture_output=True, text=True, env={"PYTHONPATH": str(place)}).stdout
        values, file, maps = json.loads(printed)
        self.assertEqual(values, {"mu": told["parameters"]["mu"]["value"]})
        self.assertEqual(pathlib.Path(file), place / "clothid/__init__.py")
        libraries = [path for path in maps if ".so" in path]
        self.assertEqual(len(libraries), 5, libraries)
        for library in libraries:
            self.assertTrue(library.startswith(str(place)), library)
        self.expect_page_fits_the_drape(place)
        for name in zipfile.ZipFile(wheel).namelist():
            self.assertNotIn(WHEEL_BUILD.encode(), zipfile.ZipFile(wheel).read(name), name)


if __name__ == "__main__":
    unittest.main()
