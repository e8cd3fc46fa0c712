"""Names of the modules of libraries: whether they still have the values of the library.

Other processes import a library anew, so that a value that was set in it from outside is not there.
A name is compared with what the text of its module says: where it is imported from, or which
constant it is. A name whose statement says neither, such as one that is computed, is trusted.
"""

import ast
import builtins
import importlib.util
import sys
from collections.abc import Iterator
from enum import Enum
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from gyrostat.core.local_modules import is_local
from gyrostat.scenario_files.python.definitions import statements

_COMPILED = ("math", "cmath")
"""Modules without a text of which a second copy can be made."""
_DYNAMIC = ("globals()", "setattr(", "sys.modules[", "vars(", "exec(", "locals()")
"""Texts by which a module sets names that none of its statements names."""
_OF_BUILTINS = ("builtins", "io", "_io", "_sitebuiltins")
_NOTHING: Any = object()


class _Binding(NamedTuple):
    """What a statement binds a name to.

    Attributes:
        module: Module that the value is imported from; "" if it is not imported.
        value: Name in that module, or constant; `_NOTHING` if it is computed.
    """

    module: str
    value: Any = _NOTHING


class _Text(NamedTuple):
    """Names that the text of a module binds.

    Attributes:
        bindings: Name -> its bindings.
        stars: Modules of which all names are imported.
        dynamic: Whether the text sets names that none of its statements names.
    """

    bindings: dict[str, list[_Binding]]
    stars: tuple[str, ...]
    dynamic: bool


def is_original(module: ModuleType, name: str) -> bool:
    """Whether a name of a library's module has the value that the library gives to it.

    Args:
        module: Module of a library.
        name: Name in it.
    """
    value = vars(module)[name]
    if name.startswith("__") or isinstance(value, ModuleType):
        return True
    if module.__name__ in _COMPILED:
        original = vars(_second_copy(module.__name__)).get(name, _NOTHING)
        return type(value) is type(original) and repr(value) == repr(original)
    text = _text(module.__name__, getattr(module, "__file__", None) or "")
    if text is None:
        return True
    bindings = text.bindings.get(name)
    if bindings is not None:
        return any(_gives(each, value) for each in bindings)
    if any(_imported_value(star, name) is value for star in text.stars):
        return True
    # names of enumerations are set by their classes, and those of classes by generators of classes
    if isinstance(value, Enum | type) or (text.dynamic and type(value) not in (float, complex)):
        return True
    lazy = vars(module).get("__getattr__")
    try:
        return lazy is not None and lazy(name) is value
    except Exception:
        return False


def is_original_builtin(name: str) -> bool:
    """Whether a built-in name has the value that Python gives to it."""
    value = getattr(builtins, name, None)
    original_name = getattr(value, "__name__", name)
    return getattr(value, "__module__", "builtins") in _OF_BUILTINS and (
        original_name == name or value is OSError
    )


def imported_names(text: str) -> Iterator[tuple[ModuleType, str]]:
    """Names that a text imports from modules of libraries, with these modules.

    Args:
        text: Python.
    """
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and not node.level:
            module = sys.modules.get(node.module or "")
            if module is not None and not is_local(module):
                yield from ((module, each.name) for each in node.names if each.name in vars(module))


@lru_cache(maxsize=8)
def _second_copy(name: str) -> ModuleType:
    spec: Any = importlib.util.find_spec(name)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _gives(binding: _Binding, value: Any) -> bool:
    if binding.module:
        original = _imported_value(binding.module, binding.value)
        home = sys.modules.get(binding.module)
        if original is _NOTHING or original is value:
            return True
        # the change can be in the module that the name was imported from
        if home is None or binding.value not in vars(home):
            return False
        return not is_original(home, binding.value)
    return binding.value is _NOTHING or repr(binding.value) == repr(value)


def _imported_value(module: str, name: str) -> Any:
    """Value of a name of an imported module; `_NOTHING` if it is not known."""
    submodule = sys.modules.get(f"{module}.{name}", _NOTHING)
    home = sys.modules.get(module)
    return submodule if home is None else vars(home).get(name, submodule)


@lru_cache(maxsize=256)
def _text(module: str, file: str) -> _Text | None:
    """Names that the text of a module binds; None if it has no text."""
    try:
        text = Path(file).read_text(encoding="utf-8") if file.endswith(".py") else ""
        tree = ast.parse(text)
    except (OSError, UnicodeDecodeError, SyntaxError, ValueError):
        return None
    if not text:
        return None
    package = module if Path(file).stem == "__init__" else module.rpartition(".")[0]
    bindings: dict[str, list[_Binding]] = {}
    stars = []
    for node in statements(tree.body):
        if isinstance(node, ast.ImportFrom):
            home = _absolute(package, node)
            stars += [home for alias in node.names if alias.name == "*"]
        for name, binding in _bindings(node, package):
            bindings.setdefault(name, []).append(binding)
    for node in ast.walk(tree):
        if isinstance(node, ast.Global):
            for name in node.names:
                bindings.setdefault(name, []).append(_Binding(""))
    return _Text(bindings, tuple(stars), any(each in text for each in _DYNAMIC))


def _absolute(package: str, node: ast.ImportFrom) -> str:
    """Name of the module that a statement imports from."""
    if not node.level:
        return node.module or ""
    parts = package.split(".")
    return ".".join((*parts[: len(parts) - node.level + 1], *filter(None, [node.module])))


def _bindings(node: ast.stmt, package: str) -> Iterator[tuple[str, _Binding]]:
    """Names that a statement binds, and to what."""
    if isinstance(node, ast.ImportFrom):
        for alias in node.names:
            yield alias.asname or alias.name, _Binding(_absolute(package, node), alias.name)
        return
    constant = _NOTHING
    if isinstance(node, ast.Assign | ast.AnnAssign) and isinstance(node.value, ast.Constant):
        constant = node.value.value
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        yield node.name, _Binding("")
    elif isinstance(node, ast.Import):
        for alias in node.names:
            yield alias.asname or alias.name.partition(".")[0], _Binding("")
    elif not isinstance(node, ast.If | ast.Try | ast.While):
        targets = node.targets if isinstance(node, ast.Assign) else [node]
        for target in targets:
            if isinstance(target, ast.AnnAssign):
                target = target.target
            if isinstance(target, ast.Name):
                yield target.id, _Binding("", constant)
                continue
            for inner in ast.walk(target):
                if isinstance(inner, ast.Name) and isinstance(inner.ctx, ast.Store):
                    yield inner.id, _Binding("")
