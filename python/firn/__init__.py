"""Firn in Python: cases, runs, results, studies and calibration.

>>> import firn
>>> case = firn.Case.load("case.toml", {"interactions.ice-ice.static_friction": 0.2})
>>> run = firn.run(case, "run.h5")
>>> run["slot_count"].value

SI units throughout. Functions that return tables need pandas.
"""

from ._core import Frame, InputError, LiveFrame, Response, RunError
from .calibration import Calibration, Parameter, Target, calibrate, case_simulator
from .cases import Case
from .materials import material_records
from .results import Results
from .runs import Run, resume, run
from .studies import (Batch, Optimization, OptimizationResults, Study, StudyResults, Sweep,
                      SweepResults, Validation, ValidationResults, program)

InputError.__doc__ = "A mistake in what was given: one line that says what is expected."
RunError.__doc__ = "A simulation or a program that failed."

__all__ = [
    "Batch", "Calibration", "Case", "Frame", "InputError", "LiveFrame", "Optimization",
    "OptimizationResults", "Parameter", "Response", "Results", "Run", "RunError", "Study",
    "StudyResults", "Sweep", "SweepResults", "Target", "Validation", "ValidationResults",
    "calibrate", "case_simulator", "material_records", "program", "resume", "run",
]
