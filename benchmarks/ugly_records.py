"""Fifty-four ugly records: each ends in the right wheel, or in one line that names the true cause.

    python benchmarks/ugly_records.py [--only NAME] [--seed 70000]

One wheel of known truth (`bench_wheels.py`, 150 s of profile 2 at 10 Hz, 2 rpm noise), spoiled in
fifty-four ways, written as a file and read with `identify --model auto`. Right: motor constant and
Coulomb torque within 4 sigma and 5 % of the truth. Named: a note, a warning or the error contains
the words that say what is wrong.
"""

import argparse
import tempfile
import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from bench_wheels import INERTIA, NOISE_ONLY, STRIBECK_SPEED, Effects, records

from gyrostat.core.errors import InputError
from gyrostat.core.units import RPM
from gyrostat.identification import identify
from gyrostat.telemetry import Record, cut, read_record, record_of_edges

SIGMA = 2.0 * RPM
BASE = replace(NOISE_ONLY, speed_sigma=SIGMA)
HEADER = "time_s,current_A,speed_rad/s"


@dataclass(frozen=True)
class Case:
    """One ugly record.

    Attributes:
        name: Of the case.
        text: File content from a record.
        named: Words of which one must be said; none: the wheel must be right.
        effects: Of the wheel and its sensors.
        options: Of `read_record`.
    """

    name: str
    text: Callable[[Record], str]
    named: tuple[str, ...] = ()
    effects: Effects = BASE
    options: dict = field(default_factory=dict)


def rows(record: Record, header: str = HEADER, sep: str = ",", end: str = "\n") -> str:
    """A record as text; missing speeds are empty cells."""
    lines = [header]
    columns = [record.time, record.current, record.speed]
    if record.setpoint is not None:
        columns.append(record.setpoint)
    for row in zip(*columns, strict=True):
        lines.append(sep.join("" if v != v else repr(float(v)) for v in row))
    return end.join(lines) + end


def spoiled(change: Callable[[Record], dict], header: str = HEADER) -> Callable[[Record], str]:
    """Text of a record with some fields changed."""

    def text(record: Record) -> str:
        fields = change(record)
        speed = fields.get("speed", record.speed)
        return rows(replace(record, valid=np.isfinite(speed), **fields), header)

    return text


def kept(mask: Callable[[Record], np.ndarray]) -> Callable[[Record], str]:
    """Text of a record with some of its rows."""

    def change(record: Record) -> dict:
        at = mask(record)
        return {"time": record.time[at], "current": record.current[at], "speed": record.speed[at]}

    def text(record: Record) -> str:
        fields = change(record)
        return rows(replace(record, valid=np.isfinite(fields["speed"]), **fields))

    return text


def some(values: np.ndarray, places, new) -> np.ndarray:
    """A copy with some values replaced."""
    values = values.copy()
    values[places] = new
    return values


def quantised(values: np.ndarray, step: float) -> np.ndarray:
    """Values rounded to a step."""
    return step * np.round(values / step)


def noise(record: Record, seed: int = 1) -> np.ndarray:
    """Standard normal numbers, one a sample."""
    return np.random.default_rng(seed).standard_normal(len(record.time))


def outlying(record: Record) -> dict:
    """Twenty speeds far off."""
    places = np.random.default_rng(2).integers(0, len(record.time), 20)
    return {"speed": some(record.speed, places, record.speed[places] + 40.0)}


def turned(record: Record) -> np.ndarray:
    """Angle of the wheel, rad."""
    mean = 0.5 * (record.speed[1:] + record.speed[:-1])
    return np.concatenate([[0.0], np.cumsum(mean * np.diff(record.time))])


def with_line(text: str, row: int, line: str) -> str:
    """Text with one line replaced."""
    lines = text.splitlines()
    lines[row] = line
    return "\n".join(lines) + "\n"


