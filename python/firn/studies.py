"""Studies, validations, sweeps and optimizations: started through the program, read as tables.

Each simulation is a separate process there, so that a crash of one cannot take others along.
"""

from __future__ import annotations

import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Sequence
from typing import IO, TYPE_CHECKING, Any, Callable, Generic, TypeVar

from . import _core
from ._tables import require_pandas
from .cases import Path

if TYPE_CHECKING:
    import pandas

R = TypeVar("R")


def program() -> str:
    """Path of the firn program: $FIRN_PROGRAM, or that on PATH."""
    named = os.environ.get("FIRN_PROGRAM")
    if named:
        return named
    found = shutil.which("firn")
    if not found:
        raise _core.RunError("the program firn is not found; install it, or set FIRN_PROGRAM")
    return found


class _Folder:
    """Results of a finished batch."""

    def __init__(self, directory: Path) -> None:
        self.directory = pathlib.Path(directory)
        file = self.directory / "results.json"
        try:
            #: Everything that the program wrote to results.json, with the names of this version.
            self.answer: dict[str, Any] = json.loads(
                _core.current_results_json(file.read_text(encoding="utf-8")))
        except OSError as error:
            raise _core.InputError(f"{file}: cannot be read ({error.strerror}); expected the "
                                   "folder of a finished batch") from error
        except ValueError as error:
            raise _core.InputError(f"{file}: is no JSON: {error}") from error

    def _csv(self, name: str) -> pandas.DataFrame:
        file = self.directory / name
        if not file.exists():
            raise _core.InputError(f"{file}: no such file")
        return require_pandas().read_csv(file)

    def _require(self, kind: str, *keys: str) -> None:
        if not isinstance(self.answer, dict) or any(key not in self.answer for key in keys):
            raise _core.InputError(f"{self.directory}: holds no {kind}")


class StudyResults(_Folder):
    """What a calibration study found: the folder of `firn calibrate`."""

    def __init__(self, directory: Path) -> None:
        super().__init__(directory)
        self._require("study", "verdict")

    @property
    def verdict(self) -> str:
        return str(self.answer["verdict"])

    @property
    def headline(self) -> str:
        return str(self.answer.get("headline", ""))

    def parameters(self) -> pandas.DataFrame:
        """One row a parameter: min, max, unit, scale, best, median, low, high (95 %)."""
        best = (self.answer.get("estimate") or {}).get("parameters", {})
        rows = []
        for p in self.answer.get("parameters", []):
            low, high = p.get("interval_95", (None, None))
            rows.append((p["name"], p["min"], p["max"], p["unit"], p["scale"], best.get(p["name"]),
                         p.get("median"), low, high))
        return require_pandas().DataFrame(rows, columns=[
            "name", "min", "max", "unit", "scale", "best", "median", "low", "high"
        ]).set_index("name")

    def targets(self) -> pandas.DataFrame:
        """One row a target: value, uncertainty, unit, source, and the range that was reached."""
        rows = [(t["response"], t["value"], t["uncertainty"], t["unit"], t["source"],
                 t.get("reach", {}).get("lowest"), t.get("reach", {}).get("highest"))
                for t in self.answer.get("targets", [])]
        return require_pandas().DataFrame(rows, columns=[
            "response", "value", "uncertainty", "unit", "source", "lowest", "highest"
        ]).set_index("response")

    def predictions(self) -> pandas.DataFrame:
        """One row a target: measured value and uncertainty; quantiles of the mean response and of a
        single run as the posterior predicts them, columns (kind, probability).

        Empty for a study of a version that did not predict."""
        rows: dict[tuple[str, str | float], list[float]] = {}
        index: list[str] = []
        for t in self.answer.get("targets", []):
            predicted = t.get("posterior_predictive")
            if not predicted:
                continue
            index.append(t["response"])
            rows.setdefault(("measured", "value"), []).append(t["value"])
            rows.setdefault(("measured", "uncertainty"), []).append(t["uncertainty"])
            for kind in ("mean_response", "single_run"):
                for p, x in zip(predicted["probabilities"], predicted[kind]["quantiles"]):
                    rows.setdefault((kind, p), []).append(x)
        return require_pandas().DataFrame(rows, index=index)

    def history(self) -> pandas.DataFrame:
        """One row a round of runs and parameter: the estimate after it, with the number of runs,
        median, low_68, high_68, low_95, high_95.

        Empty for a study of a version that kept no history."""
        rows = [(h["after"], h["runs"], name, p["median"], *p["interval_68"], *p["interval_95"])
                for h in self.answer.get("estimate_history", [])
                for name, p in h["parameters"].items()]
        return require_pandas().DataFrame(rows, columns=[
            "after", "runs", "name", "median", "low_68", "high_68", "low_95", "high_95"])

    def runs(self) -> pandas.DataFrame:
        """One row a run, as runs.csv."""
        return self._csv("runs.csv")

    def posterior(self) -> pandas.DataFrame:
        """One row a sample with its weight, as posterior.csv."""
        return self._csv("posterior.csv")


