"""Pages of the programming interface: one for each room, and one for each public object.

`sphinx.ext.autosummary` writes them. This extension says which names are public, adds an example to
each, and keeps them out of the menu, which would otherwise repeat 450 names on every page.
"""

import importlib
import inspect
from collections import Counter
from pathlib import Path

from docutils import nodes
from sphinx import addnodes
from sphinx.pycode import ModuleAnalyzer
from usages import example

FOLDER = Path(__file__).parent / "api" / "generated"
ROOMS = (
    "telemetry",
    "wheel",
    "wheel.friction",
    "spacecraft",
    "spacecraft.orbit",
    "failures",
    "estimation",
    "control",
    "control.guidance",
    "identification",
    "simulation",
    "scenario",
    "scenario_files",
    "campaigns",
    "campaigns.pointing",
    "search",
    "exports",
    "codegen.simd",
    "codegen.flight",
    "core.rotations",
    "core.outputs",
    "core.units",
    "core.errors",
)
ELSEWHERE = {"campaigns": {"Dispersion", "Event", "Requirement", "Scenario", "Window"}}
"""Names that a room repeats from another."""
INNER = {
    "spacecraft.orbit": ["tables.orbit_environment"],
    "codegen.simd": ["batch.lanes", "batch.Lanes"],
}
"""Names of modules within a room that users need."""


def public_names(room: str) -> list[str]:
    """Public names of a room that have a docstring."""
    module = importlib.import_module(f"gyrostat.{room}")
    of_module = [
        name
        for name, thing in vars(module).items()
        if name[0] != "_" and getattr(thing, "__module__", None) == module.__name__
    ]
    commented = ModuleAnalyzer.for_module(module.__name__).find_attr_docs()
    documented = {name for scope, name in commented if not scope}
    for name in getattr(module, "__all__", of_module):
        thing = getattr(module, name)
        if (inspect.isclass(thing) or inspect.isroutine(thing)) and thing.__doc__:
            documented.add(name)
    names = getattr(module, "__all__", [*of_module, *sorted(documented)])
    kept = documented - ELSEWHERE.get(room, set())
    return [*dict.fromkeys(name for name in names if name in kept), *INNER.get(room, ())]


def pages() -> dict[str, list[str]]:
    """Full name of each room -> the names on its page."""
    return {f"gyrostat.{room}": public_names(room) for room in ROOMS}


def file_names(shown: dict[str, list[str]]) -> dict[str, str]:
    """File of a class whose name differs from that of a function by capitals alone."""
    full = [f"{room}.{name}" for room, names in shown.items() for name in names]
    count = Counter(name.lower() for name in full)
    return {
        name: f"{name}-class"
        for name in full
        if count[name.lower()] > 1 and name.rpartition(".")[2][0].isupper()
    }


def configure(app, config):
    """Give autosummary the names, and remove pages of names that are gone."""
    shown = pages()
    config.autosummary_context = {"shown": shown}
    config.autosummary_filename_map = file_names(shown)
    full = {f"{room}.{name}" for room, names in shown.items() for name in names}
    verbs = importlib.import_module("gyrostat").__all__
    expected = {*shown, *full, *config.autosummary_filename_map.values()}
    expected |= {f"gyrostat.{verb}" for verb in verbs}
    for path in FOLDER.glob("*.rst"):
        if path.stem not in expected:
            path.unlink()


def add_example(app, what, name, thing, options, lines):
    """Append an example to the docstring of a public object."""
    if what in {"class", "function", "exception"}:
        lines += ["", *example(thing, name.rpartition(".")[2])]


def without_rules(app, what, name, thing, options, signature, returned):
    """Leave types with rules out of the signature of a class; its fields are listed with them."""
    if what != "class" or not signature or "Annotated[" not in signature:
        return None
    fields = inspect.signature(thing).parameters.values()
    plain = [field.replace(annotation=inspect.Parameter.empty) for field in fields]
    return str(inspect.Signature(plain)), returned


def leave_out_of_the_menu(app, env):
    """Remove the objects from the menu; the tables of the rooms and the search lead to them."""
    for name in (name for name in env.tocs if name.startswith("api/")):
        for toctree in list(env.tocs[name].findall(addnodes.toctree)):
            toctree.parent.remove(toctree)
        for item in list(env.tocs[name].findall(nodes.bullet_list)):
            if not item.children:
                item.parent.remove(item)


def setup(app):
    """See the module."""
    app.connect("config-inited", configure)
    app.connect("autodoc-process-docstring", add_example, priority=900)  # after napoleon
    app.connect("autodoc-process-signature", without_rules)
    app.connect("env-updated", leave_out_of_the_menu)
    return {"parallel_read_safe": True}
