"""Data files of user-defined parts: their content is part of the scenario, wherever it runs."""

import json
import os
import re
import shutil
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.campaigns import Store
from gyrostat.codegen.simd import compiler
from gyrostat.core.errors import InputError
from gyrostat.core.user_data import LARGEST_DATA
from gyrostat.core.user_modules import Source, folder_of, package_of
from gyrostat.runs.user import packages
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.user.parts import user_part

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
SCENARIO = """
[run]
duration = "4 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[start]
attitude_error = ["2 deg", 0.0, "-1 deg"]
[controller]
python = "mission.py:PD"
data = ["weights.npz", "tables/rate.csv"]
[[dispersion]]
key = "controller.scale"
distribution = "normal"
sigma = "10 %"
"""
HEAD = """
from pathlib import Path
from typing import Any, NamedTuple
import equinox as eqx
import jax.numpy as jnp
import numpy as np
from gyrostat.control import PseudoInverse

class Command(NamedTuple):
    torque: Any

"""
PD = """
class PD(eqx.Module):
    scale: float = 1.0
    spacecraft: Any = None

    def start(self, period):
        return ()

    def __call__(self, memory, measurement):
        {read}
        error = 2.0 * measurement.attitude[1:] * jnp.sign(measurement.attitude[0])
        torque = self.scale * (KP * error + kd * measurement.rate)
        wheels = self.spacecraft.wheels
        share = PseudoInverse()(
            wheels.axes, wheels.torque_limit, jnp.ones(wheels.count, bool), torque
        )
        return memory, Command(share)
"""
FILES = (
    'KP = np.load(Path(__file__).parent / "weights.npz")["kp"]\n',
    'kd = np.loadtxt("tables/rate.csv", delimiter=",")',
)
NUMBERS = "KP = np.array([0.004, 0.005, 0.006])\n", "kd = np.array([0.03, 0.04, 0.05])"


def written(folder, constant, line):
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, folder / name)
    (folder / "tables").mkdir(exist_ok=True)
    np.savez(folder / "weights.npz", kp=np.array([0.004, 0.005, 0.006]))
    (folder / "tables" / "rate.csv").write_text("0.03,0.04,0.05\n")
    (folder / "mission.py").write_text(HEAD + constant + PD.format(read=line))
    (folder / "mission.toml").write_text(SCENARIO)
    return folder / "mission.toml"


@pytest.fixture(scope="module")
def mission(tmp_path_factory):
    """A campaign of a controller that reads two files, whose folder is removed afterwards."""
    folder = tmp_path_factory.mktemp("mission")
    path = written(folder / "source", *FILES)
    scenario = gs.read_scenario(path)
    gs.campaign(scenario, 2, folder / "runs", seed=1, worst=0)
    shutil.rmtree(folder / "source")
    return scenario, folder / "runs"


def table(folder):
    return (folder / "runs.parquet").read_bytes()


def same_tables(*folders):
    found, expected = (Store(folder).read_table() for folder in folders)
    assert found.column_names == expected.column_names
    for name in found.column_names:  # some metrics are NaN
        np.testing.assert_array_equal(found[name].to_numpy(), expected[name].to_numpy(), name)


def test_the_files_are_in_the_scenario_by_their_content(mission):
    scenario, _ = mission
    assert [source.path for source in scenario.sources] == [
        *("mission.py", "tables/rate.csv", "weights.npz")
    ]
    assert scenario.sources[1] == Source("tables/rate.csv", "0.03,0.04,0.05\n")
    assert scenario.sources[2].content.startswith(b"PK")
    again = Scenario.from_text(scenario.text())
    assert again.sources == scenario.sources
    assert again.digest() == scenario.digest()


def test_runs_are_those_of_the_same_numbers_in_the_module(mission, tmp_path):
    scenario = gs.read_scenario(written(tmp_path / "source", *NUMBERS))
    gs.campaign(scenario, 2, tmp_path / "runs", seed=1, worst=0)
    same_tables(mission[1], tmp_path / "runs")


