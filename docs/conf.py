"""Builds the pages: `make docs`. Warnings are errors."""

import os
from pathlib import Path
import sys

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
sys.path[:0] = [str(ROOT), str(HERE / '_ext')]
os.environ['PYTHONPATH'] = str(ROOT)  # notebooks import studies

import commands  # noqa: E402
import effects  # noqa: E402
import interfaces  # noqa: E402
import parameters  # noqa: E402
import states  # noqa: E402

project = 'billiard_shot'
author = 'billiard_shot maintainers'
project_copyright = author

extensions = ['myst_nb', 'sphinx.ext.autodoc', 'docstrings', 'live', 'mathml']
exclude_patterns = ['_build']
default_role = 'code'

html_theme = 'furo'
html_title = 'billiard_shot'
html_show_sphinx = False
html_static_path = ['_static']
html_css_files = ['wide.css']
html_math_renderer = 'mathml'

myst_enable_extensions = ['dollarmath']
myst_heading_anchors = 3

# Notebooks are stored without outputs. Their tables to play on are frames, which need no kernel.
nb_execution_mode = 'force'
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_mime_priority_overrides = [('html', 'application/vnd.jupyter.widget-view+json', None)]
nb_ipywidgets_js = {}
nb_merge_streams = True

autodoc_member_order = 'bysource'
autodoc_typehints = 'none'  # the docstrings say types, shapes and units

# What the code says about interfaces, parameters, commands and the like becomes pages, every time.
REFERENCE = HERE / 'reference'
REFERENCE.mkdir(exist_ok=True)
for name, text in (
    ('interfaces', interfaces.page(ROOT / 'msg_defs')),
    ('parameters', parameters.page(ROOT)),
    ('commands', commands.page()),
    ('effects', effects.page()),
    ('states', states.page()),
):
    file = REFERENCE / f'{name}.md'
    if not file.exists() or file.read_text() != text:
        file.write_text(text)
