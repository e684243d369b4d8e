"""The scripts of datasets/experiments and datasets/garment write what stands there."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

from small_scene import SOURCE


class ExperimentsTest(unittest.TestCase):
    def expect_shipped(self, script):
        script = SOURCE / "datasets" / script
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, "-B", script, folder], check=True)
            made = {path.name: path.read_bytes() for path in pathlib.Path(folder).iterdir()}
        shipped = {path.name: path.read_bytes() for path in script.parent.iterdir() if path != script}
        self.assertEqual(sorted(made), sorted(shipped))
        for name, content in shipped.items():
            self.assertEqual(made[name], content, name)

    def test_the_scripts_write_the_shipped_files(self):
        self.expect_shipped("experiments/make_experiments.py")
        self.expect_shipped("garment/make_shirt.py")


if __name__ == "__main__":
    unittest.main()
