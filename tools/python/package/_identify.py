"""The fit and the check of recordings: arguments in Python's spelling become the flags of the program."""

from __future__ import annotations

import json
import os
import warnings
from dataclasses import dataclass
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

from clothid import _clothid
from clothid._clothid import Motion
from clothid._result import Result

Names = Union[str, Iterable[str]]
Path = Union[str, "os.PathLike[str]"]


class RecordingWarning(UserWarning):
    """What `check` finds in a recording that is about to be fitted."""


@dataclass(frozen=True)
class Finding:
    """One thing that was found out about a recording."""

    what: str
    severity: str  # "ok", "note", "warning" or "problem"
    value: str
    hint: str
    frames: Tuple[int, ...]
    points: Tuple[int, ...]


class Findings(List[Finding]):
    """Those of a recording; `print` shows them as a table."""

    @property
    def worst(self) -> str:
        """The gravest severity among them."""
        order = ("ok", "note", "warning", "problem")
        return max((finding.severity for finding in self), key=order.index, default="ok")

    def __str__(self) -> str:
        lines = []
        for finding in self:
            lines.append(f"{finding.what:<22}{finding.severity:<9}{finding.value}")
            if finding.hint:
                lines.append(" " * 31 + finding.hint)
        return "\n".join(lines)


def check(motion: Motion) -> Findings:
    """Looks for what is wrong with a recording before any fit, as `motion check` does. Nothing is simulated."""
    return Findings(
        Finding(
            what=item["what"],
            severity=item["verdict"],
            value=item["value"],
            hint=item["hint"],
            frames=tuple(item["frames"]),
            points=tuple(item["points"]),
        )
        for item in json.loads(_clothid.check_json(motion))["findings"]
    )


def _names(names: Names) -> str:
    return names if isinstance(names, str) else ",".join(names)


def _values(values: Mapping[str, float]) -> str:
    return ",".join(f"{name}={float(value)!r}" for name, value in values.items())


def _priors(priors: Mapping[str, Tuple[float, float]]) -> str:
    return ",".join(f"{name}={float(a)!r}:{float(b)!r}" for name, (a, b) in priors.items())


def _paths(paths: Union[Path, Iterable[Path]]) -> str:
    several = [paths] if isinstance(paths, (str, os.PathLike)) else paths
    return ",".join(os.fspath(path) for path in several)


def _warn(recording: str, what: str, value: str, hint: str) -> None:
    warnings.warn(f"{recording}: {what}: {value}; {hint}", RecordingWarning, stacklevel=2)


def identify(
    motions: Union[Motion, Sequence[Motion]],
    fit: Names = (),
    *,
    repeat: bool = False,
    transfer: bool = False,
    each: Names = (),
    field: Names = (),
    field_weight: float = 0.0,
    wind_profile: str = "",
    wind_smoothness: float = 0.0,
    start: Optional[Mapping[str, float]] = None,
    lower: Optional[Mapping[str, float]] = None,
    upper: Optional[Mapping[str, float]] = None,
    prior: Optional[Mapping[str, Tuple[float, float]]] = None,
    scene: Path = "",
    fabric: str = "",
    sigma: Union[str, float] = "recorded",
    initial: str = "estimated",
    loss: str = "none",
    jacobian: str = "adjoint",
    adjoint: str = "reduced",
    precision: str = "adaptive",
    horizon: str = "growing",
    assimilate: Union[str, float] = "auto",
    max_iterations: int = 50,
    time_step: Union[str, float] = "",
    step_tolerance: float = 0.0,
    starts: int = 1,
    seed: int = 0,
    profile: Names = (),
    discretization: str = "",
    check_gradients: bool = False,
    check: bool = True,
    holdout: Sequence[Motion] = (),
    holdout_frames: Optional[Tuple[int, int]] = None,
    landscape: Union[Path, Iterable[Path]] = (),
    threads: int = 1,
    output: Path = "",
    report: bool = True,
    export: Names = (),
    resume: bool = False,
    on_iteration: Optional[Callable[[Dict[str, Any]], object]] = None,
    on_step: Optional[Callable[[Dict[str, Any]], object]] = None,
) -> Result:
    """Fits parameters to recordings, jointly, as the program `identify` does with the flags of the same names.

    motions: a Motion or several. fit, each, profile: names of parameters ("mu", "k_stretch", ..); fit=() fits mu and
    k_stretch. start, lower, upper: {name: value}. prior: {name: (median, factor)} or, of mu and signed parameters,
    {name: (mean, standard deviation)}. sigma, time_step, assimilate: a text of the program, or a number in m or s.
    repeat: the motions are repetitions of one experiment, see `Result.repetitions`. transfer: each predicts the
    others, see `Result.transfer`. holdout_frames: (first, end).
    export: simulators for which `output` gets files, see `Result.export`. output: a folder for the files that the
    program writes; "": none are written.

    on_iteration is called with {"iteration", "seconds", "cost", "parameters", "gradient_norm", "rollouts"} after every
    iteration, on_step with {"evaluation", "recording", "step", "num_steps", "seconds", "seconds_left"} after every
    time step; what they raise ends the fit. Ctrl-C ends it within a time step; with `output` the files keep the best
    point so far.

    Estimates are those of the program to the last digit, on any number of threads. Raises UsageError for wrong
    arguments, InputError for recordings in which the check finds a problem, SimulationError where no estimate was
    reached. Warnings of the check are `RecordingWarning`s. Read `result.verdict` first.
    """
    flags: Dict[str, Any] = {
        "repeat": repeat,
        "transfer": transfer,
        "fit": _names(fit),
        "each": _names(each),
        "field": _names(field),
        "field_weight": field_weight,
        "wind_profile": wind_profile,
        "wind_smoothness": wind_smoothness,
        "start": _values(start or {}),
        "lower": _values(lower or {}),
        "upper": _values(upper or {}),
        "prior": _priors(prior or {}),
        "scene": os.fspath(scene),
        "fabric": fabric,
        "sigma": sigma if isinstance(sigma, str) else repr(float(sigma)),
        "initial": initial,
        "loss": loss,
        "jacobian": jacobian,
        "adjoint": adjoint,
        "precision": precision,
        "horizon": horizon,
        "assimilate": assimilate if isinstance(assimilate, str) else repr(float(assimilate)),
        "max_iterations": max_iterations,
        "time_step": time_step if isinstance(time_step, str) else repr(float(time_step)),
        "step_tolerance": step_tolerance,
        "starts": starts,
        "seed": seed,
        "profile": _names(profile),
        "discretization": discretization,
        "check_gradients": check_gradients,
        "check": check,
        "holdout_frames": "" if holdout_frames is None else f"{holdout_frames[0]}:{holdout_frames[1]}",
        "landscape": _paths(landscape),
        "threads": threads,
        "output": os.fspath(output),
        "report": report,
        "export": _names(export),
        "resume": resume,
    }
    several = [motions] if isinstance(motions, Motion) else list(motions)
    words = " ".join(f"{name}={value!r}" for name, value in flags.items() if value not in ("", 0, False, None))
    raw = _clothid.run_fit(several, list(holdout), flags, f"clothid.identify {words}", _warn, on_iteration, on_step)
    return Result(raw)
