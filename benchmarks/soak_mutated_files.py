"""Mutated input files: each is read, or refused in one line.

    python benchmarks/soak_mutated_files.py                       5000 files, a few minutes
    python benchmarks/soak_mutated_files.py --only oem --seed 7    files of one kind, of other seeds

Scenario, spacecraft, data sheet, model, record, orbit table, OEM and two-line elements are changed
as hostile input is (bytes, lines, values of other types, truncation) or as slips are (digits,
factors, units), and read. Only reading is tested. Exit code 1 if an exception is not the refusal in
one line, or a file takes longer than 20 s.
"""

import argparse
import random
import re
import shutil
import signal
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

import gyrostat
from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import read_text
from gyrostat.scenario.unlikely import unlikely_numbers, unlikely_spacecraft
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.spacecraft import read_spacecraft
from gyrostat.spacecraft.orbit.orbit_file import OrbitFile
from gyrostat.spacecraft.orbit.time_scales import Epoch
from gyrostat.spacecraft.orbit.two_line_elements import TwoLineElements, checksum
from gyrostat.telemetry.read import read_record
from gyrostat.wheel import read_model
from gyrostat.wheel.data_sheet import read_wheel_sheet

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
SCENARIOS = EXAMPLES / "scenarios"
SHEETS = sorted(Path(gyrostat.__file__).parent.glob("wheel/data_sheets/*.toml"))
LONGEST = 20
"""Longest time that a file may take, s."""
MESSAGE = 1000
"""Largest length of a refusal."""
ELEMENTS = """\
1 25544U 98067A   19343.69339541  .00001764  00000-0  38792-4 0  9991
2 25544  51.6439 211.2001 0007417  17.6667  85.6398 15.50103472202482
"""
VALUES = (
    *("nan", "inf", "-inf", "-1", "0", "1e308", "1e-320", "1e999", "9" * 400, '""', '"5 rpm"'),
    *('"1 kg"', "true", "[]", "[[1]]", "{a=1}", "[1,[2]]", "1979-05-27", "07:32:00", '"٣"'),
    *('"½ deg"', "0x10", "1_0", '"nan deg"', '"1e400 s"', '"-"', '"%"', '"300 %"', '"1 deg/h"'),
    *("[1e308,1e308,1e308]", '"\\u0000"', '"x\\ny"', f'"{"x" * 5000}"'),
)
"""Values of TOML."""
TEXTS = (
    *("nan", "inf", "-1", "0", "1e308", "1e999", "9" * 400, "", "٣", "½", "\0", "1_000", "0x10"),
    *("1e-320", "2024-13-45T99:99:99", "é", "−1", "\t"),
)
"""Texts in place of a number."""
PIECES = ("rpm", "deg", "kg", "mN·m", "s", "km", "%", "[", "]]", "{", '"', "'", ",", "\n", "=", "#")
UNITS = (
    *("rpm", "rad/s", "deg", "rad", "kg", "g", "mN·m", "N·m", "µN·m", "s", "ms", "min", "km", "m"),
    *("mm", "deg/s", "Hz", "mN·m·s"),
)
FACTORS = (0.0, -1.0, 1e-30, 1e-6, 1e-3, 1 / 60, 0.1, 10.0, 60.0, 180 / np.pi, 1e3, 1e6, 1e25)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?", re.ASCII)
UNIT = re.compile(rf'(?<=\d )(?:{"|".join(map(re.escape, UNITS))})(?=")')


