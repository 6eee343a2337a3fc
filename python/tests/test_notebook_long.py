"""The notebook of the drained calibration as it is shipped: 880 cubes, 22 runs."""

import re

from conftest import SOURCE
from notebook import execute, pictures_of, text_of


def test_notebook(tmp_path):
    examples = SOURCE / "examples" / "python"
    book = execute(examples / "drained_calibration.ipynb", tmp_path,
                   {"study_file": SOURCE / "cases" / "drained_repose" / "study.toml"})
    text = text_of(book)
    angle = float(re.search(r"angle of repose (-?\d+\.\d) \+- ", text)[1])
    assert 10 < angle < 35, text   # the frictions of the paper's text
    assert re.search(r"^22 runs in", text, re.MULTILINE), text
    assert pictures_of(book) == 2
