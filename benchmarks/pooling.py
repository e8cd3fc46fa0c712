"""Pooled records of one wheel: share of further records inside their prediction intervals.

    python benchmarks/pooling.py [--wheels 1000] [--records 12,5,3] [--errors 0.3,1,3]
        [--case inside,outside,...] [--trend 0,1] [--oil unknown,known] [--simulated]
        [--seed 90000]

Each virtual wheel has n records, and a further one that is predicted. True parameters of a record:
viscous friction by Walther's equation with the viscosities of an oil and a power of 0.5 to 1,
Coulomb and static torque and motor constant on lines in temperature, a trend over the date (--trend
1: up to 25 % per year of the friction; 0: none), and a scatter between records (2 to 12 % of the
friction, 0.05 to 0.4 % of the motor constant). Estimates have errors with the correlation and the
relative standard deviations of identifications of 300 s at 10 Hz, times --errors, and by a factor
of 1.35 different between records. The first n records are at 5 to 35 °C over two years, the further
one 1 to 4 months later.

Cases: inside, 5 to 35 °C; outside, 5 to 20 °C beyond; one-temperature, all records at 20 °C and the
further one 5 to 20 °C away; and where the model is wrong: eddy, a third of the viscous friction
does not depend on temperature; running-in, dry friction falls by up to 40 % with a time constant of
0.3 years; heavy-tails, scatter by Student's t with 5 degrees of freedom.

Printed for each parameter: share of the 95 % intervals that hold the true parameter of the further
record, and its estimate; the share with scatter and shape as if they were known (plug-in); median
width of the interval over 3.92 times the sigma of the errors (from their quartiles); for viscous
friction the mean log score of the further record by the law, a line and a parabola. With
--simulated, records are simulated and identified. Seeds below 90000 served development.
"""

import argparse
import time
from dataclasses import dataclass, replace

import numpy as np

from gyrostat.identification.pool.analysis import relative_estimates
from gyrostat.identification.pool.laws import Polynomial
from gyrostat.identification.pool.oil import Walther
from gyrostat.identification.pool.posterior import Posterior, posterior
from gyrostat.identification.pool.result import Conditions
from gyrostat.identification.pool.usual import POLYNOMIAL

KINDS = (
    ("motor_constant", "N·m/A"),
    ("viscous", "N·m·s/rad"),
    ("coulomb", "N·m"),
    ("static", "N·m"),
)
TYPICAL = np.array([0.0228, 4.83e-6, 0.8795e-3, 0.9055e-3])
SIGMA = np.array([0.0009, 0.034, 0.0048, 0.085])
"""Relative standard deviations of the errors of one record."""
CORRELATION = np.array(
    [
        [1.0, -0.1, 0.45, 0.15],
        [-0.1, 1.0, -0.88, 0.45],
        [0.45, -0.88, 1.0, -0.35],
        [0.15, 0.45, -0.35, 1.0],
    ]
)
HALF = 0.025


@dataclass(frozen=True)
class Truth:
    """True parameters of n + 1 records of a wheel.

    Attributes:
        temperature: Temperatures, (n + 1,), °C.
        years: Dates, (n + 1,), years.
        values: Parameters, (n + 1, 4), SI.
        oil: Oil.
    """

    temperature: np.ndarray
    years: np.ndarray
    values: np.ndarray
    oil: Walther


