"""Motions that MuJoCo simulates: their stiffness and friction are found."""

import importlib.util
import json
import unittest

import clothid
import numpy as np
from mujoco_folder import mujoco_folder
from small_scene import SOURCE

FLEX = SOURCE / "datasets/flex.motion.bin"
TRUTH = {"mu": 0.2, "k_stretch": 60.0}

spec = importlib.util.spec_from_file_location("mujoco_flex", SOURCE / "tools/python/examples/mujoco_flex.py")
mujoco_flex = importlib.util.module_from_spec(spec)
spec.loader.exec_module(mujoco_flex)


class FlexTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = json.loads((SOURCE / "datasets/flex.scene.json").read_text(encoding="utf-8"))

    def expect_found(self, motion, names, within):
        found = clothid.identify(motion, fit=names).values
        for name in names:
            self.assertAlmostEqual(found[name] / TRUTH[name], 1.0, delta=within, msg=name)

    def test_the_shipped_recording_shows_the_truth(self):
        self.expect_found(clothid.Motion.load(FLEX), ["mu", "k_stretch"], 0.05)

    def test_the_shipped_recording_is_made_again(self):
        made = mujoco_flex.record(self.scene, TRUTH, mujoco_folder())
        shipped = clothid.Motion.load(FLEX)
        np.testing.assert_array_equal(made.times, shipped.times)
        np.testing.assert_allclose(made.positions, shipped.positions, rtol=0, atol=1e-6)

    def test_soft_contacts_show_nearly_the_same(self):
        motion = mujoco_flex.record(self.scene, TRUTH, mujoco_folder(), 2e-4, 0.02)
        self.expect_found(motion, ["mu", "k_stretch"], 0.05)

    def test_a_swinging_cloth_shows_its_stiffness(self):
        scene = {
            "clothid_scene": 2,
            "time_step": 0.0025,
            "duration": 0.6,
            "mesh": {"grid": {"nodes": [7, 9], "size": [0.18, 0.24]}},
            "initial": {"positions": "rest"},
            "handles": list(range(7)),
            "materials": {"density": 0.15, "k_stretch": 180, "bending": "edges", "k_bend": 1e-4, "damping": 0.02},
        }
        motion = mujoco_flex.record(scene, TRUTH, mujoco_folder())
        self.expect_found(motion, ["k_stretch"], 0.05)

    def test_a_table_that_moves_carries_a_cloth(self):
        seconds, time_step, speed = 0.3, 1e-3, 0.2
        path = [[0, 0, 0, 0, 0, 0, 0, 1], [seconds, speed * seconds, 0, 0, 0, 0, 0, 1]]
        table = {"type": "box", "center": [0, 0, -0.05], "size": [1, 1, 0.1], "mu": 0.5, "path": path}
        floor = {"type": "plane", "point": [0, 0, -0.05], "normal": [0, 0, 1], "mu": 0.5}  # through the table
        scene = {
            "clothid_scene": 2,
            "time_step": time_step,
            "duration": seconds,
            "mesh": {"grid": {"nodes": [4, 4], "size": [0.12, 0.12], "origin": [-0.06, -0.06, 0.001]}},
            "initial": {"positions": "rest"},
            "materials": {"density": 0.2, "k_stretch": 100},
        }
        poses = np.tile([0.0, 0, 0, 1, 0, 0, 0], (round(seconds / time_step), 1))
        poses[:, 0] = speed * time_step * np.arange(len(poses))
        alone, with_floor = (
            mujoco_flex.positions_of(clothid.export(each, None, "mujoco")["export_mujoco.xml"], seconds,
                                     mujoco_folder(), poses)
            for each in ({**scene, "obstacles": [table]}, {**scene, "obstacles": [table, floor]}))
        carried = (alone[-1] - alone[0])[:, 0]
        slid = speed**2 / (2 * 0.5 * 9.81)  # until it has the speed of the table
        np.testing.assert_allclose(carried, speed * seconds - slid, rtol=0, atol=0.002)
        np.testing.assert_array_equal(alone, with_floor, "obstacles do not touch each other")


if __name__ == "__main__":
    unittest.main()
