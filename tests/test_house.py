"""The rules of the house, as far as a machine can check them."""

import ast
import importlib
import importlib.metadata
import importlib.util
import inspect
import pkgutil
import re
import subprocess
import sys
import tomllib
from itertools import chain
from pathlib import Path

import pytest

import gyrostat

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src" / "gyrostat"
SOURCE_FILES = sorted(SOURCE.rglob("*.py"))
ROOMS = sorted(
    module.name for module in pkgutil.iter_modules(gyrostat.__path__) if module.name[0] != "_"
)
INNER = (
    "core.errors",
    "core.linear",
    "core.units",
    "wheel.friction",
    "control.guidance",
    "codegen.flight",
)
"""Modules below a room that users name too."""
MODULES = [*ROOMS, *INNER, "codegen.simd"]
LONGEST_FILE = 300  # lines

# A home or mount point of somebody's machine, and an address that packages are fetched from.
MACHINE_PATH = re.compile(r"(?<![\w.~-])/(?:home|root|work|mnt|Users|farm)/[\w.]")
PACKAGE_ADDRESS = re.compile(r"https?://\S*/(?:simple|packages)/|@ +file:|--(?:extra-)?index-url")


def tracked_files() -> list[Path]:
    """Every file that is, or by its name could be, committed."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    try:
        listed = subprocess.run(command, cwd=ROOT, capture_output=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("not a git checkout")
    paths = [ROOT / name for name in listed.stdout.decode().split("\0") if name]
    return [path for path in paths if path.is_file()]


def text_of(path: Path) -> str | None:
    """The file's text, or None where it is not text."""
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return None


def has_own_docstring(thing: object) -> bool:
    """Whether someone wrote a docstring for a class or function; dataclass writes a signature."""
    doc = (getattr(thing, "__doc__", None) or "").strip()
    return bool(doc) and not doc.startswith(f"{getattr(thing, '__name__', '')}(")


def undocumented(module) -> list[str]:
    """The module, and the public classes, functions and modules in it, that lack a docstring."""
    package = module.__name__.split(".")[0]
    missing = [] if has_own_docstring(module) else [module.__name__]
    for name in getattr(module, "__all__", ()):
        thing = getattr(module, name)
        # Aliases of types are callable too, but they come from typing or jaxtyping.
        ours = callable(thing) and str(getattr(thing, "__module__", "")).split(".")[0] == package
        if (ours or inspect.ismodule(thing)) and not has_own_docstring(thing):
            missing.append(f"{module.__name__}.{name}")
    return missing


def test_version_is_one_everywhere():
    assert gyrostat.__version__ == importlib.metadata.version("gyrostat")


def test_types_are_announced():
    assert (Path(gyrostat.__file__).parent / "py.typed").is_file()


def test_the_sources_are_what_is_tested():
    assert Path(gyrostat.__file__).resolve().parent == SOURCE
    assert SOURCE / "__init__.py" in SOURCE_FILES


@pytest.mark.parametrize("room", ROOMS)
def test_the_page_of_a_room_names_files_that_exist(room):
    page = (SOURCE / room / "README.md").read_text(encoding="utf-8")
    page = page.replace("PAPER/", "carrara_kuga/")
    named = re.findall(r"`([\w/.]+\.py)`", page)
    assert named, "it says where to start"
    above = (SOURCE / room, SOURCE, ROOT)
    assert [n for n in named if not any((folder / n).is_file() for folder in above)] == []
    assert len(page.splitlines()) <= 40, "one screen"


@pytest.mark.parametrize("name", ["", *MODULES])
def test_public_names_have_docstrings(name):
    module = importlib.import_module(f"gyrostat.{name}".rstrip("."))
    if hasattr(module, "__path__"):
        assert hasattr(module, "__all__"), f"{module.__name__} does not say what is public"
    assert undocumented(module) == []


def test_a_missing_docstring_is_seen():
    code = (
        "from dataclasses import dataclass\n"
        "__all__ = ['bare', 'Bare', 'Told', 'number']\n"
        "number = 1\n"
        "def bare(): ...\n"
        "@dataclass\nclass Bare:\n    x: int\n"
        "class Told:\n    'Says what it is.'\n"
    )
    module = type(sys)("example")
    sys.modules["example"] = module  # dataclass looks its module up
    try:
        exec(code, module.__dict__)
    finally:
        del sys.modules["example"]
    assert undocumented(module) == ["example", "example.bare", "example.Bare"]


