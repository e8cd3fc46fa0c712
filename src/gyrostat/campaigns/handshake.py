"""Check of a worker before its first job: it must give the same bytes as this process."""

import hashlib
import json
import platform
import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

from gyrostat.campaigns.delivered_programs import (
    Label,
    content_of,
    digest_of_content,
    install_programs,
    missing_programs,
)
from gyrostat.core.errors import InputError
from gyrostat.runs.fingerprint import FLAGS, Record, engine_record, use_engine
from gyrostat.scenario.scenario import Scenario


@dataclass(frozen=True)
class Handshake:
    """What a worker must have and must be like.

    Attributes:
        record: Fingerprint of the engine.
        labels: Programs of the native engine.
        scenarios: Texts of scenarios with parts of the user, whose packages are compared.
        contents: Digest -> content of each program; it is not sent with the handshake.
    """

    record: Record
    labels: tuple[Label, ...] = ()
    scenarios: tuple[str, ...] = ()
    contents: Mapping[str, bytes] = field(default_factory=dict, compare=False)

    @property
    def unused(self) -> tuple[str, ...]:
        """Names in the fingerprint that may differ: only scenarios of the user are compiled."""
        return () if self.scenarios else ("compiler",)

    @cached_property
    def identity(self) -> str:
        """Digest of all that is compared."""
        parts = (dict(self.record), self.labels, self.scenarios)
        return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()

    def __getstate__(self) -> dict[str, Any]:
        """State without the contents of the programs."""
        return {**self.__dict__, "contents": {}}


def handshake(
    record: Record | None = None, scenarios: Iterable[tuple[Scenario, int]] = ()
) -> Handshake:
    """Handshake with the workers of a computation; compiles the programs that they receive.

    Args:
        record: Fingerprint of the engine; None for JAX on a processor.
        scenarios: Scenarios that the workers simulate, each with its `parts`; see
            `gyrostat.campaigns.native.program_of`.

    Raises:
        InputError: A program cannot be made.
    """
    from gyrostat.campaigns.ready import make_ready
    from gyrostat.scenario.kinds.registry import is_shipped
    from gyrostat.scenario.structure import structure_of

    if record is None:
        record = engine_record("cpu", FLAGS["cpu"])
    contents, labels, foreign = {}, [], []
    for scenario, parts in scenarios:
        if not is_shipped(structure_of(scenario)):
            foreign.append(scenario.text())
        elif record.get("engine") == "native":
            program: Any = make_ready(scenario, "native", parts).program
            content = content_of(program)
            digest = digest_of_content(content)
            contents[digest] = content
            labels.append(Label(scenario.digest(), parts, digest))
    return Handshake(record, tuple(labels), tuple(foreign), contents)


class Answer(NamedTuple):
    """Answer of a worker.

    Attributes:
        refusal: Why the worker cannot be used; empty if it can.
        missing: Digests of programs that it does not have.
    """

    refusal: str = ""
    missing: Collection[str] = ()


_accepted: set[str] = set()
"""Identities of handshakes."""
_flags: set[str] = set()
"""Flags of XLA, which it reads once in each process."""


def greet(asked: Handshake, where: str, contents: Mapping[str, bytes]) -> Answer:
    """Check this process, a worker, and install the programs.

    Args:
        asked: Handshake.
        where: Name of the worker, for the refusal.
        contents: Digest -> content of programs that it was missing.
    """
    flags = asked.record["flags"]
    if _flags and flags not in _flags:
        found = "flags of an earlier computation, which JAX keeps"
        return Answer(f"{where}: found {found}, expected those of this one: start the worker again")
    try:
        use_engine(asked.record, where, asked.unused)
        # after the flags of JAX are set
        from gyrostat.campaigns.ready import make_ready
        from gyrostat.runs.user.packages import refuse_other_packages

        for text in asked.scenarios:
            refuse_other_packages(Scenario.from_text(text), where)
        missing = [digest for digest in missing_programs(asked.labels) if digest not in contents]
        if missing:
            return Answer(missing=missing)
        if install_programs(asked.labels, contents):
            # the same scenario, compiled by another machine
            _accepted.clear()
            make_ready.cache_clear()
    except (InputError, OSError) as error:
        text = str(error)
        return Answer(text if text.startswith(where) else f"{where}: {text}")
    _flags.add(flags)
    _accepted.add(asked.identity)
    return Answer()


class Outcome(NamedTuple):
    """Results of jobs in a worker.

    Attributes:
        was_greeted: Whether the process had accepted the handshake; otherwise there are no results.
        results: Results of the jobs.
        seconds: Time that they took, s.
        error: What a job has raised, instead of results. An error of the call itself is thus one of
            the connection.
    """

    was_greeted: bool
    results: Sequence[Any] = ()
    seconds: float = 0.0
    error: Exception | None = None


def carry_out_greeted(identity: str, jobs: Sequence[tuple[Callable[[Any], Any], Any]]) -> Outcome:
    """Apply functions to jobs in a worker that has accepted a handshake.

    A worker that is started again under the same address has not.

    Args:
        identity: Identity of the handshake.
        jobs: Functions, each with its job.
    """
    if identity not in _accepted:
        return Outcome(False)
    began = time.perf_counter()
    try:
        results = [function(job) for function, job in jobs]
    except OSError as error:
        name = platform.node()
        found = f"worker on {name}: found {error}, expected a worker that can compute its jobs"
        return Outcome(True, error=InputError(found))
    except Exception as error:
        return Outcome(True, error=error)
    return Outcome(True, results, time.perf_counter() - began)
