"""How Sphinx builds these pages: ``make docs``."""

from __future__ import annotations

from importlib.metadata import version as version_of

project = "Rota"
version = release = version_of("rota")
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.viewcode"]
exclude_patterns = ["_build", "jupyter_execute"]  # what this makes itself
html_theme = "furo"
html_title = "Rota"
pygments_style = "friendly"

myst_heading_anchors = 3
# notebooks are kept without output and run whenever the pages are made; a cell that fails fails the build
nb_execution_mode = "force"
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_merge_streams = True

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
autodoc_default_options = {"members": True}
python_use_unqualified_type_names = True
