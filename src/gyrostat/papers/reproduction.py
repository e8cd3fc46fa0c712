"""What a reproduction returns, and how it is shown."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import chain
from typing import Protocol, get_args

from matplotlib.figure import Figure

from gyrostat.papers.claims import Claim, Value, Verdict
from gyrostat.report.figures import svg
from gyrostat.report.page import render
from gyrostat.report.text import aligned, plain

Say = Callable[[str], None]


@dataclass(frozen=True)
class Drawing:
    """A figure of a report.

    Attributes:
        title: heading.
        figure: the figure itself.
        caption: what it shows.
    """

    title: str
    figure: Figure
    caption: str


@dataclass(frozen=True)
class Part:
    """One part of a paper, rebuilt.

    Attributes:
        claims: in the order of the paper.
        drawings: its figures.
        settings: what the paper leaves open and was chosen here, one sentence each.
    """

    claims: tuple[Claim, ...]
    drawings: tuple[Drawing, ...] = ()
    settings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Reproduction:
    """A paper's experiment, rebuilt and judged.

    Attributes:
        paper: name of the paper.
        citation: authors and title.
        parts: of the paper.
        complete: False when `quick` cut it short.

    Raises:
        ValueError: two claims have the same id.
    """

    paper: str
    citation: str
    parts: tuple[Part, ...]
    complete: bool
    claims: tuple[Claim, ...] = field(init=False)

    def __post_init__(self) -> None:
        """Join the claims of the parts."""
        claims = tuple(chain.from_iterable(part.claims for part in self.parts))
        twice = [name for name, n in Counter(c.id for c in claims).items() if n > 1]
        if twice:
            raise ValueError(f"{self.paper}: found the id {twice[0]} twice, expected it once")
        object.__setattr__(self, "claims", claims)

    def to_dict(self) -> dict[str, object]:
        """The content of claims.json."""
        return {"paper": self.paper, "claims": [claim.to_dict() for claim in self.claims]}

    def counts(self) -> dict[Verdict, int]:
        """How often each verdict was reached, every verdict named."""
        found = Counter(claim.verdict for claim in self.claims)
        return {verdict: found[verdict] for verdict in get_args(Verdict)}

    def page(self, *, command: str) -> str:
        """The report as one HTML page.

        Args:
            command: what produced it, to run it again.
        """
        return render(
            "claims.html",
            reproduction=self,
            command=command,
            counts=self.counts(),
            rows=[
                (c, shown(c.paper), shown(c.ours), shown(c.tolerance) if c.tolerance else "")
                for c in self.claims
            ],
            settings=list(chain.from_iterable(part.settings for part in self.parts)),
            drawings=[
                (drawing.title, svg(drawing.figure), drawing.caption)
                for part in self.parts
                for drawing in part.drawings
            ],
        )

    def lines(self) -> list[str]:
        """The claims as a table for a console, and the count of each verdict."""
        rows = [(c.id, shown(c.paper), shown(c.ours), c.unit, c.verdict) for c in self.claims]
        table = aligned(rows, ("claim", "paper", "ours", "unit", "verdict"))
        counts = ", ".join(f"{count} {verdict}" for verdict, count in self.counts().items())
        short = [] if self.complete else ["quick: fewer records than the full reproduction"]
        return [*table, f"{self.paper}: {counts}", *short]


class Reproduce(Protocol):
    """Rebuild a paper's experiment."""

    def __call__(self, *, quick: bool, say: Say) -> Reproduction:
        """Run it.

        Args:
            quick: fewer runs, within two minutes.
            say: called with one line of progress at a time.
        """
        ...


@dataclass(frozen=True)
class Paper:
    """A paper that can be reproduced.

    Attributes:
        name: on the command line and in claims.json.
        reproduce: rebuilds its experiment.
    """

    name: str
    reproduce: Reproduce


def shown(value: Value) -> str:
    """A value as a person reads it; a dash for none."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return plain(value)