CLEAN = spoiled(lambda r: {})
SIX = 2.0 * np.pi / 6.0 / 0.1
CASES = (
    # units
    Case("rpm read as rad/s", spoiled(lambda r: {"speed": r.speed / RPM}), ("rpm read as rad/s",)),
    Case("rad/s read as rpm", spoiled(lambda r: {"speed": r.speed * RPM}), ("rad/s read as rpm",)),
    Case("rev/s read as rad/s", spoiled(lambda r: {"speed": r.speed / 6.283}), ("rev/s read as",)),
    Case("rad/s read as rev/s", spoiled(lambda r: {"speed": r.speed * 6.283}), ("read as rev/s",)),
    Case("deg/s read as rad/s", spoiled(lambda r: {"speed": r.speed * 57.3}), ("deg/s read as",)),
    Case("mA read as A", spoiled(lambda r: {"current": 1e3 * r.current}), ("mA read as A",)),
    Case("A read as mA", spoiled(lambda r: {"current": 1e-3 * r.current}), ("A read as mA",)),
    Case("ms read as s", spoiled(lambda r: {"time": 1e3 * r.time}), ("ms read as s",)),
    Case("s read as ms", spoiled(lambda r: {"time": 1e-3 * r.time}), ("s read as ms",)),
    Case("mrad/s read as rad/s", spoiled(lambda r: {"speed": 1e3 * r.speed}), ("mrad/s read as",)),
    Case("krpm read as rpm", spoiled(lambda r: {"speed": 1e-3 * r.speed}), ("krpm read as",)),
    Case("no unit", spoiled(lambda r: {}, "time_s,current_A,speed"), ("no unit",)),
    Case("speed in rpm, said", spoiled(lambda r: {"speed": r.speed / RPM}, "t [s],i [A],w [rpm]")),
    # signs
    Case("opposed signs", spoiled(lambda r: {"current": -r.current}), ("opposite senses",)),
    Case("unsigned speed", spoiled(lambda r: {"speed": np.abs(r.speed)}), ("speed restored",)),
    Case(
        "unsigned current with setpoint",
        spoiled(
            lambda r: {"current": np.abs(r.current), "setpoint": np.sign(r.current)},
            HEADER + ",setpoint",
        ),
        ("sign of current taken",),
    ),
    Case(
        "unsigned current",
        spoiled(lambda r: {"current": np.abs(r.current)}),
        ("current without sign", "sign of current"),
    ),
    # gaps and holes
    Case("gap across a step", kept(lambda r: (r.time < 50.0) | (r.time > 80.0))),
    Case("five gaps", kept(lambda r: r.time % 30.0 > 4.0)),
    Case("missing speeds", spoiled(lambda r: {"speed": some(r.speed, noise(r) > 1.5, np.nan)})),
    Case(
        "NaN cell, dropped",
        lambda r: with_line(CLEAN(r), 40, "3.9,nan,nan"),
        options={"missing": "drop"},
    ),
    Case("NaN cell", lambda r: with_line(CLEAN(r), 40, "3.9,nan,1.0"), ("row 41",)),
    Case(
        "NA cells, dropped",
        lambda r: with_line(with_line(CLEAN(r), 51, "NA,0.1,1.0"), 61, "6.0,0.1,NA"),
        options={"missing": "drop"},
    ),
    # clipping and frozen sensors
    Case(
        "clipped current",
        spoiled(
            lambda r: {
                "current": np.clip(
                    r.current + 1e-5 * noise(r),
                    -np.quantile(np.abs(r.current), 0.7),
                    np.quantile(np.abs(r.current), 0.7),
                )
            }
        ),
        ("clipped",),
    ),
    Case(
        "clipped current without noise",
        spoiled(
            lambda r: {
                "current": np.clip(r.current, *(np.array([-1, 1]) * np.median(np.abs(r.current))))
            }
        ),
        ("clipped",),
    ),
    Case("frozen tachometer", spoiled(lambda r: {"speed": some(r.speed, slice(500, 650), 9.0)})),
    Case("frozen at the end", spoiled(lambda r: {"speed": some(r.speed, slice(1400, 1501), 9.0)})),
    Case("tachometer drops out", spoiled(lambda r: {"speed": some(r.speed, slice(200, 230), 0.0)})),
    # lag and delay
    Case("lag of 50 ms", CLEAN, (), replace(BASE, lag=0.05)),
    Case("lag of 300 ms", CLEAN, ("lag or delay",), replace(BASE, lag=0.3)),
    Case("one sample late", spoiled(lambda r: {"speed": np.roll(r.speed, 1)}), ("lag or delay",)),
    # counters and encoders
    Case(
        "6 pulses a turn",
        spoiled(lambda r: {"speed": quantised(r.speed, SIX)}),
        ("pulse counter with 6",),
    ),
    Case("60 pulses a turn", spoiled(lambda r: {"speed": quantised(r.speed, SIX / 10.0)})),
    Case(
        "encoder angle",
        spoiled(lambda r: {"speed": quantised(turned(r), 2.0 * np.pi / 4096)}, "t_s,i_A,angle_rad"),
    ),
    Case("edge times", CLEAN, options={"edges": 6}),
    # drift
    Case("viscous friction drifts", CLEAN, (), replace(BASE, drift=0.15)),
    Case("dry friction drifts", CLEAN, ("drift",), replace(BASE, dry_drift=0.1)),
    Case("sinusoidal drift", CLEAN, (), replace(BASE, drift=0.1, drift_shape="sine")),
    # torques
    Case("torque ripple", CLEAN, (), replace(BASE, ripple=0.05)),
    Case("strong torque ripple", CLEAN, ("ripple",), replace(BASE, ripple=0.2)),
    Case("current offset", CLEAN, ("current offset",), replace(BASE, offset=1e-3)),
    Case("asymmetric bearing", CLEAN, ("asymmetry",), replace(BASE, asymmetry=0.05)),
    Case("everything usual", CLEAN, (), replace(BASE, ripple=0.05, drift=0.1, lag=0.05)),
    # noise
    Case("outliers", spoiled(outlying)),
    Case(
        "burst of noise",
        spoiled(lambda r: {"speed": r.speed + 3.0 * noise(r) * (np.abs(r.time - 60.0) < 5.0)}),
    ),
    # text
    Case("semicolons", lambda r: rows(r, HEADER.replace(",", ";"), ";")),
    Case("decimal comma", lambda r: rows(r, HEADER.replace(",", ";"), ";").replace(".", ",")),
    Case("byte order mark, CRLF", lambda r: "\ufeff" + rows(r, end="\r\n")),
    Case("row of units", lambda r: rows(r, "time,current,speed\ns,A,rad/s")),
    Case("comments and quotes", lambda r: rows(r, '# bench 7\n"time_s","current_A","speed_rad/s"')),
    Case("time goes back", lambda r: with_line(CLEAN(r), 90, "0.0,0.1,1.0"), ("increasing time",)),
    Case(
        "ragged row", lambda r: with_line(CLEAN(r), 90, "8.9,0.1"), ("row 91", "as in the header")
    ),
    Case("text in a cell", lambda r: with_line(CLEAN(r), 90, "8.9,off,1.0"), ("a number",)),
    Case("wrong column name", lambda r: rows(r, "time_s,amps_A,speed_rad/s"), ("current",)),
)


