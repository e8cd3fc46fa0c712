"""Verb `identify`: identify a wheel from bench records."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.verbs.arguments import (
    Named,
    Quantity,
    Say,
    figure_names,
    in_si_or_none,
    named,
    one_of,
    quantities,
    refuse_given,
    silent,
)
from gyrostat.verbs.wheel_arguments import (
    HOLDS,
    factors_and_tolerances,
    inertia_and_tolerance,
    load_records,
    loop_of,
    parameters_in_si,
    priors,
)

if TYPE_CHECKING:
    from gyrostat.identification import Fit
    from gyrostat.telemetry import Record
    from gyrostat.wheel.friction_laws import Law

    Records = Record | str | Path | Sequence[Record | str | Path]

METHODS = ("batch", "steady", "torque-step", "coast", "inverse")


def identify(
    records: "Records",
    out: "str | Path | None" = None,
    *,
    inertia: Quantity | None = None,
    current_scale: Quantity | None = None,
    speed_scale: Quantity | None = None,
    clock: Quantity | None = None,
    ripple: float | None = None,
    current_quantum: Quantity | None = None,
    speed_quantum: Quantity | None = None,
    model: "str | Law | None" = None,
    method: str = "batch",
    hold: Named = None,
    free: str | Iterable[str] | None = None,
    prior: Named = None,
    start: Named = None,
    speed_sigma: Quantity | Sequence[Quantity] | None = None,
    loss: str | None = None,
    current_hold: str | None = None,
    compare: bool = False,
    held_out: "Records | None" = None,
    columns: Mapping[str, str] | str | Path | None = None,
    units: Mapping[str, str] | str | None = None,
    unsigned_current: bool = False,
    unsigned_speed: bool = False,
    missing: str = "refuse",
    edges: "str | Path | None" = None,
    pulses: int = 1,
    speed_from: "str | Path | None" = None,
    speed_columns: Mapping[str, str] | str | Path | None = None,
    posterior: bool = False,
    loop: "str | Path | None" = None,
    force: bool = False,
    figures: str | None = None,
    say: Say = silent,
    command: str = "gyrostat.identify",
) -> "Fit":
    """Identify a wheel from bench records.

    Args:
        records: Records of one wheel, or paths of CSV, Parquet or MATLAB files.
        out: Folder for fit.json, model.toml and report.html; None writes no file.
        inertia: Inertia of rotor and flywheel, kg·m²; text may give a tolerance of one standard
            deviation: "1.5e-3 +- 1 %".
        current_scale: True divided by measured current: "+- 1 %" or "1.01 +- 0.5 %".
        speed_scale: True divided by measured speed, in the same form.
        clock: True divided by recorded time, in the same form.
        ripple: Torque ripple, rms over the dry friction torque, 0 to 1; by default it is estimated,
            but few zero crossings hardly tell it.
        current_quantum: Step to which the recorded current was rounded, A; 0: not rounded. By
            default it is found.
        speed_quantum: Step to which the recorded speed was rounded, rad/s; 0: not rounded. By
            default it is found.
        model: Friction model, by default "stribeck"; a class of your own or "FILE.py:CLASS"; or
            "auto": the simplest one, with the effects that the diagnosis finds.
        method: "batch", "steady", "torque-step", "coast" or "inverse".
        hold: Parameters that are not estimated: name -> value, or None for the default.
        free: Further parameters to estimate.
        prior: A-priori knowledge: name -> (mean, standard deviation).
        start: Start values: name -> value.
        speed_sigma: Standard deviation of the measured speed, rad/s; one, or one for each record.
        loss: "quadratic" (default), "huber" or "student".
        current_hold: Current between samples: "zero-order" (default) or "linear".
        compare: Whether to rank the other friction models too.
        held_out: Records used only for the ranking or, with "inverse", for their torque error.
        columns: Role -> column, such as {"current": "m1cur"}, or a .toml file of them.
        units: Role -> unit, if the file has none.
        unsigned_current: Whether the current is a magnitude; the sign is taken from setpoint or
            speed.
        unsigned_speed: Whether the speed is a magnitude; the sign changes where it touches zero.
        missing: Treatment of cells without a number: "refuse" raises an error, "drop" omits their
            rows.
        edges: File with the times of a tachometer's edges, s, in place of a speed.
        pulses: Edges per revolution, with `edges`.
        speed_from: File with the speed, of a logger with its own clock; the lag is found.
        speed_columns: Columns of this file; as `columns`.
        posterior: Whether to sample the posterior too, for parameters whose uncertainty is not
            Gaussian (extra `posterior`).
        loop: Whether the current depends on the measured speed: "open" or "closed"; or, with
            "inverse", a .toml file with the control law of the drive in its table [loop].
        force: Whether to replace files that gyrostat did not write.
        figures: "pdf", "svg" or "png": write the figures for papers too; None: none.
        say: Function that receives each message for the user.
        command: Text that the report names as its origin.

    Returns:
        The fit: `print` shows it as a table, `wheel()` gives the wheel. The result is valid if it
        has `converged` and nothing in it is `impossible`; a posterior says itself if it is `valid`.

    Raises:
        InputError: A record or option cannot be used, or existing files would be replaced.
    """
    from gyrostat import identification as stage
    from gyrostat.core.errors import InputError
    from gyrostat.core.outputs import check_outputs
    from gyrostat.reports.write import FILES, check_law_files, write_fit
    from gyrostat.wheel.friction_laws import friction_law

    # the class gives the parameter names, also of the automatic choice
    law = friction_law(
        "stribeck" if model is None or model == "auto" else model, "--model", ("auto",)
    )
    choice = "auto" if model == "auto" else law
    if out is not None:
        names = [*FILES, *figure_names(figures, "report")]
        check_outputs(Path(out), names, by="identify", force=force)
        check_law_files(law, Path(out), force=force)
    one_of(method, METHODS, "--method")
    one_of(current_hold or HOLDS[0], HOLDS, "--current-hold")
    value, tolerance = inertia_and_tolerance(inertia)
    factors, shares = factors_and_tolerances(
        {"current_scale": current_scale, "speed_scale": speed_scale, "clock": clock}
    )
    tolerance |= shares
    common: dict[str, Any] = {
        "inertia": value,
        "hold": parameters_in_si(named(hold, "--hold", bare=True), law, "--hold"),
    }
    sigmas = quantities(speed_sigma, "speed", "--speed-sigma")
    reading = {
        "columns": columns,
        "units": units,
        "unsigned_current": unsigned_current,
        "unsigned_speed": unsigned_speed,
        "missing": missing,
        "edges": edges,
        "pulses": pulses,
        "speed_from": speed_from,
        "speed_columns": speed_columns,
    }
    if ripple is not None and not 0.0 <= ripple <= 1.0:
        raise InputError(
            f"--ripple: found {ripple:g}, expected 0 to 1, the rms over the dry friction torque"
        )
    quanta = {
        "current_quantum": in_si_or_none(current_quantum, "current", "--current-quantum"),
        "speed_quantum": in_si_or_none(speed_quantum, "speed", "--speed-quantum"),
    }
    state, law_file = loop_of(loop, method)
    measured = [record.scaled(**factors) for record in load_records(records, say, **reading)]
    if len({record.metadata.get("date") for record in measured}) > 1:
        say("records of several dates: `gyrostat pool` estimates what varies between them")
    if method == "batch":
        title = choice if isinstance(choice, str) else choice.name
        say(f"identifying {title} friction from {', '.join(r.name for r in measured)}")
        problem = stage.Problem.of(
            measured,
            **common,
            model=choice,
            free=[free] if isinstance(free, str) else list(() if free is None else free),
            prior=priors(prior, law),
            start=parameters_in_si(named(start, "--start"), law, "--start"),
            speed_sigma=sigmas or None,
            loss=loss,
            current_hold=current_hold,
            loop=state,
            **{
                name: quantum * factors.get(name.replace("quantum", "scale"), 1.0)
                for name, quantum in quanta.items()
                if quantum is not None
            },
        )
        fit = stage.identify_problem(
            replace(problem, tolerance=tolerance, ripple=ripple, posterior=posterior),
            on_draws=lambda count: say(f"  posterior: {count} draws of each chain"),
            on_progress=lambda stage, count, cost: say(
                f"  {stage}: iteration {count}, cost {cost:.6g}"
            ),
        )
        trends = stage.trends_of(replace(problem, model=fit.model), say)
        fit = replace(fit, temperatures=tuple(trends))
        if compare or held_out:
            test_records = load_records(held_out or (), say, **reading)
            say("ranking the other friction models")
            test_records = [record.scaled(**factors) for record in test_records]
            ranking = stage.candidates_of(problem, test_records, known=fit)
            fit = replace(fit, comparison=tuple(ranking))
    else:
        inverse = method == "inverse"
        batch_only = {
            "--free": free,
            "--ripple": ripple,
            "--current-quantum": current_quantum,
            "--speed-quantum": speed_quantum,
            "--prior": prior,
            "--start": start,
            "--loss": loss,
            "--current-hold": None if inverse else current_hold,
            "--compare": compare,
            "--held-out": None if inverse else held_out,
            "--posterior": posterior,
            "more than one --speed-sigma": sigmas[1:],
        }
        refuse_given(batch_only, f"--method {method}", "--method batch")
        common["speed_sigma"] = sigmas[0] if sigmas else None
        common |= {"model": None if model is None else choice, "tolerance": tolerance}
        if inverse:
            others = load_records(held_out or (), say, **reading)
            fit = stage.identify_inverse(
                measured,
                **common,
                law=None if law_file is None else stage.read_control_law(law_file),
                current_hold=current_hold or HOLDS[0],
                held_out=[record.scaled(**factors) for record in others],
            )
        else:
            fit = stage.identify_dedicated(method, measured, **common)
    if out is not None:
        write_fit(fit, Path(out), command=command, say=say, force=force)
        if figures:
            from gyrostat.reports.paper_figures import write_figures

            drawn = {"report": fit.plot()}
            write_figures(drawn, Path(out), figures, by="identify", say=say, force=force)
    return fit
