"""The documentation: MyST pages whose examples run while it is built, and nothing fetched."""

import os
import shutil
import sys
from pathlib import Path

from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml

import gyrostat
from gyrostat.codegen.flight.measure import compiler

# The examples run in kernels that inherit these.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
os.environ.setdefault("JAX_PLATFORMS", "cpu")
os.environ["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"
sys.path.insert(0, str(Path(__file__).parent))  # the extensions of this folder

project = "gyrostat"
author = "the gyrostat authors"
copyright = "the gyrostat authors, Apache-2.0"
release = version = gyrostat.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "accessible_pages",
    "api_pages",
    "version_switcher",
]
templates_path = ["_templates"]
exclude_patterns = ["_build", "_templates", "**/.ipynb_checkpoints"]

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence"]
myst_heading_anchors = 3

# Every example runs at every build, and one that fails, fails the build.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_merge_streams = True
if compiler() is None:
    print("docs/flight_code.md is not executed: no C compiler")
    nb_execution_excludepatterns = ["flight_code.md"]

napoleon_use_ivar = True  # fields listed under "Attributes:" are documented once
autodoc_default_options = {
    "members": True,
    "imported-members": True,  # a package's public names live in its modules
    "show-inheritance": True,
}
autodoc_member_order = "groupwise"
autodoc_typehints_format = "short"

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["equations.css", "pages.css"]
html_title = f"gyrostat {release}"

html_math_renderer = "mathml"


def _inline(translator, node):
    translator.body.append(tex2mathml(node.astext()))
    raise SkipNode


def _block(translator, node):
    translator.body.append(f"<div>{tex2mathml(node.astext(), as_block=True)}</div>")
    raise SkipNode


def _absolute(app, what, name, thing, options, lines):
    """Take |x| in a docstring as an absolute value, not as a substitution."""
    lines[:] = [line if "`" in line else line.replace("|", r"\|") for line in lines]


def _notebook(app, page, template, context, doctree):
    """Offer a page with code as the notebook that was executed for it."""
    executed = Path(app.outdir).parent / "jupyter_execute" / f"{page}.ipynb"
    if "kernelspec" in app.env.metadata.get(page, {}) and executed.is_file():
        shown = Path(app.outdir) / "_notebooks" / f"{page}.ipynb"
        shown.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(executed, shown)
        address = context["pathto"](f"_notebooks/{page}.ipynb", 1)
        link = f'<a href="{address}" download>This page as a notebook</a>'
        context["body"] += f"<p>{link}, for the folder <code>docs</code> of the repository.</p>"


def setup(app):
    """Write equations as MathML, which browsers show without a script and without a network."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    app.connect("autodoc-process-docstring", _absolute)
    app.connect("html-page-context", _notebook)
