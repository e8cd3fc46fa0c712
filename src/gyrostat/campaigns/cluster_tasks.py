"""Jobs on the workers of a cluster, the calls that compute them, and the workers."""

import contextlib
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from dataclasses import dataclass, field
from typing import Any


@dataclass(eq=False)
class Task:
    """Job with its future, and the number of workers that ended while they had it."""

    function: Callable[[Any], Any]
    job: Any
    future: Future = field(default_factory=Future)
    losses: int = 0


@dataclass(eq=False)
class Batch:
    """Tasks of one call, and the workers that compute them: address -> call."""

    tasks: list[Task]
    calls: dict[str, Any] = field(default_factory=dict)
    begun: float = 0.0


@dataclass(eq=False)
class Worker:
    """Worker of the cluster, with what it has."""

    threads: int
    is_accepted: bool = False
    refusal: str = ""
    greetings: int = 0
    batches: set[Batch] = field(default_factory=set)


def settle(task: Task, result: Any = None, error: BaseException | None = None) -> None:
    """Set the result of a task, or its error, unless it was cancelled."""
    with contextlib.suppress(InvalidStateError):
        if error is not None:
            task.future.set_exception(error)
        else:
            task.future.set_result(result)
