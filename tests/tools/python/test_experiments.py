"""The script of datasets/experiments writes what stands there."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

from small_scene import SOURCE

FOLDER = SOURCE / "datasets/experiments"
SCRIPT = FOLDER / "make_experiments.py"


class ExperimentsTest(unittest.TestCase):
    def test_the_script_writes_the_shipped_files(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, "-B", SCRIPT, folder], check=True)
            made = {path.name: path.read_bytes() for path in pathlib.Path(folder).iterdir()}
        shipped = {path.name: path.read_bytes() for path in FOLDER.iterdir() if path != SCRIPT}
        self.assertEqual(sorted(made), sorted(shipped))
        for name, content in shipped.items():
            self.assertEqual(made[name], content, name)


if __name__ == "__main__":
    unittest.main()
