"""`tools/benchmark/measure_fits`: what it makes of intervals, and a table of every command."""
import importlib.machinery
import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

SOURCE, BUILD = (pathlib.Path(os.environ[name]) for name in ("CLOTHID_SOURCE_DIR", "CLOTHID_BINARY_DIR"))
SCRIPT = SOURCE / "tools/benchmark/measure_fits"

loader = importlib.machinery.SourceFileLoader("measure_fits", str(SCRIPT))
measure_fits = importlib.util.module_from_spec(importlib.util.spec_from_loader("measure_fits", loader))
loader.exec_module(measure_fits)

SCENE = {
    "clothid_scene": 2, "time_step": 0.01, "duration": 0.2,
    "wind": {"mean": [0.5, 0, 0],
             "profile": {"times": [0, 0.2], "velocities": [[0, 2, 0], [0, 1, 0]]}},
    "mesh": {"grid": {"nodes": [5, 5], "size": [0.3, 0.3], "axes": [[1, 0, 0], [0, 0, -1]]}},
    "initial": {"positions": "rest"}, "handles": [0, 1, 2, 3, 4],
    "materials": {"density": 0.2, "k_stretch": 60, "k_bend": 2e-3, "drag": 0.4, "damping": 0.3},
    "fields": {"k_stretch": [[50, 60], [70, 80]]}}


class SummaryTest(unittest.TestCase):
    def test_says_what_the_fits_say(self):
        nan = np.nan
        fits = np.array([[[9, 1, 7, 11, 8, 9, 0.5]], [[11, 1, 9, 13, 10, 12, 0.5]], [[13, 1, 11, 15, 12, 14, 0.25]],
                         [[11, 3, nan, nan, nan, nan, nan]]])
        (row,) = measure_fits.summarize({"k_stretch": 10.0}, fits)
        name, covered, by_noise, reported, scatter, ratio, bias, refused, known = row
        self.assertEqual([name, covered, by_noise, refused], ["k_stretch", "2 of 4", 1, 0])
        self.assertAlmostEqual(reported, 1.5)
        self.assertAlmostEqual(scatter, np.sqrt(8 / 3))
        self.assertAlmostEqual(ratio, reported / scatter)
        self.assertAlmostEqual(bias, (-1 + 1 + 3 + 1 / 3) / 4)
        self.assertAlmostEqual(known, (2 + 2 + 4) / 3)

    def test_sums_up_what_belongs_together(self):
        for name, group in {"wind.y.12": "wind.y.*", "k_stretch.2.1": "k_stretch.*", "mu": "mu", "mu.ball": "mu.ball",
                            "gust.wave.x": "gust.wave.x", "wind.x": "wind.x"}.items():
            self.assertEqual(measure_fits.group_of(name), group)
        fits = np.ones((3, 2, 7)) * np.arange(1, 4)[:, None, None]
        (row,) = measure_fits.summarize({"wind.y.1": 1.0, "wind.y.2": 5.0}, fits)
        self.assertEqual(row[:2], ["wind.y.*", "1 of 6"])


class CommandTest(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(self.temporary.name)

    def run_script(self, command, scene=SCENE):
        (self.folder / "scene.json").write_text(json.dumps(scene), encoding="utf-8")
        done = subprocess.run([sys.executable, "-B", SCRIPT, *command.split(), "--output", "out"], cwd=self.folder,
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [line.split() for line in done.stdout.splitlines()[1:]]
        self.assertTrue((self.folder / "out" / f"{command.split()[0]}.csv").exists())
        return rows

    def test_starts_reach_the_minimum(self):
        rows = self.run_script("starts --scene scene.json --set k_stretch=70,drag=0.3 --starts 2 --noise 0.001 "
                               "--jacobians sensitivity,adjoint:gmres:1e-2")
        self.assertEqual(len(rows), 4)
        for row in rows:
            self.assertEqual(row[2:5], ["4", "of", "4"])

    def test_seeds_of_every_setting(self):
        rows = self.run_script("seeds --scene scene.json --set k_stretch=70 --seeds 2 --noise 0.0005 "
                               "--settings full,half,third,outliers,huber")
        self.assertEqual([row[0] for row in rows], ["full", "half", "third", "outliers", "huber"])
        std = {row[0]: float(row[6]) for row in rows}
        self.assertLess(std["full"], std["half"])
        self.assertLess(2 * std["huber"], std["outliers"])

    def test_seeds_of_everything_unknown(self):
        rows = self.run_script("seeds --scene scene.json --set k_stretch=70 --seeds 2 --settings full --noise 0.0005 "
                               "--field k_stretch:2x2 --wind_profile 2:y --initial moving --cut 0.02 --frame_rate 50")
        self.assertEqual([(row[1], row[4]) for row in rows],
                         [("k_stretch", "2"), ("wind.y.*", "4"), ("k_stretch.*", "8")])
        self.assertGreaterEqual(sum(int(row[2]) for row in rows), 10)

    def test_seeds_of_a_finer_truth(self):
        scene = {key: value for key, value in SCENE.items() if key != "fields"}
        rows = self.run_script("seeds --scene scene.json --set k_stretch=70 --seeds 2 --settings full --noise 0.0005 "
                               "--truth_steps 4 --truth_levels 1 --discretization all", scene)
        self.assertEqual(rows[0][1:5], ["k_stretch", "2", "of", "2"])

    def test_seeds_of_a_sensor(self):
        (self.folder / "path.csv").write_text("time,x0,y0,z0,x1,y1,z1\n0,0,0,0,0.3,0,0\n0.4,0.1,0,0.1,0.4,0,0.1\n")
        (self.folder / "sensor.json").write_text(json.dumps(
            {"clothid_sensor": 1, "clock_offset": 4, "interval": [0.01, 0.03], "noise": [1e-3, 1e-3, 1e-3],
             "pose": {"rotation": [0, 0, 0.6, 0.8], "translation": [1, 2, 3]}, "flipped_frames": 1,
             "gripper": {"rate": 50, "noise": 1e-4, "clock_offset": 4.5}}))
        scene = {**SCENE, "duration": 0.4, "handles": {"nodes": [0, 4], "path": "path.csv"}}
        rows = self.run_script("seeds --scene scene.json --set k_stretch=70 --seeds 2 --settings faults,markers "
                               f"--sensor sensor.json --build {BUILD}",
                               {key: value for key, value in scene.items() if key not in ("fields", "wind")})
        self.assertEqual([row[:2] for row in rows], [[setting, name] for setting in ("faults", "markers")
                                                     for name in ("k_stretch", "time_offset")])

    def test_fields_are_found(self):
        scene = {key: value for key, value in SCENE.items() if key != "fields"}
        (row,) = self.run_script("fields --scene scene.json --set k_stretch=70 --sides 3 --noise 0.0005", scene)
        self.assertEqual([row[0], row[-1]], ["9", "converged"])
        self.assertLess(float(row[1]), 40)


if __name__ == "__main__":
    unittest.main()
