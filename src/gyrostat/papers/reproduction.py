"""Engine of the reproductions: runs the experiments of a paper, judges its claims, reports them."""

import tomllib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from itertools import chain
from typing import Any, Self, get_args

from matplotlib.figure import Figure

from gyrostat.campaigns.executors import Opener
from gyrostat.campaigns.mapped import mapped
from gyrostat.core.messages import silent
from gyrostat.core.text import aligned, plain
from gyrostat.papers.claims import LEFT_OUT, Claim, Row, Value, Verdict
from gyrostat.papers.figures import Drawing
from gyrostat.reports.figure_charts import figure_charts
from gyrostat.reports.pictures import text_and_picture
from gyrostat.reports.template import render

Say = Callable[[str], None]


@dataclass(frozen=True)
class Part:
    """Result of one experiment.

    Attributes:
        values: Computed values by claim id.
        facts: Values of the replacement fields in the rows of these claims.
        drawings: Figures.
    """

    values: Mapping[str, Value]
    facts: Mapping[str, Any] = field(default_factory=dict)
    drawings: tuple[Drawing, ...] = ()


@dataclass(frozen=True)
class Run:
    """One execution of a paper's experiments, with simulations shared between them.

    Attributes:
        quick: Whether to shorten it: fewer records and seeds, no dispersed runs.
        say: Called with one line of progress at a time.
    """

    quick: bool
    say: Say
    _shared: dict[Any, Any] = field(default_factory=dict)

    def once(self, function: "Callable[[Run], Any]") -> Any:
        """Call a function with this run once and return the same result in later calls."""
        if function not in self._shared:
            self._shared[function] = function(self)
        return self._shared[function]


Experiment = Callable[[Run], Part]


@dataclass(frozen=True)
class Reproduction:
    """Experiments of a paper with all claims judged.

    Attributes:
        paper: Paper that was reproduced.
        claims: Claims in the order of the paper.
        drawings: Figures.
        complete: False if `quick` shortened the reproduction.
    """

    paper: "Paper"
    claims: tuple[Claim, ...]
    drawings: tuple[Drawing, ...]
    complete: bool

    def __str__(self) -> str:
        """Lines of the command line."""
        return "\n".join(self.lines())

    def plot(self) -> Figure:
        """First figure; `drawings` has all of them, each with its `figure` to edit."""
        return self.drawings[0].figure

    def _repr_html_(self) -> str:
        """Claims and first figure, for a notebook."""
        return text_and_picture(str(self), self.plot(), self.paper.name)

    def to_dict(self) -> dict[str, object]:
        """Content of claims.json."""
        rows = [claim.to_dict() for claim in self.claims]
        return {"paper": self.paper.name, "claims": rows}

    def counts(self) -> dict[Verdict, int]:
        """Number of claims with each verdict, including verdicts without claims."""
        counter = Counter(claim.verdict for claim in self.claims)
        return {verdict: counter[verdict] for verdict in get_args(Verdict)}

    def shown_counts(self) -> dict[str, int]:
        """Number of claims with each verdict as it is shown, without verdicts of no claim."""
        counter = Counter(claim.shown_verdict for claim in self.claims)
        return {name: counter[name] for name in (*get_args(Verdict), LEFT_OUT) if counter[name]}

    def page(self, *, command: str) -> str:
        """HTML report.

        Args:
            command: Command line that produced it.
        """
        return render(
            "claims.html",
            paper=self.paper,
            complete=self.complete,
            command=command,
            counts=self.shown_counts(),
            rows=[
                (c, shown(c.paper), shown(c.ours), shown(c.tolerance) if c.tolerance else "")
                for c in self.claims
            ],
            drawings=[
                (d.title, figure_charts(d.figure, f"figure{k}_"), d.caption)
                for k, d in enumerate(self.drawings)
            ],
        )

    def lines(self) -> list[str]:
        """Table of the claims for a terminal, and the count of each verdict."""
        rows = [(c.id, shown(c.paper), shown(c.ours), c.unit, c.shown_verdict) for c in self.claims]
        table = aligned(rows, ("claim", "paper", "ours", "unit", "verdict"))
        counts = ", ".join(f"{count} {verdict}" for verdict, count in self.shown_counts().items())
        short = [] if self.complete else ["quick: fewer records than the full reproduction"]
        return [*table, f"{self.paper.name}: {counts}", *short]


