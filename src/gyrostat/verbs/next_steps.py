"""What to do after an answer about failed wheels, with the command to run."""

import math
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.failures.attitude_words import turn_and_angles
from gyrostat.failures.steps import NextStep
from gyrostat.verbs.telemetry import TelemetryOptions

if TYPE_CHECKING:
    from gyrostat.core.types import Vector
    from gyrostat.failures import Holdable, Recovery

Words = Sequence[str]


@dataclass(frozen=True)
class Query:
    """Inputs of a verb on failures as the user gave them, to repeat them in a command.

    Attributes:
        spacecraft: Path of the spacecraft file.
        failed: Name of each failed wheel -> its failure as given.
        telemetry: Telemetry as given.
        target: Options that give the target -> their values; None for those that are not given.
        out: Folder of this verb's results.
        brake: Name of each braked wheel -> its brake as given.
        external_torque: External torque as given; None if none was.
    """

    spacecraft: str | Path
    failed: Mapping[str, Any]
    telemetry: TelemetryOptions
    target: Mapping[str, Any]
    out: Path
    brake: Mapping[str, Any] = field(default_factory=dict)
    external_torque: Any = None

    def command(self, verb: str, words: Words, folder: str) -> str:
        """Command line of a verb for the same spacecraft, quoted for a shell.

        Args:
            verb: Name of the verb.
            words: Options and their values.
            folder: Folder for its results, below that of this verb.
        """
        out = ("--out", str(self.out / folder))
        return shlex.join(["gyrostat", verb, str(self.spacecraft), *words, *out])

    def state_words(self) -> list[str]:
        """Options of the telemetry."""
        options = self.telemetry
        return [
            *_option("--telemetry", options.telemetry),
            *_option("--attitude", options.attitude),
            *_option("--attitude-euler", options.attitude_euler),
            *_option("--rate", options.rate),
            *_option("--wheels", options.wheels),
        ]

    def target_words(self) -> list[str]:
        """Options of the target, and of the order of quaternions."""
        words = [word for name, value in self.target.items() for word in _option(name, value)]
        return words + self.order()

    def order(self) -> list[str]:
        """Option of the order of quaternions."""
        return ["--scalar-last"] if self.telemetry.scalar_last else []


def after_feasible(
    query: Query,
    answer: "Holdable",
    momentum: "Vector",
    kept: Mapping[str, float],
    frozen: Iterable[str],
) -> list[NextStep]:
    """What to do after a feasibility query.

    Args:
        query: Inputs of the query.
        answer: Its answer.
        momentum: Total momentum, inertial axes, (3,), N·m·s.
        kept: Name of each failed wheel -> the momentum that it keeps, N·m·s.
        frozen: Names of the wheels whose momentum in the telemetry differs from the given one; a
            simulation starts with that in the telemetry.
    """
    steps: list[NextStep] = []
    if answer.attitude is not None and kept:
        where = "the target" if answer.holdable else "the nearest feasible attitude"
        if query.telemetry.is_given:
            as_measured = {**query.failed, **dict.fromkeys(frozen, "frozen")}
            words = [
                *_repeat("--failed", as_measured),
                *query.state_words(),
                *_recovery_target(query, answer),
            ]
            steps.append(
                NextStep(
                    f"simulate the slew to {where}", query.command("recover", words, "recover")
                )
            )
        else:
            steps.append(
                NextStep(
                    f"to simulate the slew to {where}, give attitude, rate and wheel speeds "
                    "(--telemetry or --attitude, --rate, --wheels) instead of --momentum"
                )
            )
    elif any(kept.values()):
        words = [
            *_repeat("--failed", dict.fromkeys(kept, "seized")),
            *query.state_words(),
            *query.target_words(),
        ]
        if not query.telemetry.is_given:
            words += _option("--momentum", momentum)
        why = "the answer if the failed wheels stop (brake, friction)"
        steps.append(NextStep(why, query.command("feasible", words, "stopped")))
    return steps + _after_unloading(query, answer, momentum, kept)


def after_recover(
    query: Query,
    recovery: "Recovery",
    momentum: "Vector",
    kept: Mapping[str, float],
    *,
    duration: float,
    period: float,
) -> list[NextStep]:
    """What to do after a simulated recovery.

    Args:
        query: Inputs of the simulation.
        recovery: Its result.
        momentum: Total momentum, inertial axes, (3,), N·m·s.
        kept: Name of each failed wheel -> the momentum that it keeps, N·m·s.
        duration: Simulated time, s.
        period: Control period, s.
    """
    steps: list[NextStep] = []
    answer = recovery.plan.answer
    if recovery.settle is not None and answer.attitude is not None and not answer.holdable:
        where = turn_and_angles(answer.attitude)
        steps.append(NextStep(f"command this attitude instead of the target: {where}"))
    latest = max(recovery.earliest.values(), default=0.0)
    if recovery.is_too_short and math.isfinite(latest):
        # the wheel must have slowed down, and the slew still takes as long as this one
        periods = math.ceil(max(2.0 * duration, latest + duration) / period)
        words = [*_repeat("--failed", query.failed), *_repeat("--brake", query.brake)]
        words += [*query.state_words(), *query.target_words()]
        words += _option("--external-torque", query.external_torque)
        words += ["--duration", f"{periods * period:.12g}"]
        if period != DEFAULT_PERIOD:
            words += ["--period", f"{period:.12g}"]
        steps.append(NextStep("simulate longer", query.command("recover", words, "longer")))
    return steps + _after_unloading(query, answer, momentum, kept)


DEFAULT_PERIOD = 0.5
"""Control period of `recover` if none is given, s."""


def _after_unloading(
    query: Query, answer: "Holdable", momentum: "Vector", momenta: Mapping[str, float]
) -> list[NextStep]:
    """The same query after unloading, to verify that the target is then feasible."""
    if answer.unload is None:
        return []
    momentum_text = ",".join(f"{value:.12g}" for value in momentum - answer.unload + 0.0)
    failures = {name: f"{value:.12g}" if value else "seized" for name, value in momenta.items()}
    words = [*_repeat("--failed", failures), "--momentum", momentum_text, *query.target_words()]
    why = "verify the target with that momentum unloaded"
    return [NextStep(why, query.command("feasible", words, "unloaded"))]


def _recovery_target(query: Query, answer: "Holdable") -> list[str]:
    """Options of the target attitude; for a boresight, the nearest feasible attitude."""
    import numpy as np

    if query.target.get("--towards") is None:
        attitude = {name: query.target.get(name) for name in ("--target", "--euler")}
        return replace(query, target=attitude).target_words()
    quaternion = np.roll(np.asarray(answer.attitude), -1 if query.telemetry.scalar_last else 0)
    return [*_option("--target", quaternion), *query.order()]


def _repeat(option: str, values: Mapping[str, Any]) -> list[str]:
    """Repeated option with NAME or NAME=VALUE."""
    return [
        word
        for name, value in values.items()
        for word in (option, name if value is None else f"{name}={_text(value)}")
    ]


def _option(name: str, value: Any) -> list[str]:
    return [] if value is None else [name, _text(value)]


def _text(value: Any) -> str:
    """Text of a value for the command line."""
    if isinstance(value, str | Path):
        return str(value)
    if isinstance(value, Iterable):
        return ",".join(_text(part) for part in value)
    return f"{value:.12g}"