def test_no_file_is_too_long():
    lengths = {
        str(path.relative_to(SOURCE)): len(path.read_text(encoding="utf-8").splitlines())
        for path in SOURCE_FILES
    }
    assert {path: length for path, length in lengths.items() if length > LONGEST_FILE} == {}


def imported_from_the_top(tree: ast.AST) -> set[str]:
    """What a module takes from `gyrostat` itself, past the import contract."""
    taken = {
        alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module == "gyrostat" and not node.level
        for alias in node.names
    }
    # modules, private ones and the version among them, are the contract's business
    return {name for name in taken if name[0] != "_" and name not in MODULES}


def test_no_module_goes_round_the_layers():
    taken = {
        str(path.relative_to(SOURCE)): imported_from_the_top(
            ast.parse(path.read_text(encoding="utf-8"))
        )
        for path in SOURCE_FILES
    }
    assert {path: names for path, names in taken.items() if names} == {}


def test_going_round_the_layers_is_seen():
    tree = ast.parse("from gyrostat import __version__, simulate_all\nfrom gyrostat.x import y")
    assert imported_from_the_top(tree) == {"simulate_all"}


def test_no_file_names_a_machine_or_an_address():
    found = []
    for path in tracked_files():
        for number, line in enumerate((text_of(path) or "").splitlines(), start=1):
            if MACHINE_PATH.search(line) or PACKAGE_ADDRESS.search(line):
                found.append(f"{path.relative_to(ROOT)}:{number}: {line.strip()[:80]}")
    assert found == []


@pytest.mark.parametrize("where", ["home", "root", "work", "Users"])
def test_a_machine_path_is_seen(where):
    assert MACHINE_PATH.search(f"see /{where}/someone/notes.txt")
    assert not MACHINE_PATH.search(f"see ../{where}/someone or https://example.org/{where}/x")


@pytest.mark.parametrize(
    "line", ["https://example.org/{}/numpy", "https://example.org/a/{}/numpy-2.whl"]
)
@pytest.mark.parametrize("folder", ["simple", "packages"])
def test_a_package_address_is_seen(line, folder):
    assert PACKAGE_ADDRESS.search(line.format(folder))
    assert not PACKAGE_ADDRESS.search(f"docs/{folder}/index.html")


def test_constraints_are_names_and_versions():
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pin = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*==[0-9][A-Za-z0-9.+!]*")
    assert lines
    assert [line for line in lines if not line.startswith("#") and not pin.fullmatch(line)] == []


def test_every_dependency_is_pinned():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"], *chain(*project["optional-dependencies"].values())]
    text = (ROOT / "constraints.txt").read_text(encoding="utf-8")

    def canonical(name):
        return re.sub(r"[-_.]+", "-", name).lower()

    pinned = {canonical(line.split("==")[0]) for line in text.splitlines()}
    named = {canonical(re.match(r"[\w.-]+", requirement)[0]) for requirement in wanted}
    assert named - pinned == set()


def loaded_by(module: str) -> set[str]:
    """The top-level modules in sys.modules after a fresh `import module`, or `import one, two`."""
    code = f"import sys, {module}; print(*{{name.split('.')[0] for name in sys.modules}})"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    return set(done.stdout.split())


@pytest.mark.parametrize("module", ["gyrostat", "gyrostat.cli", "gyrostat.campaigns"])
def test_import_is_light(module):
    if importlib.util.find_spec(module) is None:
        pytest.skip(f"there is no {module} yet")
    heavy = {"jax", "equinox", "scipy", "matplotlib", "pyarrow", "jinja2"}
    assert loaded_by(module) & heavy == set()


def test_a_scenario_and_a_report_import_no_more_than_they_need():
    heavy = {"scipy", "pandas", "xarray", "matplotlib", "pyarrow", "h5py"}
    assert loaded_by("gyrostat.campaigns.engine, gyrostat.reports.campaign") & heavy == set()


def test_the_pages_of_a_wheel_are_made_without_matplotlib():
    assert "matplotlib" not in loaded_by("gyrostat.reports.page")


def test_a_heavy_import_is_seen():
    assert "scipy" in loaded_by("scipy")
