"""Calibration of simulators that are Python functions."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import tempfile
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Callable, Optional

from . import _core
from ._tables import require_pandas
from .cases import Case, Path
from .results import Results
from .runs import run

if TYPE_CHECKING:
    import pandas

#: simulator(values by parameter name, seed) -> {"response": value or (value, "unit")}
Simulator = Callable[[dict[str, float], int], dict[str, Any]]


@dataclasses.dataclass
class Parameter:
    """An unknown: its range in `unit`, on a linear or a "log" scale, and perhaps a Gaussian prior."""
    name: str
    min: float
    max: float
    unit: str = ""
    scale: str = "linear"
    prior_mean: Optional[float] = None
    prior_sd: Optional[float] = None


@dataclasses.dataclass
class Target:
    """A measured value with one standard deviation, both in `unit`, and perhaps the standard deviation
    of the simulator's systematic error (discrepancy)."""
    response: str
    value: float
    uncertainty: float
    unit: str = "1"
    discrepancy: float = 0.0


class Calibration:
    """What a calibration found."""

    def __init__(self, core: _core.CoreCalibration, names: list[str]) -> None:
        self._core, self._names = core, names

    @property
    def verdict(self) -> str:
        """"calibrated", "not identifiable" (a ridge of equal responses), "unconfirmed", ..."""
        return self._core.verdict

    @property
    def headline(self) -> str:
        return self._core.headline

    @property
    def runs(self) -> int:
        return self._core.runs

    @property
    def table(self) -> str:
        """All of the answer as text."""
        return self._core.table

    @property
    def answer(self) -> dict[str, Any]:
        """All of the answer, as results.json of `firn calibrate`."""
        answer: dict[str, Any] = json.loads(self._core.json)
        return answer

    @property
    def samples(self) -> _core.Floats:
        """[S, number of parameters] posterior samples; use them with `weights`."""
        return self._core.samples

    @property
    def weights(self) -> _core.Floats:
        """[S], adding up to 1."""
        return self._core.weights

    def estimates(self) -> pandas.DataFrame:
        """One row a parameter: unit, best, median, low, high (95 %), at_min, at_max."""
        columns = ["parameter", "unit", "best", "median", "low", "high", "at_min", "at_max"]
        return require_pandas().DataFrame(self._core.estimates, columns=columns).set_index("parameter")

    def posterior(self) -> pandas.DataFrame:
        """One row a sample: the parameters and its weight."""
        table = require_pandas().DataFrame(self.samples, columns=self._names if len(self.weights) else None)
        return table.assign(weight=self.weights)

    def __repr__(self) -> str:
        return f"<firn.Calibration {self.verdict}: {self.runs} runs>"


def calibrate(simulator: Simulator, parameters: Sequence[Parameter], targets: Sequence[Target], *,
              runs: int, name: str = "study", seed: int = 1, directory: Path = "",
              simulator_version: str = "1", jobs: int = 1) -> Calibration:
    """Fits parameters so that `simulator` meets the targets; docs/calibration.md has the method.

    simulator(values, seed): values by parameter name; returns {"response": value} or {"response":
        (value, "unit")}. Equal arguments give equal responses. Raising RunError makes a failed run,
        NaN an undefined response; other exceptions end the calibration.
    runs: at most so many calls.
    directory: keeps finished runs; a later call with the same problem continues there. Without it
        nothing is kept. Change simulator_version there with every change of the simulator.
    jobs: threads that call the simulator side by side; of use where it releases the interpreter's
        lock, as firn.run() does.
    Ctrl-C stops between two calls and raises KeyboardInterrupt.
    """
    for p in parameters:
        if p.scale not in ("linear", "log"):
            raise _core.InputError(
                f"parameters: {p.name}: scale is {p.scale!r}; expected \"linear\" or \"log\"")
    core = _core.calibrate(
        name,
        [_core.CoreParameter(p.name, p.min, p.max, p.unit, p.scale == "log", p.prior_mean,
                             p.prior_sd) for p in parameters],
        [_core.CoreTarget(t.response, t.value, t.uncertainty, t.unit, t.discrepancy)
         for t in targets],
        runs, seed, simulator, os.fspath(directory), simulator_version, jobs)
    return Calibration(core, [p.name for p in parameters])


def _named(responses: dict[str, _core.Response], name: str) -> tuple[float, str]:
    response = responses.get(_core.current_response_name(name))
    if response is None:
        raise _core.InputError(f"the case has no response {name!r}; it has {', '.join(sorted(responses))}")
    return (response.value if len(response.values) == 1 else math.nan), response.unit


def case_simulator(case: Case, keys: Mapping[str, Sequence[str]],
                   responses: Sequence[str] | Callable[[Results], dict[str, Any]], *,
                   units: Mapping[str, str] | None = None) -> Simulator:
    """A simulator for calibrate() that runs a case in this process.

    keys: for each parameter the key paths of the case that take its value.
    units: for parameters with one, as {"rounding": "mm"}.
    responses: names of responses of the run, or a function of a Results that returns them as
        {"name": value or (value, "unit")}. A named response without a single value is undefined.
    """
    def simulate(values: dict[str, float], seed: int) -> dict[str, Any]:
        overrides: dict[str, Any] = {"case.seed": seed}
        for name, value in values.items():
            unit = (units or {}).get(name)
            overrides.update((key, f"{value!r} {unit}" if unit else value) for key in keys[name])
        with tempfile.TemporaryDirectory(prefix="firn-run-") as folder:
            done = run(case.edit(overrides), os.path.join(folder, "run.h5"))
            if done.status != "finished":
                raise _core.RunError(done.reason)
            if callable(responses):
                return responses(done.results())
            return {name: _named(done.responses, name) for name in responses}

    return simulate
