"""The site: Sphinx over the pages of this folder. `make site` builds it, every warning an error."""

from __future__ import annotations

import contextlib
import io
import os
import re
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

import dressing_sim
from dressing_sim.cli import main

ROOT = Path(__file__).resolve().parents[1]

project = "dressing_sim"
author = "The dressing_sim authors"
project_copyright = "The dressing_sim authors"
# A site belongs to a version: a release packs the pages that were built from it.
version = release = dressing_sim.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
]
source_suffix = {".md": "markdown"}
root_doc = "index"
exclude_patterns = ["results/*", "planar/table.md"]

# Headings are linked to as on GitHub, where these pages are read too.
myst_heading_anchors = 4
myst_links_external_new_tab = False
# Whatever has a scheme is outside; all else must be a page or a file that is there.
myst_url_schemes = ["http", "https"]

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
autodoc_preserve_defaults = True
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
# A name in single backticks is code, as in the pages.
default_role = "code"
# C's and Python's own names are not looked up on another site, which may be away.
nitpicky = False

html_theme = "furo"
html_title = f"dressing_sim {release}"
html_copy_source = False
html_show_sourcelink = False
# Nothing is fetched from elsewhere, neither fonts nor scripts: the pages are read from a folder, on
# a robot's computer or in a hospital without a network, and nobody is told who reads them. Furo
# brings no web fonts; formulas are plain text, so MathJax is not needed. `tests/pages/test_site.py`
# holds it.
html_theme_options = {
    "light_css_variables": {"font-stack": "system-ui, sans-serif"},
    "dark_css_variables": {"font-stack": "system-ui, sans-serif"},
}
# Outside links, which `make links` asks for; papers' publishers refuse robots.
linkcheck_ignore = [r"https://doi\.org/.*"]


class CommandHelp(SphinxDirective):
    """What ``dressing-sim COMMAND --help`` prints, of every command, so that no page can differ."""

    def run(self) -> list[nodes.Node]:
        """A section a command, with its help text."""
        (commands,) = re.findall(r"\{([\w,]+)\}", help_of())[:1]
        return [self._section(name) for name in commands.split(",")]

    def _section(self, name: str) -> nodes.section:
        section = nodes.section(ids=[name])
        section += nodes.title(text=name)
        section += nodes.literal_block(text=help_of(name), language="text")
        return section


def help_of(*command: str) -> str:
    """The help text of a command, or of all, 88 columns wide and without colours."""
    os.environ.update(COLUMNS="88", NO_COLOR="1")
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.suppress(SystemExit):
        main([*command, "--help"])
    return printed.getvalue()


def setup(app: Sphinx) -> None:
    """Add the directive."""
    app.add_directive("command-help", CommandHelp)
