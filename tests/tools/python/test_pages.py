"""What the pages show runs as it stands: the blocks of the READMEs, the notebook, the examples; and types fit."""

import importlib.util
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import clothid
import numpy as np
from small_scene import BUILD, SOURCE, over_ball

PYTHON = SOURCE / "tools/python"


def run(code, folder):
    """What a script prints in a folder that has the datasets."""
    (folder / "datasets").symlink_to(SOURCE / "datasets")
    done = subprocess.run([sys.executable, "-B", "-c", code], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(f"{code}\n{done.stderr}")
    return done.stdout


def load(name):
    spec = importlib.util.spec_from_file_location(name, PYTHON / f"examples/{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class PageTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def blocks(self, page):
        return re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)

    def test_ten_lines_fit_the_drape(self):
        block = self.blocks(PYTHON / "README.md")[0]
        self.assertEqual(self.blocks(SOURCE / "README.md"), [block])
        self.assertLessEqual(len(block.strip().splitlines()), 12)
        printed = run(block, self.folder)
        for name, truth in (("mu", 0.24), ("k_stretch", 70.0)):
            estimate = float(re.search(rf"\n{name} +([0-9.]+) ", printed)[1])
            self.assertAlmostEqual(estimate / truth, 1.0, delta=1e-5)
        self.assertIn("usable with care: the error of the time step exceeds the noise", printed)
        self.assertGreater((self.folder / "report.html").stat().st_size, 1000000)

    def test_block_for_scipy(self):
        if importlib.util.find_spec("scipy") is None:
            self.skipTest("the package python3-scipy is absent")
        printed = run(self.blocks(PYTHON / "README.md")[1], self.folder)
        self.assertAlmostEqual(float(printed.strip("[]\n ")), 0.2, places=6)

    def test_notebook(self):
        notebook = json.loads((PYTHON / "tutorial.ipynb").read_text(encoding="utf-8"))
        cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
        self.assertEqual([cell["outputs"] for cell in cells], [[]] * len(cells))
        names = {}
        for cell in cells:
            exec(compile(cell["source"], "tutorial.ipynb", "exec"), names)  # pylint: disable=exec-used
        self.assertEqual(names["findings"].worst, "ok")
        self.assertEqual(names["result"].verdict.usable, "with care")  # of steps of 10 ms
        for name, truth in (("mu", 0.25), ("k_stretch", 80.0)):
            estimate = names["result"][name]
            self.assertLess(abs(estimate.value - truth), 4.0 * estimate.std, name)

    def test_links_lead_somewhere(self):
        for link in re.findall(r"\]\(([^)#:]+)\)", (PYTHON / "README.md").read_text(encoding="utf-8")):
            self.assertTrue((PYTHON / link).exists(), link)


class ExampleTest(unittest.TestCase):
    TRUTH = {"mu": 0.2, "k_stretch": 80.0}
    START = {"mu": 0.3, "k_stretch": 110.0}

    def test_least_squares_reaches_the_truth(self):
        if importlib.util.find_spec("scipy") is None:
            self.skipTest("the package python3-scipy is absent")
        found = load("least_squares").fit(clothid.Scene(over_ball()), self.TRUTH, self.START)
        for name, truth in self.TRUTH.items():
            self.assertAlmostEqual(found[name] / truth, 1.0, delta=1e-7, msg=name)

    def test_torch_reaches_the_truth(self):
        if importlib.util.find_spec("torch") is None:
            self.skipTest("PyTorch is absent")
        import torch

        scene = clothid.Scene(over_ball())
        measured = torch.from_numpy(clothid.simulate(scene, self.TRUTH).positions.copy())
        found = load("torch_rollout").fit(scene, list(self.START), list(self.START.values()), measured)
        np.testing.assert_allclose(found.numpy(), list(self.TRUTH.values()), rtol=1e-4)

    def test_benchmark_runs(self):
        done = subprocess.run([sys.executable, "-B", PYTHON / "examples/benchmark_calls"], capture_output=True,
                              text=True, check=True)
        self.assertEqual(len(done.stdout.splitlines()), 6)


class TypeTest(unittest.TestCase):
    def test_types_are_strict(self):
        mypy = shutil.which("mypy", path="/usr/bin:" + os.environ["PATH"])
        if mypy is None:
            self.skipTest("the package mypy is absent")
        with tempfile.TemporaryDirectory() as cache:
            done = subprocess.run([mypy, "--strict", "--cache-dir", cache, "--python-executable", sys.executable,
                                   BUILD / "python/clothid", *sorted((PYTHON / "examples").glob("*.py"))],
                                  capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_stubs_name_what_is_there(self):
        stubs = (BUILD / "python/clothid/_clothid.pyi").read_text(encoding="utf-8")
        told = set(re.findall(r"^(?:class|def) (\w+)", stubs, re.MULTILINE))
        module = clothid._clothid
        self.assertEqual(told, {name for name in dir(module) if not name.startswith("__")})
        for name in ("Motion", "Rollout", "Scene", "Fit"):
            body = re.search(rf"^class {name}:\n(.*?)(?=^\S|\Z)", stubs, re.MULTILINE | re.DOTALL).group(1)
            members = set(re.findall(r"def (\w+)", body)) - {"__init__"}
            there = {member for member in vars(getattr(module, name)) if not member.startswith("_")}
            self.assertEqual(members, there, name)


if __name__ == "__main__":
    unittest.main()
