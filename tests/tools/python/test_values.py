"""Values between NumPy and clothid: views, copies, pickles, and one clear error for each that is wrong."""

import gc
import pathlib
import pickle
import tempfile
import unittest

import clothid
import numpy as np
from small_scene import hung, over_ball


def address(array):
    return array.__array_interface__["data"][0]


class ViewTest(unittest.TestCase):
    def test_positions_are_a_view_of_the_motion(self):
        motion = clothid.simulate(hung())
        positions = motion.positions
        self.assertEqual(positions.shape, (6, 16, 3))
        self.assertEqual(positions.dtype, np.float64)
        self.assertTrue(positions.flags.c_contiguous)
        self.assertEqual(address(positions), address(motion.positions))
        self.assertIs(positions.base, motion)
        with self.assertRaises(ValueError):
            positions[0, 0, 0] = 1.0

    def test_a_view_keeps_its_motion_alive(self):
        positions = clothid.simulate(hung()).positions
        copy = positions.copy()
        gc.collect()
        clothid.simulate(hung())
        np.testing.assert_array_equal(positions, copy)

    def test_positions_of_a_rollout_are_a_view(self):
        rollout = clothid.Rollout(hung())
        self.assertEqual(address(rollout.positions), address(rollout.positions))
        self.assertFalse(rollout.positions.flags.writeable)
        np.testing.assert_array_equal(rollout.positions, clothid.simulate(hung()).positions)
        np.testing.assert_allclose(rollout.times, 0.01 * np.arange(6), atol=1e-15)

    def test_arrays_come_back_as_they_went_in(self):
        simulated = clothid.simulate(hung())
        positions = simulated.positions.copy()
        positions[2, 9] = np.nan
        motion = clothid.Motion(positions, times=simulated.times, scene=hung(), sigma=0.002)
        np.testing.assert_array_equal(motion.positions, positions)
        np.testing.assert_array_equal(motion.times, simulated.times)
        np.testing.assert_array_equal(motion.sigma, np.full(16, 0.002))
        self.assertEqual(motion.scene.num_nodes, 16)

    def test_what_is_masked_was_not_seen(self):
        simulated = clothid.simulate(hung())
        expected = simulated.positions.copy()
        expected[2, 9] = expected[4, 3, 1] = np.nan
        for dtype in (np.float64, np.float32):
            masked = np.ma.masked_array(np.nan_to_num(expected, nan=-1e6).astype(dtype), mask=np.isnan(expected))
            motion = clothid.Motion(masked, times=np.ma.masked_array(simulated.times), scene=hung(), sigma=0.002)
            np.testing.assert_array_equal(np.isnan(motion.positions), np.isnan(expected))
            np.testing.assert_array_equal(motion.positions, expected.astype(dtype))
            self.assertEqual(masked.data[2, 9, 0], dtype(-1e6), "the array itself stays as it is")
        objects = np.ma.masked_array(simulated.positions.astype(object))
        with self.assertRaisesRegex(clothid.UsageError, "dtype object"):
            clothid.Motion(objects, times=simulated.times, scene=hung(), sigma=0.002)

    def test_other_layouts_are_copied(self):
        simulated = clothid.simulate(hung())
        for positions in (np.asfortranarray(simulated.positions), simulated.positions.tolist()):
            motion = clothid.Motion(positions, frame_rate=100.0, scene=hung())
            np.testing.assert_array_equal(motion.positions, simulated.positions)

    def test_markers_mesh_and_paths_of_handles(self):
        simulated = clothid.simulate(hung())
        scene = {key: value for key, value in hung().items() if key not in ("mesh", "duration")}
        seen = [5, 10, 15]
        path = np.repeat(simulated.positions[:1, :4], 9, axis=0)
        motion = clothid.Motion(
            simulated.positions[:, seen],
            times=simulated.times,
            scene=scene,
            rest_positions=simulated.rest_positions,
            faces=simulated.faces,
            node_index=seen,
            handle_nodes=range(4),
            handle_positions=path,
            handle_times=np.linspace(0.0, 0.05, 9),
        )
        self.assertEqual(motion.positions.shape, (6, 3, 3))
        np.testing.assert_array_equal(motion.scene.handles, np.arange(4))

    def test_motions_and_scenes_survive_pickling(self):
        motion = clothid.simulate(over_ball(), noise=0.001, drop=0.1)
        again = pickle.loads(pickle.dumps(motion))
        np.testing.assert_array_equal(again.positions, motion.positions)
        with tempfile.TemporaryDirectory() as folder:
            files = [pathlib.Path(folder) / name for name in ("one.motion.bin", "two.motion.bin")]
            for one, file in zip((motion, again), files):
                one.save(file)
            self.assertEqual(files[0].read_bytes(), files[1].read_bytes())
            self.assertEqual(clothid.Motion.load(files[0]).scene.num_steps, 20)
        for scene in (clothid.Scene(over_ball()), motion.scene):
            self.assertEqual(pickle.loads(pickle.dumps(scene)).parameters, scene.parameters)


