"""Cases: the TOML files that describe experiments."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union

from . import _core

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Path = Union[str, "os.PathLike[str]"]
Overrides = Mapping[str, Any]

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+\Z")


def toml_value(value: Any) -> str:
    """A Python value as TOML text: numbers, booleans, strings, lists and dicts of them."""
    if hasattr(value, "tolist"):  # NumPy
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml_value(v) for v in value) + "]"
    if isinstance(value, dict):
        items = (f"{k if _BARE_KEY.match(k) else json.dumps(k)} = {toml_value(v)}"
                 for k, v in value.items())
        return "{ " + ", ".join(items) + " }"
    raise TypeError(f"{value!r} has no TOML form; expected a number, a string, a list or a dict")


def _overrides(values: Overrides | None) -> list[tuple[str, str]]:
    return [(key, toml_value(value)) for key, value in (values or {}).items()]


class Case:
    """A checked case. Constant: edit() makes another one."""

    def __init__(self, core: _core.CoreCase) -> None:
        self._core = core

    @classmethod
    def load(cls, file: Path, overrides: Overrides | None = None,
             materials: Sequence[str] = ()) -> Case:
        """Reads a case file.

        overrides: values by key path, as {"case.seed": 2, "case.duration": "1 s"}.
        materials: material records, "NAME[@VERSION][#SAMPLE]".
        Raises InputError with one line: file, line, key, what is expected.
        """
        return cls(_core.CoreCase.load(os.fspath(file), _overrides(overrides), list(materials)))

    @classmethod
    def parse(cls, text: str, directory: Path = ".", overrides: Overrides | None = None) -> Case:
        """Reads TOML text; relative names of files in it start at `directory`."""
        return cls(_core.CoreCase.parse(text, os.fspath(directory), _overrides(overrides)))

    def edit(self, overrides: Overrides) -> Case:
        """The same case with other values."""
        return Case(self._core.with_overrides(_overrides(overrides)))

    @property
    def name(self) -> str:
        return self._core.name

    @property
    def duration(self) -> float:
        """Latest end, s."""
        return self._core.duration

    @property
    def seed(self) -> int:
        return self._core.seed

    @property
    def timestep(self) -> float:
        """s"""
        return self._core.timestep

    @property
    def frame_interval(self) -> float:
        """s; 0: only the first and the last state are recorded."""
        return self._core.frame_interval

    @property
    def particle_count(self) -> int:
        """Of all particles that may ever come."""
        return self._core.particle_count

    @property
    def shapes(self) -> list[dict[str, Any]]:
        """Facts of each shape as a dict: name, mass (kg), volume (m^3), box (m), ..."""
        return self._core.shapes

    @property
    def boundaries(self) -> list[str]:
        """Names, in order of their numbers."""
        return self._core.boundaries

    @property
    def text(self) -> str:
        """Complete TOML text with all defaults."""
        return self._core.text

    def shape_mesh(self, index: int = 0) -> tuple[_core.Floats, NDArray[np.int32]]:
        """Vertices [V, 3] in m and triangles [T, 3] of a shape, in its own axes."""
        return self._core.shape_mesh(index)

    def __repr__(self) -> str:
        return f"<firn.Case {self.name!r}: {self.particle_count} particles, seed {self.seed}>"
