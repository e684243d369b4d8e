"""`clothid.predict`: the numbers of the program, and what is refused."""
import json
import pathlib
import tempfile
import unittest
import warnings

import clothid
import numpy as np
from small_scene import hung, run


def fitted():
    scene = {**hung(nodes=4, steps=30), "clothid_scene": 2}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", clothid.RecordingWarning)
        return clothid.identify(clothid.simulate(scene, {"k_stretch": 60}, noise=1e-3), fit=["k_stretch"])


class PredictTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.result = fitted()
        cls.scene = {**hung(nodes=5, steps=20), "clothid_scene": 2, "handles": [0, 1, 4]}

    def test_numbers_are_those_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            (folder / "scene.json").write_text(json.dumps(self.scene), encoding="utf-8")
            self.result.save(folder / "fit")
            run("simulate", "--scene", folder / "scene.json", "--result", folder / "fit/result.json", "--draws", "20",
                "--of", "area,force,point:12", "--frame_rate", "50", "--bands", folder / "bands.npz", "--output",
                folder / "predicted.bin")
            bands = dict(np.load(folder / "bands.npz"))
            self.assertNotIn("draws", bands)
            from_file = clothid.predict(folder / "scene.json", folder / "fit/result.json", draws=20, frame_rate=50)
        calls = []
        prediction = clothid.predict(self.scene, self.result, draws=20, of=["area", "force", "point:12"], frame_rate=50,
                                     threads=2, progress=lambda *done: calls.append(done))
        self.assertEqual(len(calls), 20)
        self.assertEqual(prediction.positions.shape, (5, 11, 25, 3))
        self.assertEqual(prediction.derived["force"].shape, (5, 11, 2, 3))
        self.assertEqual(prediction.derived["area"].shape, (5, 11))
        np.testing.assert_array_equal(prediction.positions, bands["positions"])
        np.testing.assert_array_equal(from_file.positions, bands["positions"])
        for name, values in prediction.derived.items():
            np.testing.assert_array_equal(values, bands[name])
        np.testing.assert_array_equal(prediction.shares["k_stretch"], bands["share_k_stretch"])
        np.testing.assert_array_equal(prediction.derived["point_12"], prediction.positions[:, :, 12])
        self.assertEqual(prediction.median.shape, (11, 25, 3))

    def test_coverage_counts_what_spreads(self):
        prediction = clothid.predict(self.scene, self.result, draws=20)
        inside = prediction.coverage(prediction.median)
        np.testing.assert_array_equal(inside[1:], 1.0)
        far = prediction.median + 1.0
        far[:, :10] = np.nan
        np.testing.assert_array_equal(prediction.coverage(far)[1:], 0.0)
        with self.assertRaisesRegex(clothid.UsageError, "positions: expected the shape"):
            prediction.coverage(np.zeros(3))

    def test_draws_tell_what_a_right_prediction_holds(self):
        prediction = clothid.predict(self.scene, self.result, draws=20, keep_draws=True)
        self.assertEqual(prediction.draws.shape, (20, *prediction.median.shape))
        np.testing.assert_allclose(np.quantile(prediction.draws, prediction.quantiles, axis=0, method="weibull"),
                                   prediction.positions, atol=1e-12)
        spread = np.ptp(prediction.draws[:, 1:], axis=0) > 0  # neither of handles nor across the plane of the swing
        coverage, error = clothid.leave_one_out(prediction.draws[:, 1:])
        for draw in (0, 13):
            others = np.delete(prediction.draws[:, 1:][:, spread], draw, axis=0)
            low, median, high = np.quantile(others, (0.05, 0.5, 0.95), axis=0, method="weibull")
            own = prediction.draws[draw, 1:][spread]
            self.assertAlmostEqual(coverage[draw], np.mean((low <= own) & (own <= high)), places=3)
            self.assertAlmostEqual(error[draw], np.sqrt(np.mean((own - median) ** 2)), places=9)
        right = prediction.if_right(np.s_[1:])
        self.assertEqual(right["coverage"], tuple(np.quantile(coverage, (0.05, 0.95), method="weibull")))
        self.assertEqual(right["error"], tuple(np.quantile(error, (0.05, 0.95), method="weibull")))
        self.assertAlmostEqual(coverage.mean(), 0.9, places=2)
        self.assertIsNone(clothid.predict(self.scene, self.result, draws=20).draws)
        with self.assertRaisesRegex(clothid.UsageError, "keep_draws=True"):
            clothid.predict(self.scene, self.result, draws=20).if_right()
        with self.assertRaisesRegex(clothid.UsageError, "draws: expected at least 19"):
            clothid.leave_one_out(np.zeros((3, 5)))

    def test_refuses_what_predicts_nothing(self):
        with self.assertRaisesRegex(clothid.UsageError, "sources: expected some of"):
            clothid.predict(self.scene, self.result, sources="luck")
        with self.assertRaisesRegex(clothid.UsageError, "of: expected some of"):
            clothid.predict(self.scene, self.result, of="luck")
        with self.assertRaisesRegex(clothid.UsageError, "19 to 10000"):
            clothid.predict(self.scene, self.result, draws=3)
        with self.assertRaisesRegex(clothid.FileError, "absent.json"):
            clothid.predict(self.scene, "absent.json")


if __name__ == "__main__":
    unittest.main()
