"""Settings of the site of the documentation, which `make site` builds without the internet."""

from importlib.metadata import version as installed_version

project = "pianta"
author = "The pianta authors"
copyright = author
release = version = installed_version("pianta")

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx_copybutton",
    "sphinx_design",
]
templates_path = ["_templates"]
exclude_patterns = ["site"]
nitpicky = True
highlight_language = "none"

# Pages
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4

# Notebooks: run each time, from their own folder; a cell that fails stops the build.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 180
nb_execution_in_temp = True
nb_merge_streams = True

# The reference of the public names
autosummary_generate = True
autodoc_typehints_format = "short"
autodoc_default_options = {"member-order": "bysource"}
maximum_signature_line_length = 80
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False
# The documentation of other packages is not at hand without the internet, and internal names have no page.
nitpick_ignore_regex = [
    (r"py:.*", r"(?!pianta\.).*"),
    (r"py:.*", r"pianta\.(?!plot\.|errors\.)\w+\..*"),
]

# Looks: nothing comes from another server.
html_theme = "pydata_sphinx_theme"
html_title = "pianta"
html_static_path = ["_static"]
html_css_files = ["pianta.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "navbar_align": "left",
    "header_links_before_dropdown": 8,
    "show_prev_next": True,
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "navbar_end": ["theme-switcher"],
    "logo": {"text": "pianta"},
}
copybutton_exclude = ".linenos, .gp"