def test_a_worker_gives_the_same_table_without_the_folder(mission, tmp_path):
    gs.campaign(mission[0], 2, tmp_path / "runs", seed=1, worst=0, workers=1)
    assert table(tmp_path / "runs") == table(mission[1])


def test_a_fresh_process_replays_a_run_without_the_folder(mission, tmp_path):
    shutil.copytree(mission[1], tmp_path / "runs")
    code = "import sys, gyrostat as gs; gs.replay(sys.argv[1], 1)"
    subprocess.run([sys.executable, "-c", code, tmp_path / "runs"], check=True, cwd=tmp_path)
    assert (tmp_path / "runs" / "runs" / "run_000001.nc").exists()


def test_a_changed_file_is_another_campaign(mission, tmp_path):
    path = written(tmp_path / "source", *FILES)
    np.savez(tmp_path / "source" / "weights.npz", kp=np.array([0.004, 0.005, 0.007]))
    scenario = gs.read_scenario(path)
    assert scenario.digest() != mission[0].digest()
    with pytest.raises(InputError, match="found a campaign with another scenario"):
        gs.campaign(scenario, 2, mission[1], seed=1, worst=0)


@pytest.mark.skipif(not compiler(), reason="found no C compiler")
def test_a_search_flies_the_numbers_of_the_files(mission, tmp_path):
    pytest.importorskip("cma", reason="the library of the extra search is not installed")
    numbers = gs.read_scenario(written(tmp_path / "source", *NUMBERS))
    for name, scenario in (("files", mission[0]), ("numbers", numbers)):
        gs.campaign(scenario, 642, tmp_path / name, worst_case="error_rms", worst=0)
    report = json.loads((tmp_path / "files" / "report.json").read_text())
    assert report["values"][0]["at"] == "lower bound"
    same_tables(tmp_path / "files", tmp_path / "numbers")


def test_flight_code_contains_the_numbers(mission, tmp_path):
    gs.export(mission[0], tmp_path / "files", to="c", command="test")
    numbers = gs.read_scenario(written(tmp_path / "source", *NUMBERS))
    gs.export(numbers, tmp_path / "numbers", to="c", command="test")
    names = sorted(path.name for path in (tmp_path / "files").glob("*.[ch]"))
    assert names
    for name in names:
        files, numbers = (
            # the scenarios are two
            re.sub("scenario: SHA-256 [0-9a-f]{64}", "", (tmp_path / folder / name).read_text())
            for folder in ("files", "numbers")
        )
        assert files == numbers


def part(head, body, name="P"):
    """Text of a module with an environment torque."""
    return (
        f"from pathlib import Path\nimport numpy as np\n{head}\nclass {name}:\n"
        f"    {body}\n    size: float = 1.0\n\n"
        "    def __call__(self, spacecraft, attitude, time):\n"
        "        return self.size * W * np.ones(3)\n"
    )


BESIDE = 'W = np.loadtxt(Path(__file__).parent / "w.csv")'
ELSEWHERE = """
[run]
duration = "1 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[controller]
kind = "three_axis"
[[environment.torque]]
python = "own.py:P"
"""


@pytest.fixture
def torque_scenario(tmp_path):
    """Reads a scenario with an environment torque; its constant W is in a file w.csv."""
    written(tmp_path, *FILES)
    (tmp_path / "w.csv").write_text("1e-7")
    (tmp_path / "own.py").write_text(part(BESIDE, "pass"))

    def read(line="", text=ELSEWHERE):
        (tmp_path / "own.toml").write_text(f"{text}{line}\n")
        return gs.read_scenario(tmp_path / "own.toml")

    return read


def torque(scenario, kind="own.py:P"):
    made = user_part("environment.torque", kind, scenario.sources).build({"size": 1.0})
    return made(None, None, 0.0)[0]


