"""Sphinx's settings for the pages of guides and reference; tools/reference/build says where things are."""

import os

from sphinx.util import logging

logger = logging.getLogger(__name__)

project = "parloc"
version = release = os.environ["PARLOC_VERSION"]
extensions = ["breathe", "myst_parser", "sphinx.ext.autodoc"]
html_theme = "furo"
html_title = f"parloc {version}"
html_copy_source = False

# Guides are Markdown as GitHub shows it, its anchors of headings included.
myst_heading_anchors = 4

# C++: declarations by header, each a group that doxygen_filter made.
breathe_projects = {"parloc": os.environ["PARLOC_DOXYGEN"] + "/xml"}
breathe_default_project = "parloc"
breathe_default_members = ("members",)
breathe_show_include = False

# Python: the package with its stubs in the place of the compiled module, whose signatures Python cannot see.
autoclass_content = "both"
autodoc_default_options = {"members": True, "undoc-members": True, "special-members": "__matmul__"}
autodoc_member_order = "bysource"
autodoc_type_aliases = {"ArrayLike": "numpy.typing.ArrayLike"}
default_role = "code"

# Every name that a declaration or a text refers to has a place in these pages, or is another library's.
nitpicky = True
nitpick_ignore_regex = [
    ("cpp:.*", r"(parloc|SIZE_MAX|std|(std::)?[a-z0-9_]+_t|std::.*)"),
    ("py:.*", r"(numpy|NDArray|ArrayLike|collections|os|pathlib|matplotlib|pandas|evo|typing)(\..*)?"),
]


def setup(app):
    app.connect("autodoc-process-docstring", require_text)
    app.connect("env-check-consistency", require_all_names)


def require_text(app, what, name, thing, options, lines):
    if what != "attribute" and not any(lines):
        logger.warning("%s is not documented", name)


def require_all_names(app, environment):
    import parloc

    shown = environment.get_domain("py").objects
    for name in parloc.__all__:
        if name != "__version__" and f"parloc.{name}" not in shown:
            logger.warning("parloc.%s is on no page: tools/reference/pages/python", name)