class SweepResults(_Folder):
    """What a sweep measured: the folder of `firn sweep`."""

    def __init__(self, directory: Path) -> None:
        super().__init__(directory)
        self._require("sweep", "combinations")

    def runs(self) -> pandas.DataFrame:
        """One row a run, as runs.csv."""
        return self._csv("runs.csv")

    def combinations(self) -> pandas.DataFrame:
        """One row a combination of values: mean and standard deviation of each response."""
        rows = []
        for c in self.answer["combinations"]:
            row = dict(c["values"])
            for name, scatter in c.get("responses", {}).items():
                row[name] = scatter["mean"]
                row[name + "_sd"] = scatter["standard_deviation"]
            rows.append(row)
        return require_pandas().DataFrame(rows)


class OptimizationResults(_Folder):
    """What an optimization found: the folder of `firn optimize`."""

    def __init__(self, directory: Path) -> None:
        super().__init__(directory)
        self._require("optimization", "goal", "objective")

    @property
    def verdict(self) -> str:
        return str(self.answer["verdict"])

    @property
    def headline(self) -> str:
        return str(self.answer["headline"])

    def _rows(self, designs: list[dict[str, Any]]) -> pandas.DataFrame:
        names = [p["name"] for p in self.answer["parameters"]]
        limits = [f"{t['response']} {t['side']} {t['threshold']:g}"
                  for t in self.answer.get("limits", [])]
        rows = []
        for d in designs:
            row = {"design": d["name"], **dict(zip(names, d["values"]))}
            row.update({k: d[k] for k in ("runs", "finished", "mean", "standard_deviation",
                                          "predicted_mean", "predicted_sd", "limits_kept")})
            for limit, event in zip(limits, d.get("events", [])):
                row[limit] = event["events"]
            rows.append(row)
        return require_pandas().DataFrame(rows)

    def designs(self) -> pandas.DataFrame:
        """One row a design of the search: parameters, objective, events, and what the models say."""
        return self._rows(self.answer.get("designs", []))

    def confirmed(self) -> pandas.DataFrame:
        """The best design and the compared ones, by fresh seeds. Empty if there is none."""
        best = self.answer.get("best")
        return self._rows([best, *self.answer.get("compared", [])] if best else [])

    def runs(self) -> pandas.DataFrame:
        """One row a run, as runs.csv."""
        return self._csv("runs.csv")