def test_an_edited_file_is_noticed_in_the_same_process(torque_scenario, tmp_path):
    data = torque_scenario('data = ["w.csv"]')
    assert torque(data) == 1e-7
    (tmp_path / "w.csv").write_text("2e-7")
    other = torque_scenario('data = ["w.csv"]')
    assert (torque(other), torque(data)) == (2e-7, 1e-7)
    (tmp_path / "own.py").write_text(part(BESIDE, "pass").replace("self.size *", "2.0 *"))
    third = torque_scenario('data = ["w.csv"]')
    assert (torque(third), torque(other)) == (4e-7, 2e-7)
    assert len({each.digest() for each in (data, other, third)}) == 3


def test_data_do_not_take_the_place_of_modules(torque_scenario, tmp_path):
    shutil.copy(tmp_path / "weights.npz", tmp_path / "numpy.npz")
    (tmp_path / "helper.txt").write_text("raise ValueError")
    (tmp_path / "helper.py").write_text("FACTOR = 3.0\n")
    head = f"from helper import FACTOR\n{BESIDE} * FACTOR"
    (tmp_path / "own.py").write_text(part(head, "pass"))
    assert torque(torque_scenario('data = ["w.csv", "numpy.npz", "helper.txt"]')) == pytest.approx(
        3e-7
    )


def test_a_private_copy_that_was_changed_is_refused(torque_scenario, tmp_path):
    scenario = torque_scenario('data = ["w.csv"]')
    folder, names = folder_of(package_of(scenario.sources))
    assert names == ("w.csv",)
    assert (folder / "w.csv").stat().st_mode & 0o777 == 0o400
    (folder / "w.csv").chmod(0o600)
    (folder / "w.csv").write_text("3e-7")
    with pytest.raises(InputError, match=r"w\.csv: found a private copy .* that was changed"):
        user_part("environment.torque", "own.py:P", (*scenario.sources, Source("x.py", "")))
    (folder / "w.csv").unlink()
    assert torque(scenario) == 1e-7


REFUSED = {
    "none": ("[]", 'data: found an empty list, expected paths, such as ["weights.npz"]'),
    "no list": ('"w.csv"', "data: found 'w.csv', expected paths"),
    "number": ("[1]", "data[0]: found 1, expected the path of a file"),
    "empty text": ('[""]', "data[0]: found '', expected the path of a file"),
    "missing": (
        '["no.csv"]',
        "data[0]: {folder}/no.csv: found no such file or directory, expected",
    ),
    "folder": ('["tables"]', "data[0]: {folder}/tables: found a folder, expected a data file"),
    "above": ('["../w.csv"]', "data[0]: found ../w.csv, expected a file below the folder {folder}"),
    "absolute": ('["/etc/hosts"]', "data[0]: found /etc/hosts, expected a file below the folder"),
    "link": ('["link.csv"]', "data[0]: found link.csv, expected a file below the folder"),
    "twice": ('["w.csv", "./w.csv"]', "data[1]: found ./w.csv twice, expected each file once"),
    "module": ('["own.py"]', "data[0]: found the Python file own.py, expected a data file: mod"),
    "large": ('["large.bin"]', "data[0]: {folder}/large.bin: found more than 1e+07 bytes, exp"),
}


@pytest.mark.parametrize(("value", "expected"), REFUSED.values(), ids=REFUSED)
def test_a_wrong_list_gives_one_line(torque_scenario, tmp_path, value, expected):
    with (tmp_path / "large.bin").open("wb") as stream:
        stream.truncate(LARGEST_DATA + 1)
    (tmp_path / "link.csv").symlink_to("/etc/hosts")
    with pytest.raises(InputError) as caught:
        torque_scenario(f"data = {value}")
    message = str(caught.value)
    assert message.startswith(f"{tmp_path}/own.toml: key environment.torque[0].data")
    assert expected.format(folder=tmp_path) in message
    assert "\n" not in message


def test_data_beside_a_kind_are_refused(torque_scenario):
    text = ELSEWHERE.replace('kind = "three_axis"', 'kind = "three_axis"\ndata = ["w.csv"]')
    with pytest.raises(InputError, match="found an unknown key"):
        torque_scenario('data = ["w.csv"]', text)


