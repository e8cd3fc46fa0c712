"""Reaction wheels in spacecraft attitude control: identification, estimation, control, simulation.

`import gyrostat as gs` is all that a user needs: the verbs of the command line as functions, and
the parts that a simulation is made of. A name is loaded when it is first used. The rooms, such as
`gyrostat.control`, have further parts.

Inside the package every quantity is in SI units and radians, in float64.
"""

__version__ = "0.1.0"


def _homes() -> dict[str, str]:
    """Public names and their modules, as `__init__.pyi` tells them to type checkers."""
    stub = __loader__.get_data(f"{__file__}i").decode()
    lines = [line.split() for line in stub.splitlines() if line.startswith("from ")]
    return {name: module for _, module, _, name, *_ in lines}


_HOMES = _homes()
__all__ = ["__version__", *_HOMES]  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> object:
    """Load a public name at its first use."""
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value = getattr(import_module(_HOMES[name]), name)
    return value


def __dir__() -> list[str]:
    """Public names and what is loaded."""
    return sorted({*globals(), *__all__})
