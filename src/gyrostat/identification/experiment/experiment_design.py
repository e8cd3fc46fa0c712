"""Design of the next record of a wheel: the current that determines wanted parameters best.

Optimal experiment design (Pukelsheim, "Optimal design of experiments", 2006): c-optimal for one
linear combination of parameters, D-optimal for several. The criterion is that of the ninth decile
over wheels drawn from the earlier estimates, so that the profile also serves a wheel that differs
from the estimate: a ramp must reach a breakaway torque that is not known yet.
"""

from collections.abc import Callable, Sequence

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.validation import check_seed, require
from gyrostat.identification.experiment.current_profiles import COORDINATES, FAMILIES, Limits, Shape
from gyrostat.identification.experiment.design import Combination, Design
from gyrostat.identification.experiment.design_text import CLEAR
from gyrostat.identification.experiment.known_wheel import KnownWheel
from gyrostat.identification.experiment.record_information import (
    Gained,
    checkpoints,
    information_gained,
)
from gyrostat.identification.fit.prediction import build_wheel
from gyrostat.identification.uncertainty.sigmas import square_root
from gyrostat.wheel.friction import static_curve

SEARCH_WHEELS, FINAL_WHEELS = 16, 128
"""Number of wheels drawn in the search and for the predicted uncertainty."""
FIRST, ROUNDS, EACH, ELITE = 32, 8, 24, 6
"""Shapes of each family tried first; rounds of refinement, shapes in each round, and how many of
the best ones it starts from."""
WIDEST, NARROWEST = 0.25, 0.03
"""Standard deviation of the change of a coordinate in the first and in the last round."""
MOST_SAMPLES = 1200
"""Largest number of samples in the search; a longer record is thinned, its information kept."""
RELIABLE = 0.9
"""Fraction of the wheels drawn that reach the stated uncertainty."""
INFEASIBLE = 1e6


def breakaway_current(known: KnownWheel) -> float:
    """Current at which the estimated wheel breaks away from rest, A."""
    wheel = build_wheel(known.model, known.values)
    curve = static_curve(wheel.friction)
    torque = max(float(curve.breakaway_torque(sense)) for sense in (1.0, -1.0))
    if not torque > 0.0:
        raise InputError("design: found a wheel without dry friction, expected a breakaway torque")
    return torque / abs(float(wheel.motor_constant))


