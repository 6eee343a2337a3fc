"""Sphinx configuration of the documentation site. The source folder is the root of the repository.

The pages stay plain Markdown that reads well without a build. The navigation is made of the sections and
links of docs/README.md, so that a page is listed in one place only.
"""

import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]

project = "Firn"
author = "The Firn developers"
copyright = "The Firn developers, Apache-2.0"
extensions = ["myst_parser"]
include_patterns = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "docs/*.md", "docs/tutorials/*.md", "docs/how-to/*.md",
                    "cases/*/README.md"]
root_doc = "docs/README"
source_suffix = {".md": "markdown"}
myst_heading_anchors = 5  # as the Git hosts make them
html_theme = "furo"
html_title = "Firn"
html_show_sphinx = False
html_copy_source = False
smartquotes = False
# Names of formats that Pygments lacks, e.g. ```gnuplot, are no error.
suppress_warnings = ["misc.highlighting_failure"]


def all_pages():
    files = [file for pattern in include_patterns for file in sorted(ROOT.glob(pattern))]
    return [file.relative_to(ROOT).with_suffix("").as_posix() for file in files]


def links(section):
    """Names of the linked pages in their order, each with its anchor or ""."""
    found = re.findall(r"\]\(([^)#]+\.md)(#[^)]*)?\)", section)
    return [((ROOT / "docs" / page).resolve().relative_to(ROOT).with_suffix("").as_posix(), anchor)
            for page, anchor in found]


def navigation(text):
    """Hidden toctrees: one for each section of docs/README.md, with the pages in the order of their first link.

    A page of the reference belongs there, although how-to guides link to it first. Links to a part of a page
    do not count for this.
    """
    sections = {section.partition("\n")[0].partition(":")[0]: links(section)
                for section in re.split(r"^## ", text, flags=re.M)[1:]}
    reference = {name for name, anchor in sections["Reference"] if not anchor}
    seen, trees = set(), []
    for caption, linked in sections.items():
        pages = []
        for name, _ in linked:
            if name not in seen and (caption == "Reference" or name not in reference):
                seen.add(name)
                pages.append("/" + name)
        if pages:
            trees.append("\n".join(["```{toctree}", ":hidden:", f":caption: {caption}", "", *pages, "```"]))
    # Pages without a place in docs/README.md are reachable by the links of other pages.
    for name in all_pages():
        if name not in seen and name != root_doc:
            trees.append("\n".join(["```{toctree}", ":hidden:", "", "/" + name, "```"]))
    return "\n\n".join(trees)


def add_navigation(app, docname, source):
    if docname == root_doc:
        source[0] += "\n\n" + navigation(source[0]) + "\n"


def setup(app):
    app.connect("source-read", add_navigation)
    return {"parallel_read_safe": True}