def hostile(draw, text):
    """Text with one to three changes of bytes, lines, values and length."""
    for _ in range(draw.choice((1, 1, 1, 2, 3))):
        lines, numbers = text.split("\n"), list(NUMBER.finditer(text))
        line, place = draw.randrange(len(lines)), draw.randrange(len(text) + 1)
        keys = [k for k, each in enumerate(lines) if "=" in each]
        kind = draw.choice(("byte", "drop", "repeat", "number", "number", "cut", "value", "piece"))
        if kind == "byte":
            text = text[:place] + chr(draw.randrange(0x2000)) + text[place + 1 :]
        elif kind == "number" and numbers:
            found = draw.choice(numbers)
            text = text[: found.start()] + draw.choice(TEXTS) + text[found.end() :]
        elif kind == "cut":
            text = text[:place]
        elif kind == "piece":
            text = text[:place] + draw.choice(PIECES) + text[place:]
        else:
            if kind == "drop":
                del lines[line]
            elif kind == "repeat":
                lines.insert(line, draw.choice(lines))
            elif keys:
                key = draw.choice(keys)
                lines[key] = f"{lines[key].partition('=')[0]}= {draw.choice(VALUES)}"
            text = "\n".join(lines)
    return text


def slip(draw, text):
    """Text with one to three other digits, factors or units."""
    for _ in range(draw.choice((1, 1, 2, 3))):
        numbers, units = list(NUMBER.finditer(text)), list(UNIT.finditer(text))
        if not numbers:
            return text
        found, kind = draw.choice(numbers), draw.choice(("digit", "unit", "factor"))
        if kind == "unit" and units:
            found = draw.choice(units)
            new = draw.choice(UNITS)
        elif kind == "digit":
            new = re.sub(r"\d", lambda _: draw.choice("0123456789"), found[0], count=1)
        else:
            new = f"{float(found[0]) * draw.choice(FACTORS):.17g}"
        text = text[: found.start()] + new + text[found.end() :]
    return text


def unchanged(draw, text):
    """The text itself."""
    return text


def orbit_rows():
    """Circular orbit: times, (N,), s; position, (N, 3), m; velocity, (N, 3), m/s."""
    time, radius, rate = 60.0 * np.arange(40), 6.878e6, 1.1068e-3
    angle, zero = rate * time, np.zeros(40)
    position = radius * np.stack([np.cos(angle), np.sin(angle), zero], axis=1)
    velocity = radius * rate * np.stack([-np.sin(angle), np.cos(angle), zero], axis=1)
    return time, position, velocity


def table():
    """Orbit as a CSV file."""
    rows = np.column_stack(orbit_rows())
    head = "time,x,y,z,vx,vy,vz"
    return "\n".join([head, *(",".join(map(repr, row)) for row in rows.tolist())])


def ephemeris():
    """Orbit as a CCSDS Orbit Ephemeris Message."""
    time, position, velocity = orbit_rows()
    rows = np.hstack([position, velocity]) / 1e3
    stamps = [f"2026-11-22T{int(t) // 3600:02d}:{int(t) // 60 % 60:02d}:00" for t in time]
    values = [" ".join(f"{value:.9f}" for value in row) for row in rows]
    lines = [f"{stamp} {value}" for stamp, value in zip(stamps, values, strict=True)]
    return (
        "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2026-11-22T00:00:00\nORIGINATOR = A\n\nMETA_START\n"
        "OBJECT_NAME = A\nCENTER_NAME = EARTH\nREF_FRAME = GCRF\nTIME_SYSTEM = UTC\n"
        f"START_TIME = {stamps[0]}\nMETA_STOP\n" + "\n".join(lines) + "\n"
    )


def read_orbit(path, kind, epoch=None):
    """Read an orbit and evaluate it."""
    orbit = kind.read(read_text(path, "an orbit", 50_000_000))
    orbit.trajectory(Epoch.of(epoch or orbit.epoch), 600.0)


def in_folder(choose):
    """Files of all ready scenarios in a folder, one of which is chosen."""

    def written(draw, folder):
        for path in (*SCENARIOS.iterdir(), EXAMPLES / "three_wheels.toml"):
            if path.is_file():
                shutil.copy(path, folder)
        return draw.choice([p for p in sorted(folder.glob("*.toml")) if choose(p)])

    return written


def single(name, text):
    """One file with a text; a function gives the text."""

    def written(draw, folder):
        path = folder / name
        path.write_text(text(draw) if callable(text) else text, encoding="utf-8")
        return path

    return written