class ValidationResults(_Folder):
    """What a validation found: the folder of `firn validate`."""

    def __init__(self, directory: Path) -> None:
        super().__init__(directory)
        self._require("validation", "comparisons")

    def comparisons(self) -> pandas.DataFrame:
        """One row a comparison: verdict, and simulated, measured, comparison_error where it compares
        values."""
        rows = []
        for c in self.answer["comparisons"]:
            value = c.get("value", {})
            rows.append((c["name"], c["title"], c["kind"], c["experiment"], c["parameter_set"],
                         c["verdict"], value.get("simulated"), value.get("measured"),
                         value.get("comparison_error"), value.get("expanded_uncertainty"), value.get("unit"),
                         c["headline"]))
        return require_pandas().DataFrame(rows, columns=[
            "name", "title", "kind", "experiment", "parameter_set", "verdict", "simulated",
            "measured", "comparison_error", "expanded_uncertainty", "unit", "headline"])

    def runs(self) -> pandas.DataFrame:
        """One row a run: experiment, key, parameter_set, seed, status, ..."""
        rows = [{"experiment": e["name"], **r}
                for e in self.answer.get("experiments", []) for r in e.get("runs", [])]
        return require_pandas().DataFrame(rows)


class Batch(Generic[R]):
    """A batch that runs in separate processes. Leaving a with block interrupts it."""

    def __init__(self, process: subprocess.Popen[bytes], log: IO[bytes], directory: Path,
                 results: Callable[[Path], R]) -> None:
        self._process, self._log, self._results = process, log, results
        self.directory = pathlib.Path(directory)

    @property
    def running(self) -> bool:
        return self._process.poll() is None

    def interrupt(self) -> None:
        """Saves what is under way and stops; a later start() continues."""
        if self.running:
            self._process.send_signal(signal.SIGINT)

    def wait(self, timeout: float | None = None) -> R:
        """Results, once it has finished. Ctrl-C interrupts the batch as well.

        Raises TimeoutError after `timeout` s (the batch continues), InputError for a wrong file,
        RunError for a batch that failed or was interrupted."""
        try:
            status = self._process.wait(timeout)
        except subprocess.TimeoutExpired as error:
            raise TimeoutError(f"{self.directory}: not finished after {timeout} s") from error
        except KeyboardInterrupt:
            self.interrupt()
            self._process.wait()
            raise
        if status == 0:
            return self._results(self.directory)
        self._log.seek(0)
        lines = self._log.read().decode("utf-8", "replace").strip().splitlines()
        message = lines[-1].removeprefix("firn: ") if lines else f"exit status {status}"
        raise (_core.InputError if status == 2 else _core.RunError)(message)

    def __enter__(self) -> Batch[R]:
        return self

    def __exit__(self, *_: object) -> None:
        self.interrupt()
        self._process.wait()


class _Startable(Generic[R]):
    command: str
    results: Callable[[Path], R]

    def __init__(self, file: Path) -> None:
        self.file = pathlib.Path(file)

    def start(self, directory: Path, *, jobs: int | None = None, store: Path | None = None,
              arguments: Sequence[str] = ()) -> Batch[R]:
        """Starts it, or continues what is in `directory`; returns a Batch at once.

        jobs: simulations side by side, one per core by default.
        store: file of outcomes that batches share; by default none is shared.
        arguments: further arguments of the command."""
        command = [program(), self.command, str(self.file), "--output", os.fspath(directory),
                   "--progress", "none"]
        command += ["--jobs", str(jobs)] if jobs else []
        command += ["--cache", os.fspath(store)] if store else ["--no-cache"]
        log = tempfile.TemporaryFile()
        # A separate process group: Ctrl-C reaches it through wait() alone.
        process = subprocess.Popen([*command, *arguments], stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=log, start_new_session=True)
        return Batch(process, log, directory, type(self).results)

    def run(self, directory: Path, **options: Any) -> R:
        """start() and wait()."""
        return self.start(directory, **options).wait()


class Study(_Startable[StudyResults]):
    """A study file: fits parameters of cases to measurements."""
    command, results = "calibrate", StudyResults


class Sweep(_Startable[SweepResults]):
    """A sweep file: runs a case over values of its keys."""
    command, results = "sweep", SweepResults


class Optimization(_Startable[OptimizationResults]):
    """An optimization file: searches for the best design within limits."""
    command, results = "optimize", OptimizationResults


class Validation(_Startable[ValidationResults]):
    """A validation suite: compares simulations with experiments."""
    command, results = "validate", ValidationResults
