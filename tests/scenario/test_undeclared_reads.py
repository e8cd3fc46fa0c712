"""What the Python of a user reads without declaring it is refused in one line, and named."""

import importlib.util
import os
import subprocess
import sys

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.user_modules import Source
from gyrostat.scenario.user.parts import user_part

SECTION = "environment.torque"
PART = """
class P:
    size: float = 1.0

    def __call__(self, spacecraft, attitude, time):
        return {value}
"""
READERS = {
    "open": ("", "open({file!r}).read()"),
    "Path.read_text": ("from pathlib import Path", "Path({file!r}).read_text()"),
    "os.open": ("import os", "os.close(os.open({file!r}, os.O_RDONLY))"),
    "io.open": ("from io import open as read", "read({file!r})"),
    "sqlite3": ("import sqlite3", "sqlite3.connect({file!r})"),
    "numpy.load": ("import numpy as np", "np.load({file!r}, allow_pickle=False)"),
    "numpy.loadtxt": ("import numpy as np", "np.loadtxt({file!r})"),
    "numpy.fromfile": ("import numpy as np", "np.fromfile({file!r}, np.uint8)"),
    "numpy.memmap": ("import numpy as np", "np.memmap({file!r}, np.uint8, 'r')"),
    "scipy.io.loadmat": ("import scipy.io", "scipy.io.loadmat({file!r})"),
    "scipy.io.netcdf_file": ("from scipy.io import netcdf_file", "netcdf_file({file!r})"),
    "pandas.read_csv": ("import pandas as pd", "pd.read_csv({file!r})"),
    "pandas.read_parquet": ("import pandas as pd", "pd.read_parquet({file!r})"),
    "h5py": ("import h5py", "h5py.File({file!r}, 'r')"),
    "h5netcdf": ("import h5netcdf", "h5netcdf.File({file!r}, 'r')"),
    "xarray": ("import xarray", "xarray.open_dataset({file!r}, engine='h5netcdf')"),
    "netCDF4": ("from netCDF4 import Dataset", "Dataset({file!r})"),
    "pyarrow.parquet.read_table": (
        "from pyarrow.parquet import read_table",
        "read_table({file!r})",
    ),
    "pyarrow.parquet.ParquetFile": (
        "from pyarrow.parquet import ParquetFile",
        "ParquetFile({file!r})",
    ),
    "pyarrow.csv": ("from pyarrow import csv", "csv.read_csv({file!r})"),
    "pyarrow.json": ("from pyarrow.json import read_json", "read_json({file!r})"),
    "pyarrow.dataset": ("import pyarrow.dataset as ds", "ds.dataset({file!r})"),
    "pyarrow.feather": ("from pyarrow import feather", "feather.read_table({file!r})"),
    "pyarrow.OSFile": ("import pyarrow as pa", "pa.OSFile({file!r}, 'rb')"),
    "pyarrow.memory_map": ("import pyarrow as pa", "pa.memory_map({file!r})"),
}
ENVIRONMENT = {
    "item": ("import os", "os.environ['GAIN_OF_TEST']"),
    "get": ("import os", "os.environ.get('GAIN_OF_TEST', 1.0)"),
    "getenv": ("from os import getenv", "getenv('GAIN_OF_TEST')"),
    "name imported before": ("from os import environ", "environ['GAIN_OF_TEST']"),
    "test": ("import os", "'GAIN_OF_TEST' in os.environ"),
    "expandvars": ("import os", "os.path.expandvars('$GAIN_OF_TEST')"),
    "bytes": ("import os", "os.environb[b'GAIN_OF_TEST']"),
}
HONEST = {
    "import of a package": "import xml.dom.minidom\nimport jinja2.sandbox",
    "import in a function": "import h5py\ndef late():\n    import scipy.io.matlab\nlate()",
    "package data of an installed package": "import scipy\nopen(scipy.__file__).close()",
    "file that is written": "import tempfile\nwith tempfile.TemporaryFile() as t: t.write(b'1')",
    "variable that is set": "import os\nos.environ.setdefault('OMP_OF_TEST', '1')",
    "array of JAX": "import jax.numpy as jnp\nA = jnp.linalg.inv(2.0 * jnp.eye(3))",
    "line of a warning": f"import linecache as c\nc.clearcache()\nc.getline({__file__!r}, 1)",
    "number of processors, by a library": "from pathlib import Path\nP = Path('/proc/self/cgroup')"
    "\nT = P.read_text() if P.exists() else ''",
    "own module": "import helper\nfrom helper import NUMBER\nimport parts.inner",
}


def refused(*texts, build=False):
    """Message of the refusal of a part."""
    sources = tuple(Source(path, text) for path, text in texts)
    made = user_part(SECTION, "own.py:P", sources) if build else None
    with pytest.raises(InputError) as caught:
        user_part(SECTION, "own.py:P", sources) if made is None else made.build({"size": 1.0})
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(f"{SECTION} own.py:P,")
    return message


@pytest.fixture(autouse=True)
def variable(monkeypatch):
    monkeypatch.setenv("GAIN_OF_TEST", "2.0")


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "weights.npz"
    path.write_bytes(b"1.0\n")
    return str(path)


@pytest.mark.parametrize(("head", "call"), READERS.values(), ids=READERS)
def test_a_reader_is_refused_with_the_line_and_the_file(head, call, file):
    package = head.split()[1].partition(".")[0] if head else "os"
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} is not installed")
    line = f"W = {call.format(file=file)}"
    message = refused(("own.py", f"{head}\n{line}\n" + PART.format(value="0.0")))
    assert f"own.py:P, line 2: found `{line[:80]}`, which reads {file}, " in message
    copy = "a copy beside the module, Path(__file__).parent / 'weights.npz', and "
    assert f'expected {copy}data = ["weights.npz"] beside python' in message


