"""Pages of recordings and scenes: whole, shown in a notebook, saved."""

import html
import json
import pathlib
import re
import tempfile
import unittest

import clothid
import numpy as np
from small_scene import over_ball


def data_of(view):
    """What a page holds."""
    return json.loads(re.search(r'id="data">(.*?)</script>', view.html, re.DOTALL)[1])


class ViewTest(unittest.TestCase):
    def test_a_recording_shows_itself(self):
        positions = clothid.simulate(over_ball(), {"mu": 0.2}, noise=1e-3).positions.copy()
        positions[2, 5] = np.nan
        times = 0.01 * np.arange(len(positions))
        view = clothid.Motion(positions, times=times, scene=clothid.Scene(over_ball())).view()
        data = data_of(view)
        self.assertEqual((data["frames"], data["points"]), positions.shape[:2])
        self.assertEqual(data["unseen"][:4], [0, 0, 1, 0])
        self.assertIn("missing points", [finding["what"] for finding in data["findings"]])
        self.assertFalse(data["simulated"])
        self.assertLess(len(view.html), 5e6)
        self.assertFalse(re.search("https?:", view.html))
        frame = view._repr_html_()  # what IPython asks for, which is not needed for it
        self.assertEqual(html.unescape(re.fullmatch(r'<iframe srcdoc="([^"]*)"[^>]*></iframe>', frame)[1]), view.html)
        self.assertIn("clothid.View", repr(view))

    def test_a_scene_is_simulated(self):
        scene = clothid.Scene(over_ball())
        view = scene.view()
        data = data_of(view)
        self.assertTrue(data["simulated"])
        self.assertEqual(data["frames"], scene.num_steps + 1)
        self.assertEqual(len(data["forces"]["components"]), 3)
        self.assertNotEqual(scene.view({"mu": 0.0}).html, view.html)
        self.assertEqual(scene.view().html, view.html)
        with self.assertRaisesRegex(clothid.UsageError, "colour"):
            scene.view({"colour": 1.0})

    def test_saved_whole_or_not_at_all(self):
        view = clothid.Scene(over_ball()).view()
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            view.save(folder / "view.html")
            self.assertEqual((folder / "view.html").read_text(encoding="utf-8"), view.html)
            with self.assertRaisesRegex(clothid.FileError, "missing"):
                view.save(folder / "missing/view.html")
            self.assertEqual([path.name for path in folder.iterdir()], ["view.html"])


if __name__ == "__main__":
    unittest.main()
