"""Friction and stiffness by scipy.optimize.least_squares, with the exact Jacobian of the simulation.

    python3 least_squares.py SCENE.json
"""

import sys
from typing import Dict, List

import clothid
import numpy as np
import scipy.optimize  # type: ignore[import]
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Problem:
    """The distance of a simulation to measured positions of all nodes, as a function of the logarithms."""

    def __init__(self, scene: clothid.Scene, names: List[str], measured: Array) -> None:
        self.scene = scene
        self.names = names
        self.measured = measured

    def rollout(self, logarithms: Array) -> clothid.Rollout:
        return clothid.Rollout(self.scene, dict(zip(self.names, np.exp(logarithms))))

    def residuals(self, logarithms: Array) -> Array:
        return (self.rollout(logarithms).positions - self.measured).ravel()

    def jacobian(self, logarithms: Array) -> Array:
        derivative = self.rollout(logarithms).push_forward(self.names)
        return np.asarray(derivative.reshape(-1, len(self.names)) * np.exp(logarithms), dtype=np.float64)


def fit(scene: clothid.Scene, truth: Dict[str, float], start: Dict[str, float]) -> Dict[str, float]:
    names = list(start)
    problem = Problem(scene, names, clothid.simulate(scene, truth).positions)
    found = scipy.optimize.least_squares(
        problem.residuals, np.log([start[name] for name in names]), problem.jacobian, xtol=1e-12, ftol=1e-14, gtol=1e-14
    )
    return dict(zip(names, np.exp(found.x)))


if __name__ == "__main__":
    print(fit(clothid.Scene(sys.argv[1]), {"mu": 0.25, "k_stretch": 80.0}, {"mu": 0.4, "k_stretch": 110.0}))
