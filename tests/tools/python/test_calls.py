"""What Python sees of calls that take long: interrupts, other threads, callbacks, memory; and exact derivatives."""

import os
import pathlib
import pickle
import signal
import tempfile
import threading
import time
import unittest

import clothid
import numpy as np
from small_scene import hung, over_ball

LONG = hung(nodes=12, steps=1000000)  # minutes


def resident_bytes():
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")


class LongCallTest(unittest.TestCase):
    def expect_interrupted(self, call):
        sent = []
        timer = threading.Timer(0.3, lambda: (sent.append(time.monotonic()), os.kill(os.getpid(), signal.SIGINT)))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            call()
        self.assertLess(time.monotonic() - sent[0], 2.0)
        timer.join()

    def test_interrupts_end_a_simulation(self):
        self.expect_interrupted(lambda: clothid.simulate(LONG))

    def test_interrupts_end_a_fit(self):
        motion = clothid.simulate(hung(nodes=12, steps=200))

        def on_step(values):
            time.sleep(0.02)  # of 200 steps, several times over

        self.expect_interrupted(lambda: clothid.identify(motion, fit=["density"], start={"density": 0.5}, on_step=on_step))

    def test_other_threads_run_meanwhile(self):
        ticks = []
        is_done = threading.Event()

        def tick():
            while not is_done.wait(0.005):
                ticks.append(time.monotonic())

        thread = threading.Thread(target=tick)
        thread.start()
        begin = time.monotonic()
        clothid.simulate(hung(nodes=16, steps=100))
        end = time.monotonic()
        is_done.set()
        thread.join()
        self.assertGreater(sum(begin < t < end for t in ticks), 3)

    def test_progress_tells_every_step_and_may_raise(self):
        steps = []
        clothid.simulate(hung(), progress=lambda step, count: steps.append((step, count)))
        self.assertEqual(steps, [(i, 5) for i in range(1, 6)])

        def stop(step, count):
            raise RuntimeError(f"enough at {step}")

        with self.assertRaisesRegex(RuntimeError, "enough at 1"):
            clothid.simulate(LONG, progress=stop)
        motion = clothid.simulate(over_ball())
        with self.assertRaisesRegex(RuntimeError, "enough"):
            clothid.identify(motion, fit=["mu"], on_iteration=lambda values: stop(values["iteration"], 0))
        with self.assertRaises(ZeroDivisionError):
            clothid.identify(motion, fit=["mu"], on_step=lambda values: 1 // 0, threads=2)

    def test_simulations_leak_nothing(self):
        scene = clothid.Scene(hung())
        for _ in range(100):
            clothid.simulate(scene).positions.sum()
        before = resident_bytes()
        for _ in range(1000):
            clothid.simulate(scene).positions.sum()
        self.assertLess(resident_bytes() - before, 4 << 20)

    def test_failed_simulations_are_errors(self):
        scene = {**hung(), "solver": {"max_newton_iterations": 1, "max_substep_halvings": 0, "step_tolerance": 1e-12}}
        with self.assertRaisesRegex(clothid.SimulationError, "step"):
            clothid.simulate(scene)


class DerivativeTest(unittest.TestCase):
    NAMES = ["mu", "k_stretch", "density"]

    def setUp(self):
        self.scene = clothid.Scene({**over_ball(), "solver": {"step_tolerance": 1e-12}})
        self.values = {"mu": 0.2, "k_stretch": 60.0, "density": 0.2}
        self.rollout = clothid.Rollout(self.scene, self.values)
        self.target = clothid.simulate(self.scene).positions

    def cost(self, values):
        return 0.5 * np.sum((clothid.Rollout(self.scene, values).positions - self.target) ** 2)

    def test_pull_back_is_the_gradient(self):
        gradient = self.rollout.pull_back(self.rollout.positions - self.target, self.NAMES)
        for name, derivative in zip(self.NAMES, gradient):
            step = 1e-4 * self.values[name]  # central differences of fourth order
            far, near = ([self.cost({**self.values, name: self.values[name] + k * step}) for k in (-n, n)]
                         for n in (2, 1))
            difference = (8 * (near[1] - near[0]) - (far[1] - far[0])) / (12 * step)
            self.assertAlmostEqual(derivative / difference, 1.0, delta=1e-6, msg=name)

    def test_push_forward_is_the_transpose(self):
        jacobian = self.rollout.push_forward(self.NAMES)
        self.assertEqual(jacobian.shape, self.rollout.positions.shape + (3,))
        weights = np.random.default_rng(1).normal(size=self.rollout.positions.shape)
        np.testing.assert_allclose(self.rollout.pull_back(weights, self.NAMES),
                                   np.einsum("tni,tnip->p", weights, jacobian), rtol=1e-9)


class CorrectedRolloutTest(unittest.TestCase):
    NAMES = ["mu", "k_stretch"]

    def setUp(self):
        self.scene = clothid.Scene({**over_ball(), "solver": {"step_tolerance": 1e-12}})
        self.recording = clothid.simulate(self.scene, {"mu": 0.3, "k_stretch": 80.0})

    def positions(self, values, memory):
        return clothid.Rollout(self.scene, values, self.recording, memory).positions

    def test_a_short_memory_keeps_to_the_recording(self):
        values = {"mu": 0.2, "k_stretch": 40.0}
        errors = [np.abs(self.positions(values, memory) - self.recording.positions).max()
                  for memory in (1e-3, 0.02, 0.1)]
        free = np.abs(clothid.Rollout(self.scene, values).positions - self.recording.positions).max()
        self.assertEqual(errors + [free], sorted(errors + [free]))
        self.assertLess(2.0 * errors[0], free)
        truth = {"mu": 0.3, "k_stretch": 80.0}
        np.testing.assert_allclose(self.positions(truth, 0.02), self.recording.positions, rtol=0, atol=1e-10)

    def test_its_derivatives_are_exact(self):
        values = {"mu": 0.2, "k_stretch": 60.0}
        rollout = clothid.Rollout(self.scene, values, self.recording, 0.05)
        jacobian = rollout.push_forward(self.NAMES)
        weights = np.random.default_rng(1).normal(size=rollout.positions.shape)
        np.testing.assert_allclose(rollout.pull_back(weights, self.NAMES),
                                   np.einsum("tni,tnip->p", weights, jacobian), rtol=1e-9)
        for place, name in enumerate(self.NAMES):
            step = 1e-4 * values[name]
            after, before = (self.positions({**values, name: values[name] + sign * step}, 0.05) for sign in (1, -1))
            difference = np.sum(weights * (after - before)) / (2 * step)
            own = np.einsum("tni,tni->", weights, jacobian[..., place])
            self.assertAlmostEqual(own / difference, 1.0, delta=1e-5, msg=name)


class ResultTest(unittest.TestCase):
    def test_results_survive_pickling(self):
        motion = clothid.simulate(over_ball(), {"mu": 0.2})
        result = clothid.identify(motion, fit="mu")
        again = pickle.loads(pickle.dumps(result))
        self.assertEqual(again.data, result.data)
        self.assertEqual(again.html, result.html)
        self.assertEqual(str(again), str(result))
        np.testing.assert_array_equal(again.predicted[0].positions, result.predicted[0].positions)
        self.assertIn("<iframe srcdoc=", again._repr_html_())
        self.assertAlmostEqual(again["mu"].value, 0.2, places=6)
        self.assertEqual(again.covariance.shape, (1, 1))
        self.assertEqual(again.verdict.usable, result.verdict.usable)
        with tempfile.TemporaryDirectory() as place:
            folder = pathlib.Path(place)
            result.save(folder / "own")
            again.save(folder / "pickled")
            pickle.loads(pickle.dumps(again)).save(folder / "twice")
            expected = {path.name: path.read_bytes() for path in (folder / "own").iterdir()}
            names = {"result.json", "fabric.json", "convergence.csv", "predicted.bin", "card.html", "report.html"}
            self.assertLessEqual(names, set(expected))
            for name in ("pickled", "twice"):
                self.assertEqual({path.name: path.read_bytes() for path in (folder / name).iterdir()}, expected)
            again.save(folder / "twice", report=False)
            self.assertFalse((folder / "twice/report.html").exists())
            self.assertFalse((folder / "twice/card.html").exists())
            again.report(folder / "page.html")
            self.assertEqual((folder / "page.html").read_bytes(), expected["report.html"])


if __name__ == "__main__":
    unittest.main()