class RefusalTest(unittest.TestCase):
    """Every wrong argument is one exception with one line that names it."""

    def setUp(self):
        self.scene = clothid.Scene(hung())
        self.motion = clothid.simulate(self.scene)

    def refuse(self, error, words, call):
        with self.assertRaises(error) as raised:
            call()
        self.assertIsInstance(raised.exception, clothid.Error)
        message = str(raised.exception)
        self.assertIn(words, message)
        self.assertNotIn("\n", message)
        self.assertNotIn("--", message)

    def make(self, positions, **arguments):
        return clothid.Motion(positions, **{"times": self.motion.times, "scene": self.scene, **arguments})

    def test_shapes_and_dtypes(self):
        positions = self.motion.positions
        usage = clothid.UsageError
        self.refuse(usage, "positions: expected an array of shape (T, P, 3); got (6, 48)",
                    lambda: self.make(positions.reshape(6, 48)))
        self.refuse(usage, "dtype complex128", lambda: self.make(positions.astype(complex)))
        self.refuse(usage, "positions: expected real numbers", lambda: self.make("positions.npy"))
        self.refuse(usage, "times: expected an array of shape (T,)", lambda: self.make(positions, times=[0.0]))
        self.refuse(usage, "times: expected times or frame_rate", lambda: self.make(positions, times=None))
        self.refuse(usage, "sigma: expected an array of shape (P,)", lambda: self.make(positions, sigma=[1.0, 2.0]))
        self.refuse(usage, "handle_nodes: expected whole numbers", lambda: self.make(positions, handle_nodes=[0.5]))
        self.refuse(usage, "rest_positions: expected with faces", lambda: self.make(positions, faces=[[0, 1, 2]]))
        rollout = clothid.Rollout(self.scene)
        self.refuse(usage, "dcost_dpositions: expected an array of shape (T + 1, N, 3)",
                    lambda: rollout.pull_back(positions[1:], ["k_stretch"]))
        self.refuse(usage, "dcost_dpositions: expected finite",
                    lambda: rollout.pull_back(np.full(positions.shape, np.nan), ["k_stretch"]))

    def test_contents(self):
        positions = self.motion.positions
        bad = clothid.InputError
        self.refuse(bad, "positions", lambda: self.make(positions[:, :15]))
        path = positions[:, :4].copy()
        path[2, 1] = np.nan
        self.refuse(clothid.UsageError, "handle_positions: expected finite numbers",
                    lambda: self.make(positions, handle_nodes=range(4), handle_positions=path))
        self.refuse(bad, "expected the time of frame 1", lambda: self.make(positions, times=self.motion.times[::-1]))
        self.refuse(bad, "key 'mesh.grid.size'", lambda: clothid.Scene({**hung(), "mesh": {"grid": {"nodes": [4, 4]}}}))
        self.refuse(bad, "unknown key", lambda: clothid.Scene({**hung(), "colour": "red"}))
        self.refuse(clothid.FileError, "missing.json", lambda: clothid.Scene("missing.json"))
        self.refuse(OSError, "missing.bin", lambda: clothid.Motion.load("missing.bin"))

    def test_names_and_values(self):
        usage = clothid.UsageError
        self.refuse(usage, "unknown parameter 'k_strech'", lambda: clothid.simulate(self.scene, {"k_strech": 1.0}))
        self.refuse(usage, "parameters", lambda: clothid.simulate(self.scene, {"k_stretch": -1.0}))
        self.refuse(usage, "parameters: expected names", lambda: clothid.simulate(self.scene, {"k_stretch": "soft"}))
        self.refuse(usage, "unknown parameter 'foo'", lambda: clothid.identify(self.motion, fit=["foo"]))
        self.refuse(usage, "sigma: expected recorded, auto", lambda: clothid.identify(self.motion, sigma="large"))
        self.refuse(usage, "threads: got 'two'", lambda: clothid.identify(self.motion, threads="two"))
        self.refuse(ValueError, "max_iterations", lambda: clothid.identify(self.motion, max_iterations=0))
        self.refuse(usage, "parameters: expected a list", lambda: clothid.Rollout(self.scene).push_forward("mu"))
        self.refuse(usage, "memory: expected with", lambda: clothid.Rollout(self.scene, recording=self.motion))
        self.refuse(usage, "memory: expected with", lambda: clothid.Rollout(self.scene, memory=0.1))
        self.refuse(usage, "memory: expected a number > 0", lambda: clothid.Rollout(self.scene, {}, self.motion, -1.0))
        self.refuse(usage, "x: ", lambda: clothid.landscape(self.motion, "mu", "density=0.1:0.2:2"))
        with self.assertRaisesRegex(TypeError, "unexpected keyword argument 'sigmas'"):
            clothid.identify(self.motion, sigmas=1.0)


if __name__ == "__main__":
    unittest.main()
