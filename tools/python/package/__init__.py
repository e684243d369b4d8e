"""clothid fits the friction and the stiffness of a cloth simulation to recorded motion.

    recording = clothid.Motion(positions, times=times, scene="scene.json")
    print(clothid.check(recording))
    result = clothid.identify(recording, fit=["mu", "k_stretch"])
    print(result)

All numbers are in SI units, all arrays C-contiguous with time first: positions are (T, N, 3), in m. Calls that take
long let other threads run, and Ctrl-C ends them. What cannot be done raises a `clothid.Error`.
"""

from clothid._clothid import (
    Error,
    FileError,
    InputError,
    Motion,
    Rollout,
    Scene,
    SimulationError,
    UsageError,
    __version__,
    export,
    simulate,
)
from clothid._identify import Finding, Findings, RecordingWarning, check, identify
from clothid._landscape import Landscape, landscape
from clothid._plan import Plan, plan
from clothid._predict import Prediction, leave_one_out, predict
from clothid._result import Estimate, Result, Verdict
from clothid._view import View

__all__ = [
    "Error",
    "Estimate",
    "FileError",
    "Finding",
    "Findings",
    "InputError",
    "Landscape",
    "Motion",
    "Plan",
    "Prediction",
    "RecordingWarning",
    "Result",
    "Rollout",
    "Scene",
    "SimulationError",
    "UsageError",
    "Verdict",
    "View",
    "__version__",
    "check",
    "export",
    "identify",
    "landscape",
    "leave_one_out",
    "plan",
    "predict",
    "simulate",
]
