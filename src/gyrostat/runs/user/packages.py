"""Versions of the packages that user-defined parts import; they are part of a scenario.

The packages in the fingerprint of the engine, `gyrostat.runs.fingerprint`, are not among them,
nor is jaxtyping, whose annotations compute nothing.
"""

import ast
import dataclasses
import importlib.util
import sys
from collections.abc import Iterator
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, packages_distributions, version

from gyrostat.core.errors import InputError
from gyrostat.core.user_modules import module_name
from gyrostat.runs.fingerprint import PACKAGES
from gyrostat.scenario.scenario import Scenario, Source

_PLACE = "package."
"""Start of the places of versions in `Scenario.texts`."""
_WITHOUT = {*PACKAGES, "jaxtyping", "gyrostat"}


def with_packages(scenario: Scenario) -> Scenario:
    """Scenario with the present versions of the packages that its parts import."""
    other_texts = [text for text in scenario.texts if not text.path.startswith(_PLACE)]
    versions = [Source(_PLACE + name, _version(name)) for name in _import_names(scenario.sources)]
    texts = (*other_texts, *versions)
    return scenario if texts == scenario.texts else dataclasses.replace(scenario, texts=texts)


def other_packages(scenario: Scenario) -> list[str]:
    """Packages of which this process has other versions than a scenario, each as a text."""
    versions = [text for text in scenario.texts if text.path.startswith(_PLACE)]
    pairs = [(text.path.removeprefix(_PLACE), text.text) for text in versions]
    return [
        f"{name} {_version(name)}, expected {expected}"
        for name, expected in pairs
        if _version(name) != expected
    ]


def refuse_other_packages(scenario: Scenario, where: str = "this process") -> None:
    """Check that this process has the packages of a scenario.

    Args:
        scenario: Scenario.
        where: Start of the error message.

    Raises:
        InputError: A version differs, so that results could differ from those of other processes.
    """
    for package in other_packages(scenario):
        raise InputError(f"{where}: found {package}, with which the scenario was read")


def _import_names(sources: tuple[Source, ...]) -> list[str]:
    """Names of the packages that modules import, also inside functions."""
    modules = [source for source in sources if source.is_module]
    local = {module_name(source.path).partition(".")[0] for source in modules}
    names = {name for source in modules for name in _names(source.text)}
    return sorted(names - local - _WITHOUT - sys.stdlib_module_names)


@lru_cache(maxsize=256)
def _names(text: str) -> frozenset[str]:
    def names() -> Iterator[str]:
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Import):
                yield from (alias.name for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                yield node.module

    return frozenset(name.partition(".")[0] for name in names())


@lru_cache(maxsize=256)
def _version(name: str) -> str:
    """Version of a package by the name of its module; "none" if there is none."""
    try:
        return version(name)
    except PackageNotFoundError:
        if importlib.util.find_spec(name) is None:
            return "none"
    owners = sorted(set(packages_distributions().get(name, ())))
    return ", ".join(f"{owner} {version(owner)}" for owner in owners) or "unknown"
