"""Material records."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

from . import _core
from ._tables import require_pandas
from .cases import Path

if TYPE_CHECKING:
    import pandas


def material_records(database: Path = "") -> pandas.DataFrame:
    """All values of all material records: one row a record, version and parameter.

    database: file of records; the user's own by default. Records that ship with Firn are included.
    Columns: name, version, shipped, sha256, parameter, keys, value, uncertainty, low, high, unit.
    Uncertainty is one standard deviation, low and high a 95 % interval; NaN or None: not given.
    """
    rows = []
    for name, version, sha256, shipped, text in _core.material_records(os.fspath(database)):
        for p in json.loads(text).get("parameters", []):
            low, high = p.get("interval_95") or (None, None)
            rows.append((name, version, shipped, sha256, p["name"], p["keys"], p["value"],
                         p.get("uncertainty"), low, high, p["unit"]))
    return require_pandas().DataFrame(rows, columns=[
        "name", "version", "shipped", "sha256", "parameter", "keys", "value", "uncertainty", "low",
        "high", "unit"])


def material_record(name: str, version: int = 0, database: Path = "") -> dict[str, Any]:
    """One record with everything it holds, as a dict; version 0: the newest."""
    found = [text for n, v, _, _, text in _core.material_records(os.fspath(database))
             if n == name and version in (0, v)]
    if not found:
        raise _core.InputError(f"{name}: no such material record; see firn.material_records()")
    record: dict[str, Any] = json.loads(found[-1])
    return record
