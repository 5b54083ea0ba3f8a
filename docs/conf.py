"""How the documentation is built: ``python -m sphinx -W -b html docs build/html``, offline."""

from __future__ import annotations

import importlib.metadata
import logging
import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))  # the studies, which are not installed

project = "woodpecker-toy"
author = "The woodpecker-toy developers"
copyright = "2026, " + author  # noqa: A001 - the name that Sphinx reads
try:
    release = importlib.metadata.version("woodpecker-toy")
except importlib.metadata.PackageNotFoundError:  # run from a checkout
    release = "unknown"

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "sphinx_gallery.gen_gallery",
    "sphinxcontrib.bibtex",
]
exclude_patterns = ["_build", "tutorials/**", "**/GALLERY_HEADER.rst"]
source_suffix = {".rst": "restructuredtext", ".md": "markdown"}
nitpicky = False

# --- Pages ---------------------------------------------------------------------------------------

myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
bibtex_bibfiles = ["../references.bib"]
bibtex_default_style = "unsrt"
bibtex_reference_style = "author_year"

# --- Reference -----------------------------------------------------------------------------------

autosummary_generate = True
autodoc_typehints = "signature"  # sections of numpydoc leave no room for them
autodoc_typehints_format = "short"
autodoc_type_aliases = {"npt.ArrayLike": "npt.ArrayLike"}  # not all that it stands for
python_maximum_signature_line_length = 88  # longer ones have a line for each argument
autodoc_preserve_defaults = True  # such as Settings(), and not all that they hold
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False
templates_path = ["_templates"]

# --- Tutorials, which are run --------------------------------------------------------------------

sphinx_gallery_conf = {
    "examples_dirs": "tutorials",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "only_warn_on_example_error": False,
    "download_all_examples": False,
    "show_signature": False,
    "min_reported_time": 1e9,
    "show_memory": False,
    "matplotlib_animations": False,
    "image_scrapers": ("matplotlib",),
    "capture_repr": ("_repr_html_", "__repr__"),
    "ignore_repr_types": r"matplotlib|list|Axes",
}

# --- Look ----------------------------------------------------------------------------------------

html_math_renderer = "mathml"  # which browsers show by themselves: no script, no network
html_theme = "pydata_sphinx_theme"
html_title = "woodpecker and pwmap"
html_copy_source = False
html_show_sourcelink = False
html_static_path = ["_static"]
html_css_files = ["custom.css"]
html_sidebars = {  # pages that have none beside them: an empty list of these would be shown
    page: []
    for page in (
        "index", "get_started", "explore", "explore_tour",
        "guide/*", "reproduce", "long_run", "reference/commands",
        "reference/plots", "reference/symbols", "reference/special_points", "reference/equations",
        "proofs", "certificates_of_maps", "results", "comparison", "limits", "testing",
        "bibliography", "genindex", "py-modindex", "search",
    )
}  # fmt: skip
html_theme_options = {
    "header_links_before_dropdown": 3,  # more do not fit into one row
    "logo": {"text": "woodpecker and pwmap"},
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
    "show_prev_next": True,
    "footer_start": ["copyright"],
    "footer_end": [],
}


def _in_mathml(self: Any, node: nodes.math | nodes.math_block) -> None:
    block = isinstance(node, nodes.math_block)
    self.body.append(tex2mathml(node.astext(), as_block=block))
    raise nodes.SkipNode


def _compile_quietly(app: Any) -> None:
    """Compile the kernel before a tutorial does, whose page would show the message of it."""
    from woodpecker import Toy, first_return

    logger = logging.getLogger("woodpecker")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        first_return(Toy(), -0.53)
    finally:
        logger.setLevel(level)


def setup(app: Any) -> None:
    """Formulas as MathML; the kernel is compiled before the tutorials run."""
    app.connect("builder-inited", _compile_quietly, priority=1)
    app.add_html_math_renderer("mathml", (_in_mathml, None), (_in_mathml, None))
