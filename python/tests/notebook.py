"""Executes a notebook, with other values in its cell of parameters."""

import pathlib

import nbclient
import nbformat


def execute(notebook, folder, parameters=None):
    """The executed notebook; its kernel works in `folder`. Raises CellExecutionError."""
    book = nbformat.read(notebook, as_version=4)
    if parameters:
        cell, = (c for c in book.cells if "parameters" in c.metadata.get("tags", []))
        for name, value in parameters.items():
            path = isinstance(value, pathlib.Path)
            cell.source += f"\n{name} = " + (f"pathlib.Path({str(value)!r})" if path else repr(value))
    nbclient.NotebookClient(book, timeout=None, kernel_name="python3",
                            resources={"metadata": {"path": str(folder)}}).execute()
    return book


def text_of(book):
    """What the cells printed."""
    return "".join(output.text for cell in book.cells if cell.cell_type == "code"
                   for output in cell.outputs if output.output_type == "stream" and output.name == "stdout")


def pictures_of(book):
    """How many pictures the cells drew."""
    return sum("image/png" in output.get("data", {}) for cell in book.cells if cell.cell_type == "code"
               for output in cell.outputs)
