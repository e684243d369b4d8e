"""Which of several motions to record."""

from __future__ import annotations

import json
import os
from typing import Any, Dict, Iterable, Mapping, Optional, Tuple, Union

from clothid import _clothid
from clothid._identify import Names, Path, _names, _paths, _priors, _values
from clothid._view import View


class Plan:
    """What a fit of each candidate would tell; `print(plan)` is the table of the program.

    `data` is the content of plan.json (identify/experiment/experiment_plan.h), whose numbers are exact.
    """

    def __init__(self, table: str, data: Dict[str, Any], page: str) -> None:
        self.table = table
        self.data = data
        self.html = page  # the text of plan.html: one page for any browser, with the motions side by side

    @property
    def candidates(self) -> Dict[str, Dict[str, Any]]:
        """By name, in the order of the scenes: "parameters", "improvements", "failure" and more."""
        return {candidate["name"]: candidate for candidate in self.data["candidates"]}

    def interval(self, candidate: str, parameter: str) -> Tuple[float, float]:
        """The 95 % interval that a fit is expected to have; NaN where it would tell nothing."""
        expected = self.candidates[candidate]["parameters"][parameter]
        ends = (expected["lower95"], expected["upper95"])
        lower, upper = (float("nan") if end is None else float(end) for end in ends)
        return lower, upper

    def report(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes plan.html, whole or not at all. Raises FileError."""
        View(self.html).save(path)

    def __str__(self) -> str:
        return self.table

    def __repr__(self) -> str:
        return f"<clothid.Plan of {', '.join(self.candidates)}>"


def plan(
    scenes: Union[Path, Iterable[Path]],
    fit: Names,
    *,
    sigma: float,
    frame_rate: float = 0.0,
    markers: int = 0,
    forces: bool = False,
    force_sigma: float = 0.01,
    handle_sigma: float = 0.0,
    initial: str = "estimated",
    predict: Path = "",
    each: Names = (),
    start: Optional[Mapping[str, float]] = None,
    lower: Optional[Mapping[str, float]] = None,
    upper: Optional[Mapping[str, float]] = None,
    prior: Optional[Mapping[str, Tuple[float, float]]] = None,
    draws: int = 8,
    seed: int = 1,
    threads: int = 1,
    output: Path = "",
) -> Plan:
    """Tells before the laboratory which motion would tell which parameter, as the program `plan` does.

    scenes: files, scene.json each, of the candidates. Arguments are the flags of these names; start, lower, upper and
    prior are those of `identify`. Raises SimulationError where no candidate can be simulated.
    """
    flags: Dict[str, Any] = {
        "scenes": _paths(scenes),
        "predict": os.fspath(predict),
        "fit": _names(fit),
        "each": _names(each),
        "start": _values(start or {}),
        "lower": _values(lower or {}),
        "upper": _values(upper or {}),
        "prior": _priors(prior or {}),
        "sigma": float(sigma),
        "frame_rate": float(frame_rate),
        "markers": markers,
        "forces": forces,
        "force_sigma": float(force_sigma),
        "handle_sigma": float(handle_sigma),
        "initial": initial,
        "draws": draws,
        "seed": seed,
        "threads": threads,
        "output": os.fspath(output),
    }
    words = " ".join(f"{name}={value!r}" for name, value in flags.items() if value not in ("", 0, False))
    raw = _clothid.run_plan(flags, f"clothid.plan {words}")
    return Plan(raw["table"], json.loads(raw["json"]), raw["page"])
