"""Results files."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from . import _core
from ._tables import require_pandas
from .cases import Path

if TYPE_CHECKING:
    import pandas


class Results:
    """Reads a results file. Arrays own their data: nothing is copied on the way from the file."""

    def __init__(self, file: Path) -> None:
        self._core = _core.CoreResults(os.fspath(file))

    @property
    def file(self) -> str:
        return self._core.file

    @property
    def status(self) -> str:
        """"finished", "failed: ...", "running" or "interrupted"."""
        return self._core.status

    @property
    def program(self) -> str:
        return self._core.program

    @property
    def seed(self) -> int:
        return self._core.seed

    @property
    def timestep(self) -> float:
        """s"""
        return self._core.timestep

    @property
    def wall_time(self) -> float:
        """s"""
        return self._core.wall_time

    @property
    def case_text(self) -> str:
        """Complete TOML text of the case."""
        return self._core.case_text

    @property
    def shapes(self) -> list[str]:
        """Names, in order of their numbers."""
        return self._core.shapes

    @property
    def boundaries(self) -> list[str]:
        """Names, in order of their numbers."""
        return self._core.boundaries

    @property
    def particle_count(self) -> int:
        return self._core.particle_count

    @property
    def times(self) -> _core.Floats:
        """[T] s, of the frames."""
        return self._core.times()

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.times)

    def frame(self, index: int) -> _core.Frame:
        """A Frame: position [N, 3] m (center of mass), orientation [N, 4] w x y z (shape axes to
        world), velocity [N, 3] m/s, angular_velocity [N, 3] rad/s; NaN where a particle is not
        present. A negative index counts from the end."""
        if index < 0:
            index += len(self)
        if index < 0:
            raise _core.InputError(f"{self.file}: has {len(self)} frames")
        return self._core.frame(index)

    @property
    def responses(self) -> dict[str, _core.Response]:
        """Responses by name, as stored when the run finished."""
        return {r.name: r for r in self._core.responses()}

    def measure(self) -> dict[str, _core.Response]:
        """Responses by name, measured now by this version."""
        return {r.name: r for r in self._core.measure()}

    def series(self, path: str) -> _core.Floats:
        """[T] or [T, width] values of a quantity that is kept with every frame: "energy/kinetic", with
        or without the slash of /energy/kinetic in front."""
        return self._core.series(path if path.startswith("/") else "/" + path)

    @property
    def sample_times(self) -> _core.Floats:
        """[M] s, of the samples that [output.samples] of the case recorded; empty without."""
        return self._core.sample_times()

    def samples(self, path: str) -> _core.Floats:
        """[M] or [M, width] samples of a quantity: "motion_frames/container/force"."""
        return self._core.samples(path if path.startswith("/") else "/" + path)

    # Tables

    def particles(self) -> pandas.DataFrame:
        """One row a particle: shape, tag, mass (kg), insert_time, exit_time (s), ..."""
        table = require_pandas().DataFrame(self._core.particle_columns())
        table["shape"] = require_pandas().Categorical.from_codes(table["shape"], categories=self.shapes)
        table.index.name = "particle"
        return table

    def stages(self) -> pandas.DataFrame:
        """One row a stage: name, start, end (s), end_reason."""
        return require_pandas().DataFrame(self._core.stages(), columns=["name", "start", "end", "end_reason"])

    def series_list(self) -> pandas.DataFrame:
        """One row a series: path, unit, width."""
        return require_pandas().DataFrame(self._core.series_list(), columns=["path", "unit", "width"])

    def sample_list(self) -> pandas.DataFrame:
        """One row a quantity that is sampled: path, unit, width."""
        return require_pandas().DataFrame(self._core.sample_list(), columns=["path", "unit", "width"])

    def response_table(self) -> pandas.DataFrame:
        """One row a response with a single value: name, value, uncertainty, unit, method."""
        rows = [(r.name, r.value, r.uncertainties[0] if len(r.uncertainties) else float("nan"),
                 r.unit, r.method) for r in self.responses.values() if len(r.values) == 1]
        columns = ["name", "value", "uncertainty", "unit", "method"]
        return require_pandas().DataFrame(rows, columns=columns).set_index("name")

    def trajectory(self) -> pandas.DataFrame:
        """One row a frame and a present particle: time, particle, x, y, z (m)."""
        import numpy

        tables = []
        for i in range(len(self)):
            frame = self.frame(i)
            present = numpy.flatnonzero(numpy.isfinite(frame.position[:, 0]))
            x, y, z = frame.position[present].T
            tables.append(require_pandas().DataFrame(
                {"time": frame.time, "particle": present, "x": x, "y": y, "z": z}))
        if not tables:
            return require_pandas().DataFrame(columns=["time", "particle", "x", "y", "z"])
        return require_pandas().concat(tables, ignore_index=True)

    def __repr__(self) -> str:
        return (f"<firn.Results {self.file!r}: {self.status}, {self.particle_count} particles, "
                f"{len(self)} frames>")