def outcome(case: Case, seed: int, folder: Path) -> tuple[str, str]:
    """'right', 'named' or 'WRONG', and what was said."""
    record, truth, _ = records(seed, 1, case.effects, duration=150.0, least_rise=1.1)[0]
    path = folder / "record.csv"
    path.write_text(case.text(record), encoding="utf-8", newline="")
    options, said, right = dict(case.options), [], False
    pulses = options.pop("edges", 0)
    try:
        if pulses:
            fine = np.linspace(0.0, record.time[-1], 200 * len(record.time))
            clean = records(seed, 1, replace(BASE, speed_sigma=0.0), duration=150.0, least_rise=1.1)
            angle = np.interp(
                fine, record.time, turned(replace(record, speed=np.abs(clean[0][0].speed)))
            )
            edges = np.interp(np.arange(0.0, angle[-1], 2.0 * np.pi / pulses), angle, fine)
            loaded = record_of_edges("edges", record.time, record.current, edges, pulses)
        else:
            roles = {"time": "t", "current": "i"} if "i_A" in path.read_text()[:20] else {}
            if path.read_text(encoding="utf-8")[:5] == "t [s]":
                roles = {"time": "t", "current": "i", "speed": "w"}
            loaded = read_record(path, columns=roles or None, **options)
        loaded = cut(loaded)
        fit = identify(
            loaded, inertia=INERTIA, hold={"stribeck_speed": STRIBECK_SPEED}, model="auto"
        )
        said = [*(n for r in fit.records for n in r.notes), *fit.choices, *fit.warnings]
        names = ("motor_constant", "coulomb") if "coulomb" in fit.names else ("motor_constant",)
        error = np.array([fit.parameters[n] - truth[n] for n in names])
        sigma = np.array([fit.sigma[fit.names.index(n)] for n in names])
        share = np.abs(error) / np.array([truth[n] for n in names])
        right = fit.converged and bool(np.all((np.abs(error) < 4.0 * sigma) & (share < 0.05)))
        said.append(f"errors {np.round(error / sigma, 1)} sigma, {np.round(100 * share, 2)} %")
    except InputError as error:
        said = [str(error)]
    if any(word in text for word in case.named for text in said):
        return "named", next(t for t in said if any(w in t for w in case.named))
    return ("right" if right and not case.named else "WRONG"), " | ".join(said)


def main() -> None:
    """Print one line for each case and the count."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only")
    parser.add_argument("--seed", type=int, default=70000)
    arguments = parser.parse_args()
    cases = [c for c in CASES if arguments.only in (None, c.name)]
    good = 0
    with tempfile.TemporaryDirectory() as folder:
        for case in cases:
            started = clock.perf_counter()
            verdict, said = outcome(case, arguments.seed, Path(folder))
            good += verdict != "WRONG"
            seconds = clock.perf_counter() - started
            print(f"{verdict:6s} {case.name:32s} {seconds:5.1f} s  {said[:160]}", flush=True)
    print(f"{good} of {len(cases)}")


if __name__ == "__main__":
    main()