def test_an_undeclared_read_is_refused_by_the_command_line(torque_scenario, run, tmp_path):
    line = "W = np.fromfile('w.csv')"
    (tmp_path / "own.py").write_text(part(line, "pass"))
    with pytest.raises(InputError):
        torque_scenario()
    code, out, err = run("simulate", tmp_path / "own.toml", "--out", tmp_path / "run.nc")
    assert (code, out) == (2, "")
    assert err == (
        f"error: {tmp_path}/own.toml: environment.torque own.py:P, line 3: found `{line}`, which "
        'reads w.csv, expected data = ["w.csv"] beside python, or in the body of the class: the '
        "file is part of the scenario\n"
    )
    assert not (tmp_path / "run.nc").exists()


def test_a_reader_that_looks_for_its_file_first_names_the_remedy(torque_scenario):
    """numpy.loadtxt asks whether the file exists, which cannot be seen."""
    with pytest.raises(InputError, match=r"line 3: found FileNotFoundError \(w.csv not") as caught:
        torque_scenario()
    expected = 'expected a file of the scenario: data = ["FILE", ...] beside python'
    assert str(caught.value).endswith(expected)


def test_a_class_declares_its_data_beside_its_module(torque_scenario, tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "own.py").write_text(part(BESIDE, 'data = ("w.csv",)'))
    (tmp_path / "parts" / "w.csv").write_text("5e-7")
    scenario = torque_scenario(text=ELSEWHERE.replace("own.py:P", "parts/own.py:P"))
    assert [source.path for source in scenario.sources] == ["parts/own.py", "parts/w.csv"]
    assert torque(scenario, "parts/own.py:P") == 5e-7


def test_objects_bring_the_data_of_their_class(torque_scenario, tmp_path, monkeypatch):
    plain = torque_scenario('data = ["w.csv"]')
    (tmp_path / "live_data_part.py").write_text(part(BESIDE, 'data = ("w.csv",)'))
    monkeypatch.syspath_prepend(str(tmp_path))
    import live_data_part  # pyright: ignore[reportMissingImports]

    found = plain.replace(environment=(live_data_part.P(),))
    assert torque(found, "live_data_part.py:P") == 1e-7
    (tmp_path / "w.csv").write_text("2e-7")
    with pytest.raises(InputError, match=r"found W: an array .* in memory, other numbers from"):
        plain.replace(environment=(live_data_part.P(),))


def test_a_class_of_a_notebook_brings_its_data(torque_scenario, tmp_path, monkeypatch):
    plain = torque_scenario('data = ["w.csv"]')
    monkeypatch.chdir(tmp_path)
    module = ModuleType("__main__")
    monkeypatch.setitem(sys.modules, "__main__", module)
    text = part('W = np.loadtxt("w.csv")', 'data = ["w.csv"]')
    module.In = [text]
    exec(text, vars(module))
    found = plain.replace(environment=(module.P(),))
    assert torque(found, "notebook_P.py:P") == 1e-7
    assert os.getcwd() == str(tmp_path)


def test_versions_of_imported_packages_are_in_the_digest(torque_scenario, tmp_path, monkeypatch):
    plain = torque_scenario('data = ["w.csv"]')
    assert plain.texts == ()  # the fingerprint of the engine has the version of NumPy
    (tmp_path / "own.py").write_text(part(f"import jinja2\n{BESIDE}", "pass"))
    found = torque_scenario('data = ["w.csv"]')
    assert found.texts == (Source("package.jinja2", version("jinja2")),)
    assert packages.other_packages(found) == []
    monkeypatch.setattr(packages, "_version", lambda name: "0.1")
    assert packages.other_packages(found) == [f"jinja2 0.1, expected {version('jinja2')}"]
    assert torque_scenario('data = ["w.csv"]').digest() != found.digest()
    assert found.replace(environment="constant").digest() != found.digest()
    with pytest.raises(InputError, match=r"this process: found jinja2 0\.1, expected"):
        packages.refuse_other_packages(found)
    assert found.replace(environment=()).texts == ()
