"""Scenarios of this package, each a folder with scenario.toml and the files that it names."""

from pathlib import Path

FOLDER = Path(__file__).parent


def names() -> list[str]:
    """Names of the scenarios."""
    return sorted(path.parent.name for path in FOLDER.glob("*/scenario.toml"))


def path_of(path: Path) -> Path:
    """Path of a scenario file: of one of this package if there is no file and it has that name.

    Args:
        path: Path of a file, or name of a scenario.
    """
    if path.exists() or str(path) not in names():
        return path
    return FOLDER / path / "scenario.toml"


def expected(path: Path) -> str:
    """What is expected at a path, for an error message."""
    if path.suffix:
        return "a scenario file"
    return f"a scenario file, or a scenario of this package: {', '.join(names())}"
