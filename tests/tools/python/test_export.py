"""Exports for other simulators: the formulas, the files of the program, and the sag of cloths in MuJoCo."""

import json
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree

import clothid
import numpy as np
from mujoco_folder import mujoco_folder
from small_scene import BUILD, over_ball, run


def heavy(nodes, size, handles, k_stretch, bending, k_bend):
    """A cloth that comes to rest at once, held at some nodes."""
    return {
        "clothid_scene": 2,
        "time_step": 0.05,
        "integrator": "euler",
        "duration": 5.0,
        "mesh": {"grid": {"nodes": nodes, "size": size}},
        "initial": {"positions": "rest"},
        "handles": handles,
        "materials": {"density": 0.15, "k_stretch": k_stretch, "bending": bending, "k_bend": k_bend, "drag": 0.5},
    }


def strip(bending, k_bend):
    nodes = [18, 3]
    handles = [i + nodes[0] * j for j in range(nodes[1]) for i in range(4)]
    return heavy(nodes, [0.085, 0.01], handles, 2000, bending, k_bend)


class TextTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_mujoco_gets_the_constants_by_its_formulas(self):
        scene = strip("edges", 2e-5)
        texts = clothid.export(scene, {"k_stretch": 300.0}, "mujoco")
        self.assertEqual(list(texts), ["export_mujoco.xml"])
        model = xml.etree.ElementTree.fromstring(texts["export_mujoco.xml"])
        elasticity = model.find("deformable/flex/elasticity").attrib
        young, thickness = float(elasticity["young"]), float(elasticity["thickness"])
        self.assertAlmostEqual(young * thickness / 4 / 300.0, 1.0, places=12)
        self.assertAlmostEqual(young * thickness**3 / 48 / 2e-5, 1.0, places=12)
        mass = sum(float(body.find("inertial").attrib["mass"]) for body in model.findall("worldbody/body")
                   if body.find("inertial") is not None)
        area = 0.085 * 0.01 * 13.5 / 17  # of the nodes that are not held
        self.assertAlmostEqual(mass / (0.15 * area), 1.0, places=9)
        self.assertIn("swapped weights: 0", texts["export_mujoco.xml"])

    def test_others_get_the_constants_by_their_formulas(self):
        scene = {**strip("edges", 2e-5), "obstacles": [
            {"name": "table", "type": "plane", "point": [0, 0, -1], "normal": [0, 0, 1], "mu": 0.4}]}
        texts = clothid.export(scene, {"mu": 0.3})
        self.assertEqual(len(texts), 6)
        material = json.loads(re.sub(r"^//.*$", "", texts["export_arcsim.json"], flags=re.MULTILINE))
        self.assertEqual(material["stretching"], [[1000, 0, 1000, 1000]] * 6)
        np.testing.assert_allclose(material["bending"], np.full((3, 5), 12 * 2e-5), rtol=1e-12)
        for name in ("export_newton.py", "export_blender.py", "export_ppf.py"):
            compile(texts[name], name, "exec")
        names = {}
        exec(texts["export_ppf.py"], names)  # pylint: disable=exec-used
        self.assertEqual(names["PARAMETERS"]["friction"], 0.3)
        self.assertAlmostEqual(names["PARAMETERS"]["young-mod"], 2000 / 0.15)
        self.assertAlmostEqual(names["PARAMETERS"]["bend"] * 1.28e-5 * 0.15 / 3, 2e-5)
        # Right-angled triangles with sides h: 2 l/area = 3 l/h^2, in the mean over inner edges of lengths h and sqrt(2) h.
        h, counts = 0.005, (17 * 1 + 16 * 2, 17 * 2)
        mean = 3 / h * (counts[0] + np.sqrt(2) * counts[1]) / sum(counts)
        found = float(re.search(r"^EDGE_KE = (\S+)", texts["export_newton.py"], re.MULTILINE).group(1))
        self.assertAlmostEqual(found / (2e-5 * mean), 1.0, places=9)
        # ModelBuilder.color() takes triangles into account only where tri_ke * tri_ka is not zero, in single precision.
        values = {}
        exec("\n".join(re.findall(r"^TRI_K[EA] = .*$", texts["export_newton.py"], re.MULTILINE)), values)  # pylint: disable=exec-used
        self.assertNotEqual(np.float32(values["TRI_KE"]) * np.float32(values["TRI_KA"]), 0.0)
        self.assertLess(values["TRI_KA"], 1e-5 * values["TRI_KE"], "Poisson's ratio is 0")

    def test_program_writes_the_same_files(self):
        recording = self.folder / "recording.motion.bin"
        motion = clothid.simulate(over_ball(), {"mu": 0.2})
        motion.save(recording)
        run("identify", "--target", recording, "--fit", "mu", "--export", "all", "--output", self.folder / "fit")
        run("identify", "--result", self.folder / "fit/result.json", "--export", "all", "--output", self.folder / "later")
        result = clothid.identify(motion, fit="mu")
        texts = result.export(folder=self.folder)
        self.assertEqual(len(texts), 6)
        for name, text in texts.items():
            self.assertEqual((self.folder / name).read_text(encoding="utf-8"), text)
            self.assertEqual((self.folder / "fit" / name).read_text(encoding="utf-8"), text, name)
            self.assertEqual((self.folder / "later" / name).read_text(encoding="utf-8"), text, name)
        self.assertEqual(len(list((self.folder / "later").iterdir())), 6)
        run("identify", "--target", recording, "--fit", "mu", "--output", self.folder / "fit")
        self.assertEqual(list((self.folder / "fit").glob("export_*")), [], "those of the earlier run are gone")

    def test_wrong_requests_are_refused(self):
        with self.assertRaisesRegex(clothid.UsageError, "simulators: expected all or some of mujoco, .* got 'unity'"):
            clothid.export(over_ball(), None, "mujoco,unity")
        (self.folder / "wrong.json").write_text("{}", encoding="utf-8")
        for flags, code, words in (
            (["--result", "missing.json", "--export", "all"], 1, "missing.json"),
            (["--result", self.folder / "wrong.json", "--export", "all"], 2, "clothid.result/1"),
            (["--result", self.folder / "wrong.json"], 1, "--result: expected with --export"),
        ):
            done = subprocess.run([BUILD / "identify", *flags, "--output", self.folder / "none"], capture_output=True,
                                  text=True)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (code, 1), done.stderr)
            self.assertIn(words, done.stderr)
            self.assertFalse((self.folder / "none").exists())


class MujocoTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = mujoco_folder()
        shutil.copy(pathlib.Path(__file__).parent / "sag.mjs", cls.folder)

    def sag_ratio(self, scene, seconds):
        """The sag in MuJoCo over that here."""
        own = clothid.simulate(scene).positions[-1, :, 2]
        model = clothid.export(scene, None, "mujoco")["export_mujoco.xml"]
        with tempfile.NamedTemporaryFile("w", suffix=".xml") as file:
            file.write(model)
            file.flush()
            printed = subprocess.run(["node", "sag.mjs", file.name, str(seconds)], cwd=self.folder, check=True,
                                     capture_output=True, text=True).stdout
        return np.array(json.loads(printed)).reshape(-1, 3)[:, 2].min() / own.min()

    def test_a_strip_sags_as_far(self):
        self.assertAlmostEqual(self.sag_ratio(strip("edges", 4e-5), 0.6), 1.0, delta=0.001)
        self.assertAlmostEqual(self.sag_ratio(strip("patches", 1e-4), 0.6), 1.0, delta=0.05)

    def test_a_sheet_held_at_its_corners_sags_as_far(self):
        corners = [0, 8, 72, 80]
        self.assertAlmostEqual(self.sag_ratio(heavy([9, 9], [0.2, 0.2], corners, 1000, "patches", 3e-5), 0.6), 1.0,
                               delta=0.05)


if __name__ == "__main__":
    unittest.main()
