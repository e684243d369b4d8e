"""`datasets/transfer` and `tools/benchmark/transfer`: the truth has the nodes of the scenes, and scores are right."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import clothid
import numpy as np

SOURCE = pathlib.Path(os.environ["CLOTHID_SOURCE_DIR"])
sys.path.insert(0, str(SOURCE / "datasets/transfer"))
import transfer_set  # noqa: E402


class TransferTest(unittest.TestCase):
    def test_the_truth_has_the_nodes_and_handles_of_the_scene(self):
        count = transfer_set.FINER_CELLS * (transfer_set.NODES - 1) + 1
        for motion in transfer_set.MOTIONS:
            coarse = clothid.Scene(transfer_set.scene_of("medium", motion))
            fine = clothid.Scene(transfer_set.truth_scene("medium", motion))
            grid = np.arange(fine.num_nodes).reshape(count, count)
            kept = grid[::transfer_set.FINER_CELLS, ::transfer_set.FINER_CELLS].ravel()
            np.testing.assert_allclose(fine.rest_positions[kept], coarse.rest_positions, atol=1e-12)
            held = np.isin(kept, fine.handles)
            np.testing.assert_array_equal(np.flatnonzero(held), np.sort(coarse.handles), motion)
        self.assertIn("stiffening_warp", fine.parameters)

    def run_transfer(self, folder, *arguments):
        command = [sys.executable, "-B", SOURCE / "tools/benchmark/transfer", "--folder", folder, "--fabrics", "medium"]
        return subprocess.run([*command, "--fitted", "swing", "--predicted", "drape", *arguments], capture_output=True,
                              text=True, check=False)

    def test_other_predictions_are_scored(self):
        random = np.random.default_rng(1)
        frames = 1 + round(transfer_set.DURATION * transfer_set.FRAME_RATE)
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            truth = random.normal(size=(frames, transfer_set.NODES**2, 3))
            for motion in ("swing", "drape"):
                np.save(folder / f"medium_{motion}.truth.npy", truth)
                (folder / f"medium_{motion}.motion.bin").write_bytes(b"")  # nobody fits it
            times = np.arange(frames) / transfer_set.FRAME_RATE
            path = folder / "medium_swing_drape.npz"
            done = self.run_transfer(folder, "--predictions", folder)
            self.assertIn("medium_swing_drape.npz: expected a prediction", done.stderr)
            np.savez(path, times=times, draws=random.normal(size=(199, *truth.shape)))
            done = self.run_transfer(folder, "--predictions", folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertRegex(done.stdout, r"4 of 4 cells hold 80 to 98 %, 0 less, 0 more, 4 of right predictions; [34] are "
                             r"as of right predictions, 0 too narrow, [01] too wide; in the mean 90 %")
            self.assertRegex(done.stdout, r"90 % \((89|90)\.\.(90|91)\) of 1e\+03 mm \(.*\) in \+- 1\.[67]e\+03")
            for spread, words in ((0.3, "4 too narrow, 0 too wide"), (3.0, "0 too narrow, 4 too wide")):
                np.savez(path, times=times, draws=spread * random.normal(size=(19, *truth.shape)))
                self.assertIn(words, self.run_transfer(folder, "--predictions", folder).stdout)
            flat = np.zeros((5, *truth.shape))
            np.savez(path, times=times, positions=flat, quantiles=[0.05, 0.25, 0.5, 0.75, 0.95])
            done = self.run_transfer(folder, "--predictions", folder)
            self.assertIn("0 of 4 cells hold 80 to 98 %, 4 less, 0 more; in the mean 0 %", done.stdout)
            self.assertRegex(done.stdout, r"0 % of 1e\+03 mm in \+- 0")
            for wrong, words in (({"times": times[1:]}, "times at 50 Hz"),
                                 ({"positions": flat[:, 1:]}, "5 x 76 x 121 x 3"),
                                 ({"quantiles": [0.1] * 5}, "quantiles")):
                good = {"times": times, "positions": flat, "quantiles": [0.05, 0.25, 0.5, 0.75, 0.95]}
                np.savez(path, **{**good, **wrong})
                done = self.run_transfer(folder, "--predictions", folder)
                self.assertEqual(done.returncode, 1)
                self.assertIn(words, done.stderr)


if __name__ == "__main__":
    unittest.main()
