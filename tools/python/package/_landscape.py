"""The cost over two parameters."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Dict, Iterable, List, Mapping, Optional, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from clothid import _clothid
from clothid._clothid import Motion

Axis = Union[str, Tuple[str, float, float, int], Tuple[str, float, float, int, str]]


@dataclass(frozen=True)
class Landscape:
    """Costs of S settings (variants of the scene) in W windows (the whole and zooms) of X times Y cells.

    A cell that could not be simulated has the cost NaN.
    """

    parameters: Tuple[str, str]
    settings: List[Tuple[str, str]]  # name and contact mode
    zooms: List[float]
    x: NDArray[np.float64]  # (W, X)
    y: NDArray[np.float64]  # (W, Y)
    cost: NDArray[np.float64]  # (S, W, Y, X)
    gradient_x: Optional[NDArray[np.float64]]  # likewise, where asked for; on a log axis by the logarithm
    gradient_y: Optional[NDArray[np.float64]]
    summary: Dict[str, Any]  # summary.json: minimum, roughness and contact events of every window
    table: str

    def __str__(self) -> str:
        return self.table


def _axis(axis: Axis) -> str:
    if isinstance(axis, str):
        return axis
    numbers = f"{axis[0]}={float(axis[1])!r}:{float(axis[2])!r}:{axis[3]}"
    return numbers + "".join(f":{word}" for word in axis[4:])


def landscape(
    motion: Motion,
    x: Axis,
    y: Axis,
    *,
    zoom: Iterable[float] = (),
    zoom_around: Optional[Mapping[str, float]] = None,
    zoom_only: bool = False,
    sweep: str = "",
    contact: str = "",
    set: Optional[Mapping[str, float]] = None,
    sigma: Union[str, float] = "recorded",
    initial: str = "estimated",
    gradients: bool = False,
    threads: int = 1,
) -> Landscape:
    """Scans the cost of a recording over two parameters, as the program `landscape` does with the flags of these names.

    An axis is ("mu", 0.0, 0.6, 7), ("k_stretch", 20, 700, 7, "log") or the text of the program, "mu=0:0.6:7".
    """
    flags = {
        "x": _axis(x),
        "y": _axis(y),
        "zoom": ",".join(repr(float(share)) for share in zoom),
        "zoom_around": ",".join(f"{name}={float(value)!r}" for name, value in (zoom_around or {}).items()),
        "sweep": sweep,
        "contact": contact,
    }
    words = sigma if isinstance(sigma, str) else repr(float(sigma))
    raw = _clothid.run_landscape(motion, flags, zoom_only, gradients, dict(set or {}), words, initial, threads)
    raw["summary"] = json.loads(raw["summary"])
    return Landscape(**raw)
