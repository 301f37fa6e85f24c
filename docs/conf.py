"""Sphinx, as `python -m sphinx -W docs BUILD` and rosdoc2 run it."""

import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from pygments.lexers import TextLexer
from sphinx.highlighting import lexers

if find_spec("haul_ros") is None:
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

for _language in ("mermaid", "csv"):  # which Pygments does not know
    lexers[_language] = TextLexer()

project = "haul_ros"
copyright = "haul_ros maintainers, Apache-2.0"
if find_spec("haul_ros"):  # rosdoc2 runs this file from elsewhere, and knows the version from package.xml
    release = import_module("haul_ros.version").__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
myst_enable_extensions = ["dollarmath", "fieldlist"]
myst_heading_anchors = 3
default_role = "code"  # docstrings name things in single backticks

napoleon_use_ivar = True
autodoc_typehints = "description"
autodoc_member_order = "bysource"
# Of what is not installed where the pages are built, names are enough
autodoc_mock_imports = [
    name for name in ("numba", "mcap", "rosbags", "ruamel.yaml") if find_spec(name.split(".")[0]) is None
]

html_theme = "sphinx_rtd_theme"
