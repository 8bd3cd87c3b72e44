# SPDX-License-Identifier: Apache-2.0
"""Configuration of Sphinx. tools/site.sh runs it on the folder that stage.py makes."""
import os
import re


project = "spheretree"
author = "The spheretree authors"
copyright = author  # of every page
version = release = os.environ["SPHERETREE_VERSION"]
extensions = ["myst_parser", "sphinx.ext.autodoc"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
root_doc = "index"
myst_heading_anchors = 4
myst_all_links_external = False
suppress_warnings = ["misc.highlighting_failure", "myst.header"]
autodoc_member_order = "alphabetical"
html_theme = "furo"
html_title = f"spheretree {version}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
html_last_updated_fmt = None
html_use_index = True
html_theme_options = {"top_of_page_button": None}
smartquotes = False  # options begin with two hyphens
pygments_style = "friendly"
highlight_language = "text"


def as_lines(app, what, name, obj, options, lines):
    """The docstrings are plain text: their lines stay lines unless they are full, what is indented is a program, and no
    character but ` has a meaning."""
    out, before = [], ""
    for line in lines:
        parts = re.split(r"`([^`]*)`", line)
        parts[::2] = [re.sub(r"([\\*`_|])", r"\\\1", part) for part in parts[::2]]
        parts[1::2] = [f"``{part}``" for part in parts[1::2]]
        if line.startswith("    ") or not line.strip():
            out += [] if not line.strip() or before.startswith("    ") else ["", ".. code-block:: python", ""]
            out.append(line)
        elif before.strip() and len(before) + 1 + len(line.split()[0]) > 120:
            out[-1] += " " + "".join(parts)
        else:
            out += ([""] if before.startswith("    ") else []) + ["| " + "".join(parts)]
        before = line
    lines[:] = out + [""]


def setup(app):
    app.connect("autodoc-process-docstring", as_lines)
