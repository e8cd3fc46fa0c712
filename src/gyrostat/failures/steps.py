"""What to do next after an answer."""

from dataclasses import dataclass


@dataclass(frozen=True)
class NextStep:
    """What to do next.

    Attributes:
        why: What the step is for.
        command: Command line to run; empty if there is none.
    """

    why: str
    command: str = ""