@pytest.mark.parametrize(("head", "call"), ENVIRONMENT.values(), ids=ENVIRONMENT)
def test_a_read_of_the_environment_is_refused(head, call):
    message = refused(("own.py", f"{head}\nW = {call}\n" + PART.format(value="0.0")))
    assert f"line 2: found `W = {call}`, which reads the environment variable GAIN_OF" in message
    assert "expected a value of the scenario: a field of the part" in message
    assert type(os.environ).__name__ == "_Environ"
    assert os.environ["GAIN_OF_TEST"] == "2.0"


@pytest.mark.parametrize("name", ["environ", "cmdline", "cwd/pyproject.toml"])
def test_what_the_system_says_of_the_process_is_no_way_around(name):
    line = f"W = Path('/proc/self/{name}').read_text()"
    text = f"from pathlib import Path\n{line}\n" + PART.format(value="0.0")
    assert f"which reads /proc/self/{name}, " in refused(("own.py", text))


def test_a_missing_file_is_named_with_the_remedy():
    line = 'W = open(Path(__file__).parent / "weights.npz")'
    text = f"from pathlib import Path\n{line}\n" + PART.format(value="0.0")
    assert 'reads weights.npz, expected data = ["weights.npz"]' in refused(("own.py", text))


def test_a_read_that_is_caught_is_refused_each_time(tmp_path):
    text = "try:\n    W = open('gains.txt')\nexcept Exception:\n    W = 1.0\n"
    for _ in range(2):
        message = refused(("own.py", text + PART.format(value="0.0")))
        assert "line 2: found `W = open('gains.txt')`, which reads gains.txt, exp" in message


def test_the_line_of_a_helper_is_named(file):
    helper = f"def weights():\n    return open({file!r})\n"
    text = "from helper import weights\nW = weights()\n" + PART.format(value="0.0")
    message = refused(("own.py", text), ("helper.py", helper))
    assert f"own.py:P, helper.py line 2: found `return open({file!r})`"[:90] in message


def test_a_read_while_the_part_is_constructed_is_refused(file):
    text = (
        "import dataclasses\n@dataclasses.dataclass(frozen=True)\nclass P:\n    size: float = 1.0\n"
        f"    def __post_init__(self):\n        open({file!r})\n"
        "    def __call__(self, spacecraft, attitude, time):\n        return 0.0\n"
    )
    assert f"line 6: found `open({file!r})`"[:60] in refused(("own.py", text), build=True)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("os.listdir({folder!r})", "which lists the folder {folder}, expected the names of its"),
        ("list(Path({folder!r}).glob('*'))", "which lists the folder {folder}, expected"),
        ("subprocess.run(['true'])", "which runs true, expected its result in a data file"),
        ("os.system('true')", "which runs true, expected its result in a data file"),
        ("import_module('loose_module')", "expected the statement import loose_module, which"),
        ("__import__('loose_module')", "expected the statement import loose_module, which"),
    ],
)
def test_other_reads_are_refused(line, expected, tmp_path, monkeypatch):
    (tmp_path / "loose_module.py").write_text("X = 1\n")
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    head = "import os, subprocess; from pathlib import Path; from importlib import import_module\n"
    line = line.format(folder=str(tmp_path))
    message = refused(("own.py", head + line + "\n" + PART.format(value="0.0")))
    sys.modules.pop("loose_module", None)
    assert expected.format(folder=tmp_path) in message


@pytest.mark.parametrize("head", HONEST.values(), ids=HONEST)
def test_what_is_no_read_of_the_user_is_accepted(head):
    sources = (
        Source("helper.py", "NUMBER = 1.0\n"),
        Source("own.py", f"{head}\n" + PART.format(value="0.0")),
        Source("parts/inner.py", ""),
    )
    assert user_part(SECTION, "own.py:P", sources).keys


FIRST = """
from gyrostat.core.user_modules import Source
from gyrostat.scenario.user.parts import user_part
text = "import jax.numpy as jnp\\nA = jnp.asarray([0.0, 1.0])\\n" + {part!r}
print(sorted(user_part({section!r}, "own.py:P", (Source("own.py", text),)).keys))
"""


def test_the_first_array_of_a_process_may_be_that_of_a_part():
    code = FIRST.format(part=PART.format(value="0.0"), section=SECTION)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout.startswith("["), done.stderr


def test_nothing_is_watched_afterwards(file):
    before = importlib.import_module, [*sys.meta_path]
    user_part(SECTION, "own.py:P", (Source("own.py", PART.format(value="open(self.size)")),))
    assert (importlib.import_module, [*sys.meta_path]) == before
    np.fromfile(file, np.uint8)
    namespace = {}
    exec(compile(f"X = open({file!r})", "gyrostat_own_0/own.py", "exec"), namespace)
    namespace["X"].close()


def test_a_fresh_process_watches_readers_that_a_part_imports_first(file):
    """A package that is imported while reads are watched is watched too."""
    text = f"import h5py\nW = h5py.File({file!r})\n" + PART.format(value="0.0")
    code = (
        "from gyrostat.core.user_modules import Source, load, package_of\n"
        "from gyrostat.core.user_errors import reported\n"
        f"sources = (Source('own.py', {text!r}),)\n"
        "with reported('part own.py:P', package_of(sources)):\n    load(sources, 'own.py:P')\n"
    )
    made = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "UserPartError: part own.py:P, line 2: found `W = h5py.File(" in made.stderr