@dataclass(frozen=True)
class Paper:
    """A paper that can be reproduced: the content of its claims.toml, and its experiments.

    Attributes:
        name: Name on the command line and in claims.json.
        citation: Authors and title.
        settings: Settings that the paper leaves open and were chosen here, one sentence each.
        rows: Claims in the order of the paper.
        experiments: Functions that compute values, facts and figures, in the order of the figures.
        full: Further experiments of the full reproduction only.

    Raises:
        ValueError: Two rows have the same id.
    """

    name: str
    citation: str
    settings: tuple[str, ...]
    rows: tuple[Row, ...]
    experiments: tuple[Experiment, ...]
    full: tuple[Experiment, ...] = ()

    def __post_init__(self) -> None:
        """Check that ids are unique."""
        for name, count in Counter(row.id for row in self.rows).items():
            if count > 1:
                raise ValueError(f"{self.name}: found the id {name} {count} times, expected once")

    @classmethod
    def of(cls, package: str, *experiments: Experiment, full: tuple[Experiment, ...] = ()) -> Self:
        """Create a paper from the claims.toml of a package.

        Args:
            package: Name of the package, such as "gyrostat.papers.carrara_kuga".
            experiments: See the attributes of the class.
            full: See the attributes of the class.
        """
        table = tomllib.loads(files(package).joinpath("claims.toml").read_text(encoding="utf-8"))
        rows = tuple(Row(**row) for row in table["claim"])
        settings = tuple(table["settings"])
        return cls(table["name"], table["citation"], settings, rows, experiments, full)

    def reproduce(self, *, quick: bool, say: Say, opener: Opener | None = None) -> Reproduction:
        """Run the experiments and judge each claim.

        Args:
            quick: Whether to use fewer records and seeds and no dispersed runs; takes less than two
                minutes.
            say: Called with one line of progress at a time.
            opener: Opens an executor, each of whose jobs is an experiment, without progress; None
                for this process.
        """
        experiments = self.experiments if quick else self.experiments + self.full
        if opener is None:
            run = Run(quick, lambda text: say(f"{self.name}: {text}"))
            return self.judged([experiment(run) for experiment in experiments], quick=quick)
        jobs = [(experiment, quick) for experiment in experiments]
        return self.judged(mapped(_part, jobs, opener), quick=quick)

    def judged(self, parts: Sequence[Part], *, quick: bool = False) -> Reproduction:
        """Judge the claims by the results of the experiments.

        Args:
            parts: Results of the experiments.
            quick: Whether the experiments were shortened.

        Raises:
            ValueError: A claim has no value, or a value has no claim.
        """
        values = {name: value for part in parts for name, value in part.values.items()}
        facts = {name: fact for part in parts for name, fact in part.facts.items()}
        computed = {row.id for row in self.rows if row.testable and not (quick and row.full)}
        if odd := sorted(computed ^ set(values)):
            problem = "no value" if odd[0] in computed else "a value without a row"
            raise ValueError(f"{self.name}: found {problem} of {odd[0]}")
        claims = tuple(
            row.claim(values.get(row.id), facts, computed=not (quick and row.full))
            for row in self.rows
        )
        drawings = tuple(chain.from_iterable(part.drawings for part in parts))
        return Reproduction(self, claims, drawings, complete=not quick)


@cache
def _run(quick: bool) -> Run:
    return Run(quick, silent)


def _part(job: tuple[Experiment, bool]) -> Part:
    """Result of an experiment in a worker, which shares simulations with its other experiments."""
    experiment, quick = job
    return experiment(_run(quick))


def shown(value: Value) -> str:
    """Format a value for a reader; a dash if there is none."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return plain(value)
