"""What comes out of a fit."""

from __future__ import annotations

import html
import json
import os
import pathlib
import tempfile
from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from clothid import _clothid
from clothid._clothid import Motion
from clothid._view import View


@dataclass(frozen=True)
class Estimate:
    """A fitted parameter, in its own SI unit."""

    name: str
    value: float
    start: float
    std: float  # from the noise alone; NaN where it has no interval
    interval: Tuple[float, float]  # 95 %; NaN where it has none
    at_bound: bool
    identifiable: Optional[bool]  # None: the fit came to no uncertainty
    usable: str  # "yes", "with care" or "no"


@dataclass(frozen=True)
class Verdict:
    """Whether the answer can be used, and why not."""

    usable: str  # "yes", "with care" or "no"
    lines: Tuple[str, ...]  # the overall line first, then the reasons, the gravest first
    exit_code: int  # that of the program

    def __str__(self) -> str:
        return "\n".join(self.lines)


_PAGE = "report.html"
_PAGES = (_PAGE, "card.html")  # left out of `save` without a report
_FILES = {"page": _PAGE, "convergence_csv": "convergence.csv"}  # what is the text of a file


def _number(value: Optional[float]) -> float:
    return float("nan") if value is None else value


class Result:
    """Estimates, intervals and verdict of a fit; `print(result)` is the table of the program.

    Everything is read from `data`, the content of result.json (identify/README.md), whose numbers are exact. It can be
    pickled, and carries its files along.
    """

    data: Dict[str, Any]

    def __init__(self, fit: "_clothid.Fit") -> None:
        self._fit: Optional[_clothid.Fit] = fit
        self._kept: Dict[str, Any] = {}
        self._files: Dict[str, bytes] = {}  # those of `save`; of a result that was pickled
        self.table = fit.table
        self.data = json.loads(fit.json)

    def _take(self, name: str) -> Any:
        if name not in self._kept and self._fit is None:
            self._kept[name] = self._files[_FILES[name]].decode("utf-8")
        elif name not in self._kept:
            value = getattr(self._fit, name)
            self._kept[name] = value() if callable(value) else value
        return self._kept[name]

    @property
    def parameters(self) -> Dict[str, Estimate]:
        """The estimates by name, in the order of the fit."""
        return {name: self[name] for name in self.data["parameters"]}

    def __getitem__(self, name: str) -> Estimate:
        entry = self.data["parameters"][name]
        return Estimate(
            name=name,
            value=entry["value"],
            start=entry["start"],
            std=_number(entry["std"]),
            interval=(_number(entry["lower95"]), _number(entry["upper95"])),
            at_bound=entry["at_bound"],
            identifiable=entry["identifiable"],
            usable=entry["usable"],
        )

    @property
    def values(self) -> Dict[str, float]:
        """{name: estimate}, as `simulate` and `Rollout` take them."""
        return {name: entry["value"] for name, entry in self.data["parameters"].items()}

    @property
    def verdict(self) -> Verdict:
        return Verdict(self.data["usable"], tuple(self.data["verdict"]), self.data["exit_code"])

    @property
    def covariance(self) -> NDArray[np.float64]:
        """(P, P), from the noise alone, to first order in the parameters' own units; NaN without an uncertainty."""
        names = list(self.data["parameters"])
        std = np.array([self[name].std for name in names])
        uncertainty = self.data["uncertainty"]
        if uncertainty is None:
            return np.full((len(names), len(names)), np.nan)
        rows = [[_number(uncertainty["correlation"][a][b]) for b in names] for a in names]
        return np.asarray(np.array(rows) * std[:, None] * std[None, :], dtype=np.float64)

    @property
    def repetitions(self) -> Optional[Dict[str, Any]]:
        """With `repeat`, of result.json: every recording's own fit, and what they tell together; else None."""
        found: Optional[Dict[str, Any]] = self.data.get("repetitions")
        return found

    @property
    def transfer(self) -> Optional[List[Dict[str, Any]]]:
        """With `transfer`, of result.json: what every recording's own fit predicts of the others; else None."""
        found: Optional[List[Dict[str, Any]]] = self.data.get("transfer")
        return found

    @property
    def status(self) -> str:
        """converged, not_converged or interrupted."""
        return str(self.data["status"])

    @property
    def rmse(self) -> float:
        """Root mean square distance from points to their predictions, m."""
        return _number(self.data["rmse_m"])

    @property
    def message(self) -> str:
        """Why the fit ended; one line."""
        return str(self._take("message"))

    @property
    def predicted(self) -> List[Motion]:
        """Of every recording the predicted positions of its points at its frames."""
        return list(self._take("predicted"))

    @property
    def fields(self) -> Dict[str, NDArray[np.float64]]:
        """{name: values (rows, columns) at the control nodes} of constants that vary over the cloth."""
        return dict(self._take("fields"))

    @property
    def convergence_csv(self) -> str:
        """The text of convergence.csv."""
        return str(self._take("convergence_csv"))

    @property
    def html(self) -> str:
        """The text of report.html: one page for any browser, with a 3D replay."""
        return str(self._take("page"))

    def report(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes report.html, whole or not at all. Raises FileError."""
        View(self.html).save(path)

    def export(
        self, simulators: Union[str, Sequence[str]] = "all", folder: Union[str, "os.PathLike[str]"] = ""
    ) -> Dict[str, str]:
        """{file name: text} of the constants for mujoco, newton, arcsim, blender, ppf; written to `folder`, if given."""
        texts = _clothid.export(self.predicted[0].scene, self.values, simulators)
        for name, text in texts.items() if folder else ():
            with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                file.write(text)
        return texts

    def save(self, folder: Union[str, "os.PathLike[str]"], report: bool = True) -> None:
        """Writes what the program writes: result.json, fabric.json, convergence.csv, predicted.bin and both pages."""
        if self._fit is not None:
            self._fit.save(folder, report)
        else:
            files = {name: file for name, file in self._files.items() if report or name not in _PAGES}
            _clothid.save_files(folder, files)

    def __str__(self) -> str:
        return self.table

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={value:.6g}" for name, value in self.values.items())
        return f"<clothid.Result {values}: {self.data['verdict'][0]}>"

    def _repr_html_(self) -> str:
        """For notebooks: the table, and the report with its replay below it."""
        return f"<pre>{html.escape(self.table)}</pre>{View(self.html)._repr_html_()}"

    def __getstate__(self) -> Dict[str, Any]:
        for name in ("message", "predicted", "fields"):
            self._take(name)
        kept = {name: value for name, value in self._kept.items() if name not in _FILES}
        with tempfile.TemporaryDirectory() as folder:
            self.save(folder)
            files = {path.name: path.read_bytes() for path in sorted(pathlib.Path(folder).iterdir())}
        return {"table": self.table, "data": self.data, "_kept": kept, "_files": files, "_fit": None}
