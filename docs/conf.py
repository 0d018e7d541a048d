"""The documentation site: ``bash scripts/docs.sh``."""

import os
import sys
from pathlib import Path

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ.setdefault("MPLBACKEND", "Agg")
HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import generate  # noqa: E402

import cprm_gym  # noqa: E402

project = "cprm_gym"
author = "The cprm_gym authors"
project_copyright = "2026, The cprm_gym authors"
release = version = cprm_gym.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build"]
myst_enable_extensions = ["deflist"]
myst_heading_anchors = 3
suppress_warnings = ["misc.highlighting_failure"]

autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_default_options = {"members": True, "undoc-members": False, "show-inheritance": False}
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_param = False  # types of parameters are prose, not references
OUR_SECTIONS = ("Description", "Actions", "Observations", "Rewards", "Start", "End", "Arguments", "Version history", "Success")
napoleon_custom_sections = [("Attributes", "params_style"), *OUR_SECTIONS]

html_theme = "furo"
html_title = f"cprm_gym {release}"
html_copy_source = False


def setup(app):
    """The generated pages are written before the first page is read."""
    generate.write_all(HERE / "generated")
