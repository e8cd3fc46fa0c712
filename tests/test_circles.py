"""No circle of imports between the files of the package."""

import ast
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

import gyrostat

SOURCE = Path(gyrostat.__file__).parent


def imports(tree: ast.AST) -> Iterator[ast.Import | ast.ImportFrom]:
    """Imports of a file, also those inside functions and those for type checkers alone."""
    return (node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom))


def imported_by(name: str, text: str, files: Mapping[str, str]) -> set[str]:
    """Files that a file imports.

    An import of a file below a package also runs the package's `__init__.py`; this is not counted:
    it has no names that the file could need.

    Args:
        name: Name of the file as a module; that of a package ends with `.__init__`.
        text: Its text.
        files: Name of a file as a module -> its text.
    """
    found = set()
    for node in imports(ast.parse(text)):
        if isinstance(node, ast.Import):
            named = [alias.name for alias in node.names]
        else:
            above = name.split(".")[: -node.level] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            inner = [f"{base}.{alias.name}" for alias in node.names]
            named = [each if files.keys() & {each, f"{each}.__init__"} else base for each in inner]
        found |= {file for each in named for file in (each, f"{each}.__init__") if file in files}
    return found - {name}


def circles(files: Mapping[str, str]) -> list[list[str]]:
    """Groups of files of which each imports each other, directly or through others."""
    uses = {name: imported_by(name, text, files) for name, text in files.items()}
    reach: dict[str, set[str]] = {}
    for name in uses:
        reach[name], ahead = set(), [name]
        while ahead:
            new = uses[ahead.pop()] - reach[name]
            reach[name] |= new
            ahead += new
    groups = {tuple(sorted(o for o in reach[n] if n in reach[o])) for n in uses if n in reach[n]}
    return sorted(map(list, groups))


def read_package() -> dict[str, str]:
    """Name of each file of the package as a module -> its text."""
    paths = sorted(SOURCE.rglob("*.py"))
    names = [".".join(path.relative_to(SOURCE.parent).with_suffix("").parts) for path in paths]
    return {n: path.read_text(encoding="utf-8") for n, path in zip(names, paths, strict=True)}


def test_no_circle_of_files():
    files = read_package()
    assert len(files) > 300
    assert circles(files) == []


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("from gyrostat.b import f", "from gyrostat.a import g"),
        ("import gyrostat.b as b", "from gyrostat import a"),
        ("from . import b", "def f():\n    from .a import g"),
        ("import gyrostat.b", "if TYPE_CHECKING:\n    from gyrostat.a import A"),
    ],
)
def test_circle_is_found(first, second):
    files = {"gyrostat.__init__": "", "gyrostat.a": first, "gyrostat.b": second, "gyrostat.c": ""}
    files["gyrostat.d"] = "import gyrostat.a"
    assert circles(files) == [["gyrostat.a", "gyrostat.b"]]
    assert circles({**files, "gyrostat.b": "import gyrostat.c"}) == []
