"""pandas, for the functions that need it."""

from typing import Any


def require_pandas() -> Any:
    try:
        import pandas
    except ImportError as error:
        raise ImportError(
            "tables need pandas: install python3-pandas, or pip install pandas") from error
    return pandas
