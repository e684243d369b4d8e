"""`tools/benchmark/measure_cards`: a card from curves, and a table of fits with it and without."""
import csv
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SOURCE, BUILD = (pathlib.Path(os.environ[name]) for name in ("CLOTHID_SOURCE_DIR", "CLOTHID_BINARY_DIR"))


class CardsTest(unittest.TestCase):
    def test_cards_of_two_seeds(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, "-B", SOURCE / "tools/benchmark/measure_cards", "--build", BUILD,
                                   "--nodes", "5", "--seeds", "2", "--fit", "mu,k_warp", "--noise", "0.01",
                                   "--assimilate", "off", "--output", "out"], cwd=folder, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            with open(pathlib.Path(folder) / "out/cards.csv", encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
        table = [line.split() for line in done.stdout.splitlines()[1:]]
        self.assertEqual(len(table), 5 + 2 + 2, done.stdout)
        self.assertEqual(len(rows), 2 * len(table))
        laboratory = [row for row in rows if row["fit"] == "laboratory"]
        self.assertEqual(len(laboratory), 10)
        for row in laboratory:
            if row["parameter"].startswith("k_"):
                self.assertLess(abs(float(row["value"]) / float(row["truth"]) - 1), 0.15, row)
        self.assertNotEqual(laboratory[0]["value"], laboratory[5]["value"])  # noise of its own with every seed
        self.assertEqual({row["parameter"] for row in rows if row["fit"] == "card"}, {"mu", "k_warp"})


if __name__ == "__main__":
    unittest.main()
