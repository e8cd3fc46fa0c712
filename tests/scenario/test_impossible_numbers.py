"""Numbers that cannot exist are refused when a scenario is read, with file and key."""

from pathlib import Path

import pytest

from gyrostat.core.errors import InputError
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.spacecraft.environment import CircularOrbit
from gyrostat.spacecraft.orbit.elements import CircularElements, KeplerElements
from gyrostat.spacecraft.orbit.two_line_elements import TwoLineElements, checksum

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
FILES = ("zero_crossing.toml", "cubesat.toml", "cubesat_wheel.toml", "wheel_array.toml")
INERTIA = "inertia = [0.06, 0.12, 0.14]"


@pytest.mark.parametrize(
    ("file", "old", "new", "words"),
    [
        (
            "cubesat.toml",
            INERTIA,
            "inertia = [9e-6, 9e-6, 9e-6]",
            "the body is lighter than its own rotors",
        ),
        ("cubesat.toml", INERTIA, "inertia = [0.06, 0.12, 0.19]", "larger than the sum of"),
        ("cubesat.toml", INERTIA, "inertia = [0.0, 0.12, 0.14]", "expected above 0"),
        ("cubesat.toml", INERTIA, "inertia = [0.06, -0.12, 0.14]", "expected above 0"),
        (
            "zero_crossing.toml",
            'crossing_window = "20 s"',
            'crossing_window = "20 s"\n[[metrics.window]]\nname = "error_max"',
            r"metrics\.window\[error_max\]\.name: found the name of a metric",
        ),
        (
            "zero_crossing.toml",
            'crossing_window = "20 s"',
            'crossing_window = "20 s"\n[[metrics.window]]\nname = "error_p95"',
            r"metrics\.window\[error_p95\]\.name: found the name of a metric",
        ),
    ],
)
def test_impossible_numbers_are_refused_with_file(tmp_path, file, old, new, words):
    for name in FILES:
        text = (EXAMPLES / name).read_text()
        if name == file:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=words) as error:
        read_scenario(tmp_path / "zero_crossing.toml")
    assert str(error.value).startswith(f"{tmp_path / file}: ")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("inclination", [-1e-9, 3.15, 97.8, float("nan")])
def test_inclinations_outside_of_half_a_turn_are_refused(inclination):
    with pytest.raises(InputError, match="inclination"):
        CircularElements(5e5, inclination)
    with pytest.raises(InputError, match="inclination"):
        KeplerElements(7e6, inclination=inclination)
    with pytest.raises(InputError, match="inclination"):
        CircularOrbit(1e-3, inclination).check()


LINES = (
    "1 25544U 98067A   26320.51782528  .00002182  00000-0  11606-4 0  2927",
    "2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537",
)


def with_checksum(line):
    return line[:-1] + str(checksum(line))


@pytest.mark.parametrize(
    ("number", "columns", "text", "words"),
    [
        (1, (18, 32), "26320 51782528", "found the epoch .* without a blank inside"),
        (1, (53, 61), " 116 6-4", "the drag term"),
        (2, (8, 16), " 51 6416", "columns 9 to 16: found the inclination ' 51 6416'"),
        (2, (17, 25), "        ", "the right ascension of the node"),
        (2, (26, 33), "000 703", "the eccentricity"),
        (2, (52, 63), "15.7212 391", "the mean motion"),
        (2, (8, 16), " 51.64١6", "found '١', expected ASCII"),
    ],
)
def test_fields_of_elements_are_single_words_in_ascii(number, columns, text, words):
    lines = [*map(with_checksum, LINES)]
    TwoLineElements(*lines)
    line = lines[number - 1]
    line = line[: columns[0]] + text + line[columns[1] :]
    lines[number - 1] = with_checksum(line) if line.isascii() else line
    with pytest.raises(InputError, match=words):
        TwoLineElements(*lines)
