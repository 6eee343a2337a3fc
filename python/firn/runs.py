"""Runs in this process."""

from __future__ import annotations

import os
from typing import Callable, Optional

from . import _core
from .cases import Case, Path
from .results import Results

OnFrame = Callable[[_core.LiveFrame], Optional[bool]]


def _stopping(on_frame: OnFrame | None) -> OnFrame | None:
    """Makes a plain bool of what a callback returns: comparisons of NumPy return another type."""
    if on_frame is None:
        return None
    callback = on_frame

    def call(frame: _core.LiveFrame) -> bool:
        answer = callback(frame)
        return answer is None or bool(answer)

    return call


class Run:
    """What came of a run. run["name"] is a response."""

    def __init__(self, core: _core.CoreRunResult) -> None:
        self._core = core

    @property
    def status(self) -> str:
        """"finished", "failed" or "interrupted"."""
        return self._core.status

    @property
    def reason(self) -> str:
        """One sentence; of a finished run what ended it."""
        return self._core.reason

    @property
    def responses(self) -> dict[str, _core.Response]:
        """Responses by name; empty unless the run is finished."""
        return {r.name: r for r in self._core.responses}

    def __getitem__(self, name: str) -> _core.Response:
        return self.responses[_core.current_response_name(name)]

    @property
    def simulated(self) -> float:
        """s"""
        return self._core.simulated

    @property
    def wall(self) -> float:
        """s"""
        return self._core.wall

    @property
    def steps(self) -> int:
        return self._core.steps

    @property
    def energy(self) -> dict[str, float]:
        """J, at the end."""
        return self._core.energy

    @property
    def largest_overlap(self) -> float:
        """m, over all steps."""
        return self._core.largest_overlap

    @property
    def results_file(self) -> str:
        return self._core.results_file

    def results(self) -> Results:
        """The results file, opened."""
        return Results(self.results_file)

    def __repr__(self) -> str:
        return f"<firn.Run {self.status}: {self.simulated:.4g} s in {self.steps} steps>"


def run(case: Case, results_file: Path, *, threads: int = 1, on_frame: OnFrame | None = None,
        checkpoint_every: float = 60.0) -> Run:
    """Simulates a case in this process and writes its results file.

    on_frame: called with a LiveFrame for each recorded state; False stops the run. The arrays of
    the frame belong to the caller, the frame itself ends with the call.
    Ctrl-C saves the state and raises KeyboardInterrupt; resume() continues. Other threads of Python
    continue during the run.
    """
    return Run(_core.run(case._core, os.fspath(results_file), threads, checkpoint_every,
                         _stopping(on_frame)))


def resume(results_file: Path, *, threads: int = 1, on_frame: OnFrame | None = None,
           checkpoint_every: float = 60.0) -> Run:
    """Continues an interrupted run, with the bits of an uninterrupted one. No Results of this process
    may hold the file open."""
    return Run(_core.resume(os.fspath(results_file), threads, checkpoint_every,
                         _stopping(on_frame)))
