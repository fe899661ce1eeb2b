"""The manual: the pages of this folder, the gallery of examples/ and the docstrings, put together by Sphinx.

pip install -e ".[docs]" && sphinx-build -W --keep-going docs docs/_build
"""

import sys
from pathlib import Path

import phblocks

sys.path.insert(0, str(Path(__file__).parent))  # gallery_figures is here

project = "phblocks"
author = copyright = "The phblocks developers"
version = release = phblocks.__version__

extensions = ["myst_parser", "sphinx.ext.autosummary", "numpydoc", "sphinx_gallery.gen_gallery"]
exclude_patterns = ["_build", "**/*.ipynb"]
root_doc = "index"

# --- pages -----------------------------------------------------------------------------------------------------------

# They are read as plain Markdown too, where links lead to headings: notation.md#ports-and-causality.
myst_heading_anchors = 4
highlight_language = "text"  # of indented blocks, which are equations

# --- docstrings ------------------------------------------------------------------------------------------------------

autosummary_generate = True
templates_path = ["_templates"]
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the sections of the docstrings say it, with shapes and units
numpydoc_show_class_members = False  # autodoc shows them
numpydoc_class_members_toctree = False

nitpicky = True

# --- gallery ---------------------------------------------------------------------------------------------------------

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"/(?!standalone_)\w+\.py",  # which are run: all but the one that reads what another tool got
    "image_scrapers": ("gallery_figures.scrape",),
    "reset_argv": "gallery_figures.arguments",
    "reset_modules": (),
    "within_subsection_order": "gallery_figures.Order",
    "capture_repr": (),
    "default_thumb_file": str(Path(__file__).parent / "images" / "four_bar.png"),
    "download_all_examples": False,
    "show_signature": False,
    "min_reported_time": 1e9,  # how long it took here tells nobody anything
    "write_computation_times": False,
    "matplotlib_animations": False,
}

# --- pages in HTML ---------------------------------------------------------------------------------------------------

html_theme = "furo"
html_title = "phblocks"
html_static_path = ["_static"]
html_css_files = ["wide.css"]
html_show_sourcelink = False
html_copy_source = False
