"""Verb `check`: a scenario without its simulation."""

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

from gyrostat.verbs.arguments import Say, silent

if TYPE_CHECKING:
    from gyrostat.runs.passes import Pass
    from gyrostat.runs.user.support import Support
    from gyrostat.scenario import Scenario


@final
class CheckedScenario(dict[str, str]):
    """Section -> kind of its component.

    Attributes:
        parts: Section -> what your part in it can be compiled for: `native` and `export` are None,
            or have the operation, file, line and text that keep it from the native engine or from
            an export to C.
        unlikely: Lines on numbers that are possible, but unlikely.
        warnings: Lines on a momentum at the start that the wheels cannot hold, on windows in which
            the star tracker sees too rarely, on times in which an instrument does not keep its
            angles along the reference, and on wheels that are faster than the structure of a metric
            `jitter` is known.
        passes: Passes over ground stations and eclipses of the nominal run.
        slews: Lines on the slews with `keep_out`.
        lines: All lines for the user, as the command line prints them.
    """

    parts: "dict[str, Support]"
    unlikely: list[str]
    warnings: list[str]
    passes: "list[Pass]"
    slews: list[str]
    lines: list[str]

    def __str__(self) -> str:
        """Lines of the command line."""
        return "\n".join(self.lines)

    def _repr_html_(self) -> str:
        """The same lines, for a notebook."""
        return f"<pre>{escape(str(self))}</pre>"


def check(
    scenario: "Scenario | str | Path", *, force: bool = False, say: Say = silent, **changes: Any
) -> CheckedScenario:
    """Check a scenario without simulating it: keys, controller designs, and calls of every part.

    Your parts are called several times on shapes alone, and must do the same each time; the
    controller also computes its first command.

    Args:
        scenario: Scenario, or path of scenario.toml.
        force: Whether to accept wheels that are marked as impossible.
        say: Function that receives each message for the user.
        changes: Changes of the scenario, as for `simulate`.

    Returns:
        Section -> kind of its component; the attribute `parts` states for each part of yours
        whether the native engine can simulate it and whether it can be exported to C, and
        otherwise the line because of which it cannot.

    Raises:
        InputError: The scenario has a mistake; the message names the file, the key or the part,
            what was found and what was expected.
    """
    from gyrostat.campaigns.pointing.text import requirement_lines
    from gyrostat.campaigns.start_momentum import momentum_lines
    from gyrostat.core.user_modules import is_user_kind
    from gyrostat.runs.jitter_lines import fast_wheels
    from gyrostat.runs.keep_out_times import reference_violations
    from gyrostat.runs.passes import pass_lines, passes_of
    from gyrostat.runs.plans import designs_of
    from gyrostat.runs.reference_path import check_directions
    from gyrostat.runs.slew_lines import slew_lines
    from gyrostat.runs.tracker_forecast import tracker_lines
    from gyrostat.runs.user.trial import supports_of
    from gyrostat.scenario.kinds.registry import kinds_of
    from gyrostat.scenario.mode_graph import check_modes, late_changes
    from gyrostat.scenario_files.scenario_file import validated

    definition = scenario_of(scenario, force=force, changes=changes)
    if not isinstance(scenario, str | Path) and not changes:
        validated(definition)
    result = CheckedScenario(kinds_of(definition))
    result.lines, say = _noted(say)
    result.unlikely = say_unlikely(definition, say)
    result.parts = supports_of(definition, designs_of(definition)) if definition.sources else {}
    for section, kind in result.items():
        start = f"{section}."
        parts = [
            f"{key.removeprefix(start)} = {value:g}"
            for key, value in definition.values.items()
            if key.startswith(start) and is_user_kind(kind)
        ]
        say(", ".join([f"{section}: {kind}", *parts]))
        if section in result.parts:
            say(f"  {result.parts[section]}")
    if is_user_kind(definition.friction):
        say(f"friction: {definition.friction}{friction_at_rest(definition)}")
        if "friction" in result.parts:
            say(f"  {result.parts['friction']}")
    for line in requirement_lines(definition):
        say(line)
    graph = check_modes(definition)
    if graph:
        say(graph)
    check_directions(definition)
    result.passes = passes_of(definition)
    for line in pass_lines(definition, result.passes):
        say(line)
    lines, result.warnings = tracker_lines(definition)
    result.slews = slew_lines(definition)
    result.warnings += [*late_changes(definition), *reference_violations(definition)]
    result.warnings += fast_wheels(definition)
    momentum, beyond = momentum_lines(definition)
    lines, result.warnings = [*momentum, *lines], [*beyond, *result.warnings]
    for line in (*result.slews, *lines, *result.warnings):
        say(line)
    return result


def _noted(say: Say) -> tuple[list[str], Say]:
    """List that receives each line, and a function that adds a line and says it."""
    lines: list[str] = []

    def noted(line: str) -> None:
        lines.append(line)
        say(line)

    return lines, noted


def say_unlikely(scenario: "Scenario", say: Say) -> list[str]:
    """Report the numbers of a scenario that are possible, but unlikely, and return the lines."""
    from gyrostat.scenario.unlikely import unlikely_numbers

    lines = unlikely_numbers(scenario)
    for line in lines:
        say(line)
    return lines


def say_momentum(scenario: "Scenario", say: Say, seed: int = 0, runs: int = 1) -> None:
    """Report a momentum at the start that the wheels cannot hold; `runs` draws with dispersions."""
    from gyrostat.campaigns.start_momentum import momentum_lines

    for line in momentum_lines(scenario, seed, runs)[1]:
        say(line)


def friction_at_rest(scenario: "Scenario") -> str:
    """Addition to the line of a user's friction law without friction at rest."""
    from gyrostat.wheel.friction import Friction
    from gyrostat.wheel.friction.contract import is_free_at_rest
    from gyrostat.wheel.friction_laws import law_of

    law = law_of(scenario.friction, scenario.sources)
    start = f"wheel.{scenario.wheels[0]}."
    values = {name: scenario.values[f"{start}{name}"] for name in law.dimensions()}
    free = issubclass(law, Friction) and is_free_at_rest(law.of(**values))
    return ", no friction at rest: the wheels never stick" if free else ""


def scenario_of(
    scenario: "Scenario | str | Path", *, force: bool, changes: Mapping[str, Any] | None = None
) -> "Scenario":
    """Scenario, read from its file unless it is an object, with changes."""
    from gyrostat.scenario_files.scenario_file import read_scenario

    if isinstance(scenario, str | Path):
        scenario = read_scenario(scenario, force=force)
    return scenario.replace(**changes) if changes else scenario
