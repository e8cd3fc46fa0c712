"""Page of the pooled records of a wheel."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gyrostat.core.types import Vector
from gyrostat.core.units import RPM
from gyrostat.identification import Pool
from gyrostat.identification.fit.friction_torques import friction_torques
from gyrostat.identification.pool.pool_model import pooled_model
from gyrostat.identification.pool.pool_text import laws_text, record_tables, tables
from gyrostat.identification.pool.result import INTERVAL, PooledParameter
from gyrostat.identification.pool.usual import is_viscous
from gyrostat.reports.colours import BAND, MARK, MEASURED, MODEL
from gyrostat.reports.drawing import literal, panels
from gyrostat.reports.figure_charts import figure_charts
from gyrostat.reports.template import render
from gyrostat.wheel.model_file import WheelModel

POINTS = 41
"""Points of a curve."""
HEIGHT = 2.1
"""Height of a row of panels, inches."""
SPEEDS = 4
"""Number of speeds at which the records are drawn on the friction surface."""


def pool_page(pool: Pool, *, command: str) -> str:
    """HTML report of pooled records.

    Args:
        pool: Pooled records.
        command: Command line that produced it.
    """
    surface = friction_surface(pool)
    return render(
        "pool.html",
        pool=pool,
        command=command,
        laws=laws_text(pool),
        surface="" if surface is None else figure_charts(surface, "surface"),
        conditions=figure_charts(over_conditions(pool)),
        tables=tables(pool),
        records=record_tables(pool),
    )


def over_conditions(pool: Pool) -> Figure:
    """Each parameter over temperature and date: records, mean, and 95 % interval of a record."""
    rows = len(pool.parameters)
    with panels(rows, 2, height=HEIGHT * rows, sharex="col", squeeze=False) as (figure, grid):
        for (left, right), parameter in zip(grid, pool.parameters.values(), strict=True):
            _over_temperature(left, pool, parameter)
            _over_date(right, pool, parameter)
            left.set_ylabel(f"{literal(parameter.name)}\n({parameter.unit})")
        grid[-1, 0].set_xlabel("temperature, °C")
        grid[-1, 1].set_xlabel("years since the first record")
        grid[0, 0].set_title("at the mean date", fontsize=9)
        grid[0, 1].set_title("at the mean temperature", fontsize=9)
    return figure


def _over_temperature(axes: Axes, pool: Pool, parameter: PooledParameter) -> None:
    """Parameter over temperature; the trend over the date is taken from the records."""
    conditions = pool.conditions
    if conditions.temperatures is None:
        _unknown(axes, "temperatures are unknown")
        return
    grid = _range(conditions.temperatures, conditions.temperature)
    _curves(axes, parameter, grid, [(float(t), 0.0) for t in grid])
    places = [(float(t), 0.0) for t in conditions.temperatures]
    _records(axes, pool, parameter, conditions.temperatures, places)


def _over_date(axes: Axes, pool: Pool, parameter: PooledParameter) -> None:
    """Parameter over the date; the law over temperature is taken from the records."""
    conditions = pool.conditions
    if conditions.years is None:
        _unknown(axes, "dates are unknown, or all the same")
        return
    reference = conditions.reference or 0.0
    grid = _range(conditions.years, conditions.year)
    _curves(axes, parameter, grid, [(reference, float(t) - conditions.middle) for t in grid])
    places = [(reference, float(date)) for date in parameter.posterior.estimates.date]
    _records(axes, pool, parameter, conditions.years, places)


def _range(values: Vector, further: float) -> Vector:
    """Points over the values and a further one, with a margin."""
    low, high = min(values.min(), further), max(values.max(), further)
    margin = 0.05 * (high - low) or 1.0
    return np.linspace(low - margin, high + margin, POINTS)


def _curves(
    axes: Axes, parameter: PooledParameter, grid: Vector, places: list[tuple[float, float]]
) -> None:
    """Mean, and 95 % interval of the parameter in a further record."""
    size, posterior = parameter.size, parameter.posterior
    predictions = [posterior.prediction(*place) for place in places]
    low, middle, high = (
        [size * each.quantile(share) for each in predictions]
        for share in (INTERVAL[0], 0.5, INTERVAL[1])
    )
    axes.fill_between(grid, low, high, color=BAND, alpha=0.4, lw=0)
    axes.plot(grid, middle, color=MODEL, lw=1.4)


def _records(
    axes: Axes,
    pool: Pool,
    parameter: PooledParameter,
    abscissa: Vector,
    places: list[tuple[float, float]],
) -> None:
    """Estimates of the records, moved along the mean to the conditions of the panel."""
    estimates, posterior = parameter.posterior.estimates, parameter.posterior
    there = [posterior.mean(*place).mean for place in places]
    here = [
        posterior.mean(float(t), float(d)).mean
        for t, d in zip(estimates.temperature, estimates.date, strict=True)
    ]
    if is_viscous(parameter.unit):
        ratio = np.array(there) / np.array(here)
        moved, errors = parameter.values * ratio, parameter.errors * ratio
    else:
        moved = parameter.values + parameter.size * (np.array(there) - np.array(here))
        errors = parameter.errors
    style = {"fmt": "o", "ms": 3.5, "lw": 1.0}
    axes.errorbar(abscissa, moved, 1.96 * errors, color=MEASURED, **style)
    chances = parameter.held_out.chances
    beyond = np.flatnonzero(chances < 0.05) if len(chances) else np.zeros(0, dtype=int)
    axes.plot(abscissa[beyond], moved[beyond], "o", color=MARK, ms=5)
    axes.ticklabel_format(axis="y", scilimits=(-2, 3), useOffset=False)


def _unknown(axes: Axes, why: str) -> None:
    axes.text(0.5, 0.5, why, ha="center", va="center", transform=axes.transAxes, color=MEASURED)
    axes.set_xticks([])
    axes.set_yticks([])


def friction_surface(pool: Pool) -> Figure | None:
    """Friction torque over speed and temperature; circles: torques of the records.

    None if temperatures are unknown, or if the friction model has no viscous friction or is not of
    this package.
    """
    conditions, wheel = pool.conditions, pooled_model(pool)
    viscous = [p for p in pool.parameters.values() if is_viscous(p.unit)]
    if wheel is None or conditions.temperatures is None or not viscous:
        return None
    dry = max(wheel.values.get("coulomb", 0.0), wheel.values.get("coulomb_positive", 0.0))
    top = 1.5 * max(dry, 1e-12) / viscous[0].size  # viscous friction is 1.5 times the dry one
    speed = np.linspace(0.02 * top, top, POINTS)
    warm = _range(conditions.temperatures, conditions.temperature)
    torque = [_torque(wheel, _means(pool, float(t)), speed) for t in warm]
    with panels(height=3.4) as (figure, axes):
        options = {"vmin": 0.0, "vmax": float(np.max(torque)), "cmap": "viridis"}
        image = axes.pcolormesh(speed / RPM, warm, np.array(torque), rasterized=True, **options)
        marks = np.linspace(0.15, 0.9, SPEEDS) * top
        for k, temperature in enumerate(conditions.temperatures):
            values = {name: float(p.values[k]) for name, p in pool.parameters.items()}
            measured = _torque(wheel, values, marks)
            height = np.full(SPEEDS, temperature)
            axes.scatter(marks / RPM, height, c=measured, s=26, edgecolors="w", lw=0.7, **options)
        axes.grid(visible=False)
        axes.set_xlabel("speed, rpm")
        axes.set_ylabel("temperature, °C")
        figure.colorbar(image, ax=axes, label="friction torque, N·m")
    return figure


def _means(pool: Pool, temperature: float) -> dict[str, float]:
    """Means of the parameters at a temperature and the date of the prediction."""
    conditions = pool.conditions
    date = conditions.year - conditions.middle
    return {
        name: p.size * p.posterior.mean(temperature, date).mean
        for name, p in pool.parameters.items()
    }


def _torque(wheel: WheelModel, values: dict[str, float], speed: Vector) -> Vector:
    return friction_torques(wheel.static_friction(), {**wheel.values, **values}, speed).torque