def draw(random: np.random.Generator, count: int, case: str, trend: float) -> Truth:
    """Draw a wheel and its records."""
    temperature = random.uniform(5.0, 35.0, count + 1)
    years = np.append(np.sort(random.uniform(0.0, 2.0, count)), 0.0)
    years[-1] = years[-2] + random.uniform(1.0, 4.0) / 12.0
    away = random.uniform(5.0, 20.0)
    if "outside" in case:
        temperature[-1] = 35.0 + away if random.random() < 0.5 else 5.0 - away
    if "one-temperature" in case:
        temperature[:] = 20.0
        temperature[-1] += away if random.random() < 0.5 else -away
    thick = np.exp(random.uniform(np.log(25.0), np.log(300.0)))
    oil = Walther((40.0, 100.0), (thick, thick * np.exp(random.uniform(np.log(0.1), np.log(0.3)))))
    shape = np.exp(random.uniform(0.5, 1.0) * oil.log_ratio(temperature, 20.0))
    if "eddy" in case:
        shape = 0.67 * shape + 0.33
    warm = temperature - 20.0
    slopes = random.uniform([-0.0015, -0.006, -0.006], [0.0, 0.006, 0.006])
    factors = [1.0 + slope * warm for slope in slopes]
    factors.insert(1, shape)
    rates = trend * random.uniform(-0.25, 0.25, 4) * np.array([0.0, 1.0, 1.0, 1.0])
    scatter = random.uniform([0.0005, 0.02, 0.02, 0.02], [0.004, 0.12, 0.12, 0.12])
    tails = np.sqrt(0.6) * random.standard_t(5, (count + 1, 4))
    score = tails if "heavy-tails" in case else random.standard_normal((count + 1, 4))
    values = np.empty((count + 1, 4))
    for k, factor in enumerate(factors):
        # the scatter is relative: that of viscous friction by the temperature of the bearing
        size = factor if k == 1 else 1.0
        values[:, k] = factor + size * (rates[k] * (years - 1.0) + scatter[k] * score[:, k])
    if "running-in" in case:
        values[:, 2:] += random.uniform(0.1, 0.4) * np.exp(-years / 0.3)[:, None]
    return Truth(temperature, years, TYPICAL * values, oil)


def estimate(
    random: np.random.Generator, truth: Truth, ratio: float
) -> tuple[np.ndarray, np.ndarray]:
    """Estimates of the records, and the standard deviations of their errors, (n + 1, 4)."""
    sizes = np.exp(0.3 * random.standard_normal((len(truth.years), 1)))
    sigma = ratio * SIGMA * np.abs(truth.values) * sizes
    errors = random.standard_normal(sigma.shape) @ np.linalg.cholesky(CORRELATION).T
    return truth.values + sigma * errors, sigma


def identify(
    random: np.random.Generator, truth: Truth, ratio: float
) -> tuple[np.ndarray, np.ndarray]:
    """Estimates from simulated records, with the standard deviations of their identifications."""
    import gyrostat as gs

    rows = []
    for motor_constant, viscous, coulomb, static in truth.values.tolist():
        friction = gs.Stribeck(
            viscous=viscous, coulomb=coulomb, static=max(static, coulomb), stribeck_speed=0.4189
        )
        wheel = gs.Wheel(inertia=1.5e-3, motor_constant=motor_constant, friction=friction)
        record = gs.bench(
            wheel,
            profile="steps",
            duration="300 s",
            speed_sigma=f"{5.0 * ratio} rpm",
            low=0.06,
            high=0.15,
            seed=int(random.integers(2**31)),
        )
        fit = gs.identify(record, inertia=1.5e-3)
        rows.append([[fit.parameters[name], fit.sigma[name]] for name, _ in KINDS])
    estimates = np.array(rows)
    return estimates[:, :, 0], estimates[:, :, 1]


def judge(
    kind: tuple[str, str],
    estimates: tuple[np.ndarray, np.ndarray],
    true: float,
    conditions: Conditions,
    oil: Walther | None,
) -> tuple[list[float], list[float]]:
    """Predict the last record of one parameter from the others.

    Returns:
        Share of the prediction below the true parameter, share below its estimate, share below the
        true parameter with the most likely scatter and shape, width of the interval, and error; and
        for viscous friction the log scores of the laws.
    """
    values, errors = estimates
    item, size = relative_estimates(kind, values[:-1], errors[:-1], conditions, oil)
    place = conditions.temperature, conditions.year - conditions.middle
    value, error = values[-1] / size, errors[-1] / size
    result = posterior(item)
    prediction, record = (result.prediction(*place, error=e) for e in (0.0, error))
    row = [
        prediction.share_below(true / size),
        record.share_below(value),
        plug_in(result).prediction(*place).share_below(true / size),
        prediction.quantile(1.0 - HALF) - prediction.quantile(HALF),
        true / size - prediction.quantile(0.5),
    ]
    if kind[0] != "viscous":
        return row, []
    polynomials = [Polynomial(conditions.reference, POLYNOMIAL[:n]) for n in (1, 2)]
    items = [item, *(replace(item, laws=(law,)) for law in polynomials)]
    predictions = [posterior(each).prediction(*place, error=error) for each in items]
    return row, [each.log_density(value) for each in predictions]