def has(*words):
    """Whether the text of a file has the first words, and not the last one."""
    *needed, absent = words
    return lambda path: (
        all(w in path.read_text("utf-8") for w in needed) and absent not in path.read_text("utf-8")
    )


RECORD = "\n".join((EXAMPLES / "wheel_profile2.csv").read_text("utf-8").split("\n")[:120])
KINDS = {
    "scenario": (
        in_folder(has("[run]", "[spacecraft]", "python")),
        lambda path: unlikely_numbers(read_scenario(path)),
    ),
    "spacecraft": (
        in_folder(has("[body]", "[run]")),
        lambda path: unlikely_spacecraft(read_spacecraft(path)),
    ),
    "model": (in_folder(has("motor_constant", "[friction]", "[body]")), read_model),
    "sheet": (
        single("sheet.toml", lambda draw: draw.choice(SHEETS).read_text("utf-8")),
        read_wheel_sheet,
    ),
    "record": (single("record.csv", RECORD), read_record),
    "table": (
        single("orbit.csv", table()),
        lambda path: read_orbit(path, OrbitFile, "2026-11-22T00:00:00Z"),
    ),
    "oem": (single("orbit.oem", ephemeris()), lambda path: read_orbit(path, OrbitFile)),
    "elements": (single("sat.tle", ELEMENTS), lambda path: read_orbit(path, TwoLineElements)),
}
"""Kind -> how its file is written, and how it is read."""


class TooLongError(BaseException):
    """A file took longer than `LONGEST`."""


def interrupt(*_):
    """Signal handler."""
    raise TooLongError


def answer(kind, draw, change, folder):
    """What reading a changed file ends with: "read", "refused", or the fault."""
    write, read = KINDS[kind]
    path = write(draw, folder)
    text = change(draw, path.read_text("utf-8"))
    if kind == "elements" and draw.random() < 0.7:  # with the right checksum, reading goes on
        rows = text.split("\n")
        text = "\n".join(r[:68] + str(checksum(r)) if len(r) == 69 else r for r in rows)
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    signal.alarm(LONGEST)
    try:
        read(path)
    except InputError as error:
        lines = str(error).split("\n")
        is_short = len(lines) == 1 and len(lines[0]) <= MESSAGE
        return "refused" if is_short else f"refused in {len(lines)} lines, {lines[0][:200]}"
    except TooLongError:
        return f"not read in {LONGEST} s"
    except Exception as error:
        return f"{type(error).__name__}: {' '.join(str(error).split())[:200]}"
    finally:
        signal.alarm(0)
    return "read"


def soak(seed, count, kinds, say=lambda line: None):
    """Read mutated files: ends with their counts, and the faults with their numbers."""
    counts, faults = Counter(), []
    signal.signal(signal.SIGALRM, interrupt)
    for number in range(count):
        kind = kinds[number % len(kinds)]
        draw = random.Random(f"{seed}:{number}")
        # the first of each kind is as it was, and must be read
        change = draw.choice((hostile, slip)) if number >= len(kinds) else unchanged
        with tempfile.TemporaryDirectory() as folder:
            end = answer(kind, draw, change, Path(folder))
        if number < len(kinds) and end != "read":
            end = f"unchanged, {end}"
        counts[kind, end if end in ("read", "refused") else "fault"] += 1
        if end not in ("read", "refused"):
            faults.append(f"{kind} {number}: {end}")
            say(faults[-1])
        if (number + 1) % 500 == 0:
            say(f"{number + 1} files, {len(faults)} faults")
    return counts, faults


def main():
    """Read mutated files and print the counts."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=5000)
    parser.add_argument("--only", choices=KINDS, action="append")
    options = parser.parse_args()
    kinds = options.only or [*KINDS]
    counts, faults = soak(options.seed, options.count, kinds, lambda s: print(s, flush=True))
    for kind in kinds:
        print(kind, ", ".join(f"{end} {counts[kind, end]}" for end in ("read", "refused", "fault")))
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
