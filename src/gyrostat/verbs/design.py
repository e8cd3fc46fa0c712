"""Design of the next bench record, a mode of the verb `bench`."""

import json
import math
from collections.abc import Iterable
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Named, Quantity, Say, in_si, named, parts_of
from gyrostat.verbs.wheel_arguments import wheel_model

if TYPE_CHECKING:
    from gyrostat.identification import Fit
    from gyrostat.identification.experiment.design import Design
    from gyrostat.identification.experiment.known_wheel import KnownWheel
    from gyrostat.wheel import Wheel, WheelModel

USUAL_CURRENT = 4.0
"""Largest current without a stated limit, in breakaway currents of the estimated wheel."""


def known_wheel(model: "WheelModel | Wheel | Fit | str | Path", *, force: bool) -> "KnownWheel":
    """Wheel with its uncertainty: a fit, fit.json, or a model with sigmas.

    Args:
        model: Object or path.
        force: Whether to accept a wheel that its identification marked as impossible.

    Raises:
        InputError: The wheel or its uncertainty is not known.
    """
    from gyrostat.identification import Fit
    from gyrostat.identification.experiment.known_wheel import KnownWheel

    if isinstance(model, str | Path) and Path(model).suffix.lower() == ".json":
        return KnownWheel.read(Path(model), force=force)
    if isinstance(model, Fit):
        wheel_model(model, force=force)
        return KnownWheel.from_fit(model)
    return KnownWheel.from_model(wheel_model(model, force=force))


MOST_RUNS = 10_000
"""Largest number of simulated records."""
DRIFTING = ("viscous", "dry")
"""Frictions whose drift may be stated, in the order of `RecordEffects`."""


def _with_drifts(wheel: "KnownWheel", drift: Named) -> "KnownWheel":
    """Wheel with the drifts that the user states.

    Raises:
        InputError: A name or share is not possible.
    """
    drifts = list(wheel.drifts)
    for name, value in named(drift, "--drift").items():
        if name not in DRIFTING:
            raise InputError(f"--drift: found {name!r}, expected {' or '.join(DRIFTING)}")
        text = str(value).strip()
        share = in_si(text.removesuffix("%"), "1", "--drift") / (100.0 if "%" in text else 1.0)
        if not (math.isfinite(share) and 0.0 <= share <= 0.5):
            raise InputError(f"--drift {name}: found {value}, expected 0 to 0.5")
        drifts[DRIFTING.index(name)] = (share, 0.0)
    return replace(wheel, drifts=tuple(drifts))


def design(
    model: "WheelModel | Wheel | Fit | str | Path",
    wanted: str | Iterable[str],
    out: Path | None,
    *,
    duration: Quantity,
    rate: float,
    most: Quantity | None,
    slew: float | None,
    max_speed: Quantity | None,
    initial_speed: Quantity,
    speed_sigma: Quantity,
    target_sigma: Quantity | Iterable[Quantity] | None,
    ripple: float | None,
    drift: Named,
    simulate: int,
    seed: int,
    force: bool,
    say: Say,
    command: str,
) -> "Design":
    """Design the next record; write it, its prediction as JSON and its page.

    Args:
        model: Fit, fit.json or model with sigmas.
        wanted: Parameters or linear combinations.
        out: File for the profile, .csv; the other files have its name with .json and .html.
        duration: Longest duration, s.
        rate: Samples per second, Hz.
        most: Largest current, A.
        slew: Largest rate of change of the current, A/s.
        max_speed: Largest speed, rad/s.
        initial_speed: Speed at the start, rad/s.
        speed_sigma: Standard deviation of the measured speed, rad/s; zero: that of the fit.
        target_sigma: Wanted standard deviation of each combination.
        ripple: Torque ripple, rms over the dry friction torque.
        drift: "viscous" and "dry" -> drift of this friction from mid-record to its end, as a share,
            one sigma; those of the fit where it is not given.
        simulate: Number of simulated records of the design; 0: none.
        seed: Seed of the search.
        force: Whether to replace files that gyrostat did not write, and to accept an impossible
            wheel.
        say: Function that receives each message.
        command: Text that the page names as its origin.

    Raises:
        InputError: An argument cannot be used, or an existing file would be replaced.
    """
    import numpy as np

    from gyrostat.core.outputs import check_outputs, new_files
    from gyrostat.identification.bench_tests.design_rehearsal import check_design
    from gyrostat.identification.experiment.current_profiles import Limits
    from gyrostat.identification.experiment.design_text import content, table
    from gyrostat.identification.experiment.experiment_design import (
        breakaway_current,
        design_record,
    )
    from gyrostat.reports.design import design_page
    from gyrostat.telemetry import Record, write_record

    names: list[str] = []
    if out is not None:
        if out.suffix.lower() != ".csv":
            raise InputError(f"{out}: found the suffix {out.suffix!r}, expected .csv")
        names = [out.name, f"{out.stem}.json", f"{out.stem}.html"]
        check_outputs(out.parent, names, by="bench", force=force)
    if not 0 <= simulate <= MOST_RUNS:
        raise InputError(f"--simulate: found {simulate}, expected 0 to {MOST_RUNS}")
    wheel = _with_drifts(known_wheel(model, force=force), drift)
    combinations = [str(text).strip() for text in parts_of(wanted)]
    torques = {wheel.dimension(text, "--design") for text in combinations}
    targets = () if target_sigma is None else parts_of(target_sigma)
    dimension = torques.pop() if len(torques) == 1 else None
    noise = in_si(speed_sigma, "speed", "--speed-sigma") or wheel.speed_sigma
    if noise is None:
        raise InputError("--speed-sigma: found none, expected the tachometer noise, or a fit.json")
    usual = USUAL_CURRENT * breakaway_current(wheel)
    limits = Limits(
        duration=in_si(duration, "time", "--duration"),
        rate=rate,
        current=usual if most is None else in_si(most, "current", "--high"),
        slew=np.inf if slew is None else slew,
        speed=np.inf if max_speed is None else in_si(max_speed, "speed", "--max-speed"),
        initial_speed=in_si(initial_speed, "speed", "--initial-speed"),
    )
    say(f"designing a record for {', '.join(combinations)}")
    result = design_record(
        wheel,
        combinations,
        limits,
        speed_sigma=noise,
        targets=[in_si(t, dimension, "--target-sigma") if dimension else float(t) for t in targets],
        ripple=ripple,
        seed=seed,
        say=say,
    )
    for line in table(result):
        say(line)
    check = None
    if simulate:
        say(f"simulating {simulate} records")
        check = check_design(wheel, result, runs=simulate, ripple=ripple, seed=seed, say=say)
        for line in check.lines():
            say(line)
    if out is not None:
        simulation = {} if check is None else {"simulation": asdict(check)}
        text = json.dumps(
            {**content(result), **simulation}, indent=1, ensure_ascii=False, allow_nan=False
        )
        page = design_page(result, command=command, check=check)
        valid = np.ones(len(result.time), dtype=bool)
        record = Record(out.name, result.time, result.current, result.speed, valid)
        with new_files(out.parent, by="bench", force=force) as folder:
            write_record(record, folder / out.name)
            (folder / names[1]).write_text(text + "\n", encoding="utf-8")
            (folder / names[2]).write_text(page, encoding="utf-8")
        say(f"written: {', '.join(str(out.parent / name) for name in names)}")
    return result
