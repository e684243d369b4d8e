"""The scripts of datasets/experiments and datasets/garment write what stands there."""

import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

from small_scene import BUILD, SOURCE, run


class ExperimentsTest(unittest.TestCase):
    def made_by(self, script, *arguments):
        """What a script of datasets/ writes into a folder, by name."""
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, "-B", SOURCE / "datasets" / script, *arguments, folder]
            subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
            return {path.name: path.read_bytes() for path in pathlib.Path(folder).iterdir()}

    def shipped(self, folder):
        paths = (SOURCE / "datasets" / folder).iterdir()
        return {path.name: path.read_bytes() for path in paths if path.is_file() and path.suffix != ".py"}

    def expect_same(self, made, shipped):
        self.assertEqual(sorted(made), sorted(shipped))
        for name, content in shipped.items():
            self.assertEqual(made[name], content, name)

    def test_the_scripts_write_the_shipped_files(self):
        self.expect_same(self.made_by("experiments/make_experiments.py"), self.shipped("experiments"))
        made = {**self.made_by("garment/make_shirt.py"), **self.made_by("garment/make_sleeve.py")}
        made.update(self.made_by("garment/wear_shirt.py", BUILD))
        shipped, start = self.shipped("garment"), "worn_shirt.start.npy"
        places, shipped_places = (struct.unpack("<1224d", content.pop(start)[128:]) for content in (made, shipped))
        self.expect_same(made, shipped)
        # Another processor rounds differently, and how the shirt is thrown on enlarges that.
        self.assertLess(max(abs(a - b) for a, b in zip(places, shipped_places)), 1e-4)

    def test_a_worn_shirt_of_finer_triangles_starts_outside_of_the_body(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            script = SOURCE / "datasets/garment/wear_shirt.py"
            command = [sys.executable, "-B", script, BUILD, folder, "0.025"]
            subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
            short = json.loads((folder / "worn_shirt.scene.json").read_text())
            (folder / "short.json").write_text(json.dumps({**short, "duration": 0.1}))
            run("simulate", "--scene", folder / "short.json", "--output", folder / "short.bin")
            rows = run("motion", "check", folder / "short.bin").splitlines()
        start = next(row for row in rows if row.startswith("start   "))
        self.assertIn("no node inside an obstacle", start)


if __name__ == "__main__":
    unittest.main()
