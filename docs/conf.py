"""Sphinx configuration: python -m sphinx -W --keep-going docs site."""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

project = "pathsim-jsbsim-blocks"
copyright = "pathsim-jsbsim-blocks contributors"
version = release = installed_version(project)

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "hooks",
]
nb_execution_mode = "off"  # docs/notebooks.py executes them

nb_ipywidgets_js = {}  # the notebooks have no widgets; their script comes from a network

html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_theme = "furo"
html_title = f"{project} {version}"
html_show_sphinx = False

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3

# the docstrings are reST, as PathView's dialogs want them, with sections for the ports
napoleon_google_docstring = False
napoleon_custom_sections = [("Inputs", "params_style"), ("Outputs", "params_style")]
napoleon_use_rtype = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"
add_module_names = False

copybutton_exclude = ".linenos, .gp, .go"
copybutton_prompt_text = r">>> |\.\.\. "
copybutton_prompt_is_regexp = True