class _Search:
    """Candidates and their score; smaller is better."""

    def __init__(
        self,
        wheel: KnownWheel,
        contrasts: Matrix,
        targets: Vector | None,
        limits: Limits,
        speed_sigma: float,
        ripple: float,
        random: np.random.Generator,
    ) -> None:
        self.wheel, self.contrasts, self.targets, self.limits = wheel, contrasts, targets, limits
        self.random = random
        every = list(wheel.values)
        self.places = [every.index(n) for n in wheel.names]
        self.root = square_root(wheel.covariance)
        self.before = contrasts.T @ wheel.covariance @ contrasts
        if np.any(np.diag(self.before) <= 0.0):
            raise InputError("design: found a parameter that is known exactly, expected another")
        self.breakaway = breakaway_current(wheel)
        full = limits.time()
        self.stride = -(-len(full) // MOST_SAMPLES)
        self.time = full[:: self.stride]
        self.noise = speed_sigma / np.sqrt(self.stride)
        self.ripple = ripple
        estimate = wheel.nearest_possible(np.array([list(wheel.values.values())]))
        self.wheels = np.vstack([estimate, wheel.draws(FINAL_WHEELS - 1, random, ripple)])

    def at_rest(self, columns: Matrix) -> Vector:
        """Coefficients of the torques that act at rest alone in combinations (n, c), (c,)."""
        names = self.wheel.names
        places = [names.index(n) for n in self.wheel.model.vanishing_at if n in names]
        return columns[places].sum(axis=0)

    def current(self, shape: Shape, time: Vector) -> Vector:
        """Current of a shape within the limits, (N,), A."""
        profile = shape.current(time, self.limits, self.breakaway)
        return self.limits.apply(profile, time[1] - time[0])

    def uncertainty(self, currents: Matrix, wheels: Matrix) -> Gained:
        """Uncertainty after each current on each wheel."""
        return information_gained(
            self.wheel.model,
            wheels,
            currents,
            self.time,
            places=self.places,
            root=self.root,
            speed_sigma=self.noise,
            initial_speed=self.limits.initial_speed,
            effects=self.wheel.effects(self.ripple),
        )

    def scores(self, shapes: Sequence[Shape], wheels: Matrix) -> Vector:
        """Score of each shape on some wheels.

        Without a target it is the logarithm of the D-criterion at the end; with targets the same
        relative to the targets where they are not reached, and a negative number that grows with
        the time where they are.
        """
        currents = np.array([self.current(shape, self.time) for shape in shapes])
        uncertainty = self.uncertainty(currents, wheels)
        covariance = self.contrasts.T @ uncertainty.covariance @ self.contrasts
        variance = np.diagonal(covariance, axis1=-2, axis2=-1)
        if self.targets is None:
            scale = np.sqrt(np.diag(self.before))
            unit = covariance[:, :, -1] / np.outer(scale, scale)
            logarithm = np.linalg.slogdet(unit)[1] / (2.0 * len(scale))
            score = np.quantile(logarithm, RELIABLE, axis=1)
        else:
            excess = np.max(0.5 * np.log(variance) - np.log(self.targets), axis=-1)
            excess = np.quantile(excess, RELIABLE, axis=1)
            first = np.argmax(excess <= 0.0, axis=1)
            early = checkpoints(self.time)[first] / self.limits.duration - 1.0
            score = np.where(np.any(excess <= 0.0, axis=1), early - 1.0, excess[:, -1])
        fastest = np.nan_to_num(np.max(np.abs(uncertainty.speed), axis=(1, 2)), nan=np.inf)
        wrong = (fastest > self.limits.speed) | ~np.all(uncertainty.resolved, axis=1)
        return np.where(wrong, INFEASIBLE + fastest, score)

    def run(self, say: Callable[[str], None]) -> tuple[Shape, int]:
        """Best shape, and the number tried."""
        shapes = [
            Shape(family, row)
            for family in FAMILIES
            for row in self.random.random((FIRST, COORDINATES))
        ]
        subset = self.wheels[:SEARCH_WHEELS]
        scores = self.scores(shapes, subset)
        for turn in range(ROUNDS):
            order = np.argsort(scores, kind="stable")[:ELITE]
            say(f"  round {turn + 1} of {ROUNDS}: best {shapes[order[0]].family}")
            spread = WIDEST * (NARROWEST / WIDEST) ** (turn / (ROUNDS - 1))
            parents = [shapes[order[k % len(order)]] for k in range(EACH)]
            steps = spread * self.random.standard_normal((EACH, COORDINATES))
            # reflect at the ends of the range, which are then tried no more often than the inside
            points = 1.0 - np.abs(1.0 - np.abs(np.array([p.coordinates for p in parents]) + steps))
            rows = np.clip(points, 0.0, 1.0)
            new = [Shape(p.family, row) for p, row in zip(parents, rows, strict=True)]
            shapes += new
            scores = np.concatenate([scores, self.scores(new, subset)])
        order = [k for k in np.argsort(scores, kind="stable") if scores[k] < INFEASIBLE]
        for first in range(0, len(order), ELITE):
            best = [shapes[k] for k in order[first : first + ELITE]]
            # few wheels may miss the one that a profile fails
            final_scores = self.scores(best, self.wheels)
            if final_scores.min() < INFEASIBLE:
                return best[int(np.argmin(final_scores))], len(shapes)
        raise InputError(
            f"max speed: found {self.limits.speed:g} rad/s, expected more: every profile tried "
            "exceeds it"
        )


def design_record(
    known: KnownWheel,
    wanted: Sequence[str],
    limits: Limits,
    *,
    speed_sigma: float,
    targets: Sequence[float] = (),
    ripple: float | None = None,
    seed: int = 0,
    say: Callable[[str], None] = lambda line: None,
) -> Design:
    """Design the record that determines wanted parameters best, or soonest.

    Args:
        known: Estimated wheel with the covariance of its errors.
        wanted: Parameters or linear combinations, such as "static-coulomb".
        limits: Limits of driver, wheel and record.
        speed_sigma: Standard deviation of the measured speed at each sample, rad/s.
        targets: Wanted standard deviation of each combination, SI; empty: as small as possible at
            the end of the record.
        ripple: Torque ripple, rms over the dry friction torque; None: that of the fit.
        seed: Seed of the search.
        say: Function that receives progress.

    Returns:
        The design; it ends as soon as nine of ten wheels reach the targets.

    Raises:
        InputError: A name, number or limit cannot be used, or no profile keeps to the limits.
    """
    require("speed sigma", speed_sigma, "rad/s", positive=True)
    share = known.ripple if ripple is None else ripple
    require("ripple", share)
    for target in targets:
        require("target sigma", target, positive=True)
    if targets and len(targets) != len(wanted):
        raise InputError(
            f"target sigma: found {len(targets)} values, expected {len(wanted)}, one for each "
            "wanted parameter"
        )
    check_seed(seed)
    torque = share * known.dry_torque()
    contrast = np.column_stack([known.contrast(text, "design") for text in wanted])
    goals = np.array(targets, dtype=float) if len(targets) else None
    random = np.random.default_rng(seed)
    search = _Search(known, contrast, goals, limits, speed_sigma, torque, random)
    shape, count = search.run(say)
    return _conclude(search, shape, count, wanted, speed_sigma)


def _conclude(
    search: _Search, shape: Shape, candidates: int, combinations: Sequence[str], speed_sigma: float
) -> Design:
    """Predict the uncertainty of the chosen profile over all wheels drawn, and cut it."""
    wheel, goals, count = search.wheel, search.targets, len(combinations)
    current = search.current(shape, search.time)[None]
    columns = np.column_stack([search.contrasts, np.eye(len(wheel.names))])
    uncertainty = search.uncertainty(current, search.wheels)
    covariance = (columns.T @ uncertainty.covariance @ columns)[0]
    sigma = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))  # (wheels, times, all)
    reliable = np.quantile(sigma, RELIABLE, axis=0)
    times, last, reach_time = checkpoints(search.time), len(reliable) - 1, None
    if goals is not None:
        is_met = np.all(reliable[:, :count] <= goals, axis=1)
        if is_met.any():
            last = int(np.argmax(is_met))
            reach_time = float(times[last])
    time = search.limits.time()
    time = time[time <= times[last] + 1e-9]
    values = np.array([wheel.values[n] for n in wheel.names])
    draws = search.wheels[:, search.places]
    prior = np.sqrt(np.diag(columns.T @ wheel.covariance @ columns))
    rows = []
    for k, name in enumerate([*combinations, *wheel.names]):
        after = sigma[:, last, k]
        rows.append(
            Combination(
                name=name,
                dimension=wheel.dimension(name, "design"),
                value=float(columns[:, k] @ values),
                before=float(prior[k]),
                after=float(np.median(after)),
                reliable=float(reliable[last, k]),
                target=float(goals[k]) if goals is not None and k < count else None,
                clear=float(np.mean(np.abs(draws @ columns[:, k]) > CLEAR * after))
                if k < count
                else None,
            )
        )
    breakaways, at_rest = None, search.at_rest(search.contrasts)
    if goals is not None and np.any(search.ripple * at_rest):
        breakaways = int(np.ceil(np.max((search.ripple * at_rest / goals) ** 2)))
    return Design(
        shape=shape,
        numbers=shape.numbers(search.limits, search.breakaway),
        time=time,
        current=search.current(shape, search.limits.time())[: len(time)],
        speed=np.interp(time, search.time, uncertainty.speed[0, 0]),
        wanted=tuple(rows[:count]),
        parameters=tuple(rows[count:]),
        reached=reach_time,
        history=(times[: last + 1], reliable[: last + 1, 0]),
        events=float(np.median(uncertainty.events[0, :, last])),
        angles=float(np.median(uncertainty.angles[0, :, last])),
        ripple=search.ripple,
        needed=breakaways,
        at_rest=bool(np.any(at_rest)),
        limits=search.limits,
        speed_sigma=speed_sigma,
        candidates=candidates,
    )
