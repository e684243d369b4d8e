"""The module does what the programs do, to the last digit."""

import json
import pathlib
import tempfile
import unittest

import clothid
import numpy as np
from small_scene import over_ball, run


class ProgramTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.scene = self.folder / "scene.json"
        self.scene.write_text(json.dumps(over_ball()), encoding="utf-8")
        self.file = self.folder / "recording.motion.bin"
        run("simulate", "--scene", self.scene, "--set", "mu=0.2,k_stretch=70", "--noise", "0.001", "--seed", "3",
            "--output", self.file)

    def test_simulate_gives_the_same_bytes(self):
        motion = clothid.simulate(self.scene, {"mu": 0.2, "k_stretch": 70}, noise=0.001, seed=3)
        motion.save(self.folder / "again.motion.bin")
        self.assertEqual((self.folder / "again.motion.bin").read_bytes(), self.file.read_bytes())

    def test_check_finds_the_same(self):
        told = json.loads(run("motion", "check", self.file, "--json"))["findings"]
        found = clothid.check(clothid.Motion.load(self.file))
        self.assertEqual([(item["what"], item["verdict"], item["value"]) for item in told],
                         [(finding.what, finding.severity, finding.value) for finding in found])

    def expect_same_result(self, flags, **options):
        output = self.folder / "result"
        run("identify", "--target", self.file, *flags, "--output", output)
        told = json.loads((output / "result.json").read_text(encoding="utf-8"))
        result = clothid.identify(clothid.Motion.load(self.file), **options)
        for key in ("seconds",):
            told.pop(key)
            result.data.pop(key)
        told.pop("provenance")
        self.assertEqual(result.data.pop("provenance")["input_sha256"] != "", True)
        self.assertEqual(result.data, told)

    def test_estimates_are_the_same(self):
        self.expect_same_result(["--fit", "mu,k_stretch"], fit=["mu", "k_stretch"])

    def test_options_mean_the_same(self):
        self.expect_same_result(
            ["--fit", "mu,k_stretch,time_offset", "--start", "mu=0.4", "--upper", "mu=0.9", "--prior",
             "k_stretch=90:1.5", "--sigma", "0.0015", "--loss", "huber:2", "--jacobian", "sensitivity", "--horizon",
             "full", "--profile", "mu", "--holdout_frames", "15:18", "--initial", "smoothed", "--check_gradients"],
            fit="mu,k_stretch,time_offset", start={"mu": 0.4}, upper={"mu": 0.9}, prior={"k_stretch": (90, 1.5)},
            sigma=0.0015, loss="huber:2", jacobian="sensitivity", horizon="full", profile=["mu"],
            holdout_frames=(15, 18), initial="smoothed", check_gradients=True)

    def test_repetitions_are_judged_the_same(self):
        again = self.folder / "again.motion.bin"
        run("simulate", "--scene", self.scene, "--set", "mu=0.2,k_stretch=90", "--noise", "0.001", "--output", again)
        output = self.folder / "result"
        run("identify", "--target", f"{self.file},{again}", "--repeat", "--fit", "mu,k_stretch", "--output", output)
        told = json.loads((output / "result.json").read_text(encoding="utf-8"))["repetitions"]
        motions = [clothid.Motion.load(file) for file in (self.file, again)]
        found = clothid.identify(motions, fit=["mu", "k_stretch"], repeat=True).repetitions
        self.assertEqual(found["parameters"], told["parameters"])
        self.assertIsNone(clothid.identify(motions[0], fit="mu").repetitions)

    def test_plans_are_the_same(self):
        output = self.folder / "plan"
        run("plan", "--scenes", self.scene, "--fit", "mu,k_stretch", "--sigma", "0.002", "--prior", "mu=0.2:0.1",
            "--draws", "1", "--output", output)
        told = json.loads((output / "plan.json").read_text(encoding="utf-8"))
        plan = clothid.plan(self.scene, ["mu", "k_stretch"], sigma=0.002, prior={"mu": (0.2, 0.1)}, draws=1)
        for data in (told, plan.data):
            data.pop("provenance")
        self.assertEqual(plan.data, told)
        name, = plan.candidates
        self.assertIn(name, str(plan))
        lower, upper = plan.interval(name, "mu")
        self.assertLess(lower, 0.3)
        self.assertLess(0.3, upper)
        plan.report(self.folder / "plan.html")
        self.assertEqual((self.folder / "plan.html").read_bytes()[:15], b"<!DOCTYPE html>")

    def test_saved_files_are_those_of_the_program(self):
        output = self.folder / "result"
        run("identify", "--target", self.file, "--fit", "mu", "--output", output)
        result = clothid.identify(clothid.Motion.load(self.file), fit="mu")
        result.save(self.folder / "saved")
        result.report(self.folder / "report.html")
        self.assertEqual({file.name for file in (self.folder / "saved").iterdir()},
                         {file.name for file in output.iterdir()})
        self.assertEqual((self.folder / "saved/predicted.bin").read_bytes(), (output / "predicted.bin").read_bytes())
        self.assertEqual((self.folder / "saved/report.html").read_text(encoding="utf-8"),
                         (self.folder / "report.html").read_text(encoding="utf-8"))

    def test_a_landscape_has_the_same_costs(self):
        output = self.folder / "cost"
        run("landscape", "--target", self.file, "--x", "mu=0:0.6:3", "--y", "k_stretch=50:100:2:log", "--contact",
            "both", "--gradients", "--output", output)
        lines = (output / "landscape.csv").read_text(encoding="utf-8").splitlines()
        column = lines[0].split(",").index("cost")
        found = clothid.landscape(clothid.Motion.load(self.file), ("mu", 0, 0.6, 3), ("k_stretch", 50, 100, 2, "log"),
                                  contact="both", gradients=True, threads=2)
        self.assertEqual(found.cost.shape, (2, 1, 2, 3))
        np.testing.assert_array_equal(found.cost.ravel(), [float(line.split(",")[column]) for line in lines[1:]])
        self.assertEqual(found.summary, json.loads((output / "summary.json").read_text(encoding="utf-8")))


if __name__ == "__main__":
    unittest.main()
