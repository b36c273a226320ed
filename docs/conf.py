"""The site: `python -m sphinx -W -b html docs docs/_site` builds it, offline, warnings as errors.

Commands, Python names, laws, figures and the pages of the papers, which are notebooks that are run, are made by the
library while it is built (`generate.py`). Formulas become MathML, the search runs in the browser, and nothing is loaded
from elsewhere.
"""

import sys
from pathlib import Path

from docutils import nodes
from latex2mathml.converter import convert
from pygments.lexer import RegexLexer, bygroups
from pygments.token import Generic, Text

sys.path.insert(0, str(Path(__file__).parent))

import generate

from ropefric import __version__

project = "ropefric"
author = "The ropefric developers"
copyright = author  # noqa: A001  (Sphinx's name for it)
version = release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_site", "paper", "samples"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3

smartquotes = False  # `--option` stays what can be typed
default_role = "literal"

autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_use_rtype = False
add_module_names = False
python_display_short_literal_types = True

html_theme = "furo"
html_title = "ropefric"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_use_index = False  # every name has its page, and the search finds it
html_show_sphinx = False
html_theme_options = {"top_of_page_buttons": []}


class SessionLexer(RegexLexer):
    """Commands stand out from what they print, and nothing of that is taken for a command."""

    name = "console"
    tokens = {"root": [(r"^(\$ )(.*\n)", bygroups(Generic.Prompt, Generic.Strong)), (r".*\n", Text)]}  # noqa: RUF012


def _inline(writer, node):
    writer.body.append(convert(node.astext()))
    raise nodes.SkipNode


def _block(writer, node):
    writer.body.append(f'<div class="math">{convert(node.astext(), display="block")}</div>')
    raise nodes.SkipNode


def setup(app):
    """Write what the library knows of itself before the pages are read, and set formulas without a script."""
    app.add_lexer("console", SessionLexer)
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))
    app.connect("builder-inited", lambda app: generate.everything(Path(app.srcdir) / "generated"))


html_math_renderer = "mathml"
