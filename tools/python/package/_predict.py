"""Another motion by what a fit has learnt, and how far that may be off."""

from __future__ import annotations

import json
import os
import pathlib
from typing import Any, Callable, Dict, Iterable, Optional, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from clothid import _clothid
from clothid._clothid import Scene
from clothid._result import Result

Array = NDArray[np.float64]
Path = Union[str, "os.PathLike[str]"]


class Prediction:
    """Bands of a motion that nobody has recorded. Arrays have the quantiles of `quantiles` first, then times."""

    quantiles: Tuple[float, ...] = (0.05, 0.25, 0.5, 0.75, 0.95)

    def __init__(self, told: Dict[str, Any]) -> None:
        self.times: Array = told["times"]  # (T,) s
        self.positions: Array = told["positions"]  # (5, T, N, 3) m
        self.spread: Array = told["spread"]  # (T,) m, root mean square of what draws deviate by, of an axis
        self.moved: Array = told["moved"]  # (T,) m, likewise of how far the median is from the start
        # (T,) of "parameters", of each of them, of "finer" (step and mesh), "start", "handles" and "rest" (the force
        # that the model lacks): what share of the squared spread is theirs.
        self.shares: Dict[str, Array] = told["shares"]
        # What `of` asked for: "area" (5, T) m^2, "strain" (5, T), "force" (5, T, G, 3) N, "slip" (5,) s, "point_12".
        self.derived: Dict[str, Array] = told["derived"]
        self.draws: Optional[Array] = told["draws"]  # (D, T, N, 3) m, the rollouts that worked, where they are kept
        self.num_draws: int = told["num_draws"]
        self.num_failed: int = told["num_failed"]  # rollouts that failed; they are in no number
        self.worth_until: float = told["worth_until"]  # s: then it misses as much as the cloth at rest; inf: never
        self.warning: str = told["warning"]  # the verdict of a fit that must not be used, else ""

    @property
    def median(self) -> Array:
        """(T, N, 3) m."""
        middle: Array = self.positions[2]
        return middle

    def coverage(self, positions: Any) -> Array:
        """(T,) The share of the coordinates of `positions` (T, N, 3) that lie in the bands of 90 %; NaN counts nowhere.
        Of nodes that do not spread, as handles, nothing counts, either."""
        seen = np.asarray(positions, dtype=float)
        low, high = self.positions[0], self.positions[4]
        if seen.shape != low.shape:
            raise _clothid.UsageError(f"positions: expected the shape {low.shape}, got {seen.shape}")
        counts = (low < high) & np.isfinite(seen)
        inside = counts & (low <= seen) & (seen <= high)
        number = counts.sum(axis=(1, 2))
        return np.where(number > 0, inside.sum(axis=(1, 2)) / np.maximum(number, 1), np.nan)

    def if_right(self, counts: Any = ...) -> Dict[str, Tuple[float, float]]:
        """Of coordinates `counts`, an index or mask of (T, N, 3) as numpy.s_[:15], the first 15 frames: from where to
        where "coverage", the share in bands of 90 %, and "error" (m), root mean square of what the median misses, lie of
        a right prediction, nine times in ten. Expects draws that were kept."""
        if self.draws is None:
            raise _clothid.UsageError("draws: expected a prediction with keep_draws=True")
        coverage, error = leave_one_out([draw[counts] for draw in self.draws])
        low, high = np.quantile([coverage, error], (0.05, 0.95), axis=1, method="weibull")
        return {"coverage": (float(low[0]), float(high[0])), "error": (float(low[1]), float(high[1]))}

    def __repr__(self) -> str:
        return f"<clothid.Prediction of {len(self.times)} frames by {self.num_draws} rollouts>"


def leave_one_out(draws: Any) -> Tuple[Array, Array]:
    """Each of `draws` (D, ..) against the others, as a right prediction for which what happens is one more draw: what
    share of it lies in their bands of 90 %, (D,), and the root mean square of what their median misses it by, (D,).
    What no draw spreads, as handles, counts nowhere."""
    columns = np.asarray(draws, dtype=float)
    columns = columns.reshape(len(columns), -1)
    coverage: Array
    error: Array
    coverage, error = _clothid.leave_one_out(columns[:, np.ptp(columns, axis=0) > 0])
    return coverage, error


def predict(
    scene: Union[Scene, Dict[str, Any], Path],
    result: Union[Result, Path],
    *,
    draws: int = 50,
    keep_draws: bool = False,
    sources: Union[str, Iterable[str]] = ("force", "step", "mesh", "start", "handles"),
    of: Union[str, Iterable[str]] = (),
    frame_rate: float = 0.0,
    seed: int = 1,
    threads: int = 1,
    progress: Optional[Callable[[int, int], object]] = None,
) -> Prediction:
    """Simulates `scene` with what a fit has learnt, as `simulate --result` does, in the same numbers.

    result: of `identify`, or the path of a result.json. draws: rollouts; keep_draws: they are told, too. sources: what
    spreads them beside parameters. of: what is told beside positions, "point:12", "area", "strain", "force" (of every
    gripper), "slip". frame_rate in Hz; 0: a frame per step. progress(done, draws) is called after every rollout. Raises UsageError, FileError and
    InputError, for a result without intervals too.
    """
    if isinstance(result, Result):
        text, source = json.dumps(result.data), "result"
    else:
        source = os.fspath(result)
        try:
            text = pathlib.Path(source).read_text(encoding="utf-8")
        except OSError as error:
            raise _clothid.FileError(f"{source}: {error.strerror}") from None
    lists = [names if isinstance(names, str) else ",".join(names) for names in (of, sources)]
    told = _clothid.run_prediction(
        scene, text, source, lists[0], lists[1] or "parameters", draws, keep_draws, frame_rate, seed, threads, progress
    )
    return Prediction(told)