def plug_in(result: Posterior) -> Posterior:
    """Posterior with scatter and shape as if they were known: their most likely values."""
    branch = max(result.branches, key=lambda each: each.log_weight.max())
    k = [int(np.argmax(branch.log_weight))]
    names = ("shape", "scatter", "log_weight", "beta", "covariance")
    point = replace(branch, **{name: getattr(branch, name)[k] for name in names})
    return Posterior(result.estimates, [point])


def measure(
    count: int, ratio: float, case: str, trend: float, oil: str, arguments: argparse.Namespace
) -> None:
    """Print the rows of one setting."""
    began, results = time.process_time(), {name: [] for name, _ in KINDS}
    failed, densities = 0, []
    for number in range(arguments.wheels):
        random = np.random.default_rng([arguments.seed, number])
        truth = draw(random, count, case, trend)
        if arguments.simulated:
            # records have one static torque at least as large as the Coulomb torque
            limited = np.maximum(truth.values[:, 3], truth.values[:, 2])
            truth.values[:, 3] = limited
            try:
                values, errors = identify(random, truth, ratio)
            except ValueError:
                failed += 1
                continue
        else:
            values, errors = estimate(random, truth, ratio)
        conditions = Conditions(
            truth.temperature[:-1], truth.years[:-1], truth.temperature[-1], truth.years[-1]
        )
        known = truth.oil if oil == "known" else None
        for k, (name, _) in enumerate(KINDS):
            estimates = values[:, k], errors[:, k]
            row, scores = judge(KINDS[k], estimates, truth.values[-1, k], conditions, known)
            results[name].append(row)
            densities += [scores] if scores else []
    seconds = (time.process_time() - began) / arguments.wheels
    setting = f"{count:3} {ratio:4} {case:15} {trend:g} {oil:7}"
    for name, rows in results.items():
        table = np.array(rows)
        held = 100.0 * np.mean(np.abs(table[:, :3] - 0.5) < 0.5 - HALF, axis=0)
        spread = np.subtract(*np.quantile(table[:, 4], [0.75, 0.25])) / 1.349
        width = np.median(table[:, 3]) / (3.92 * spread)
        text = f"{setting} {name:14} {held[0]:5.1f} {held[1]:5.1f} {held[2]:5.1f} {width:5.2f}"
        if name == "viscous":
            text += " | log scores " + " ".join(f"{d:.2f}" for d in np.mean(densities, axis=0))
        print(text, flush=True)
    print(
        f"{setting} {failed} not identified, {seconds:.3f} s of processor time a wheel", flush=True
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--wheels", type=int, default=1000)
    parser.add_argument("--records", default="12,5,3")
    parser.add_argument("--errors", default="0.3,1,3")
    parser.add_argument("--seed", type=int, default=90000)
    parser.add_argument("--case", default="inside,outside")
    parser.add_argument("--trend", default="0,1")
    parser.add_argument("--oil", default="unknown,known")
    parser.add_argument("--simulated", action="store_true")
    arguments = parser.parse_args()
    print(
        "records, errors, case, trend, oil, parameter; intervals of 95 % that hold, %: parameter,"
    )
    print("estimate, plug-in; median width / 3.92 sigma; log scores: law, line, parabola")
    for count in map(int, arguments.records.split(",")):
        for ratio in map(float, arguments.errors.split(",")):
            for case in arguments.case.split(","):
                for trend in map(float, arguments.trend.split(",")):
                    for oil in arguments.oil.split(","):
                        measure(count, ratio, case, trend, oil, arguments)


if __name__ == "__main__":
    main()
