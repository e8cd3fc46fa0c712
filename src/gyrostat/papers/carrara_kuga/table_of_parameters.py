"""Table 1: rebuilt from eqs. (15) and (16), and what the text says about it."""

from gyrostat.papers.carrara_kuga.printed import (
    CONVERGED,
    DETERMINISTIC,
    INERTIA,
    NAMES,
    START,
    STATISTICAL,
    UNITS,
    Column,
)
from gyrostat.papers.claims import Claim
from gyrostat.papers.reproduction import Part

LAST_DIGIT = (1e-4, 1e-8, 1e-7, 1e-7)
"""Of Table 1, one for each parameter, SI."""
ROUNDING = 0.5 * (1.0 + 1e-9)
"""Last digits that rounding may move a number; c and T_s lie on the half itself."""
SYMBOLS = ("k_m", "b", "c", "T_s")


def table_of_parameters() -> Part:
    """Rebuild Table 1 and judge the prose about it."""
    return Part(
        claims=(
            *_rows("deterministic", DETERMINISTIC, START, count=3),
            *_rows("statistical", STATISTICAL, CONVERGED, count=4),
            _motor_constant_drop(),
            *_coulomb_currents(),
        )
    )


def _rows(title: str, column: Column, vector: tuple[float, ...], *, count: int) -> list[Claim]:
    """Compare the first rows of one column with its vector times J_w."""
    equation, suffix = ("(15)", "_det") if column is DETERMINISTIC else ("(16)", "")
    return [
        Claim(
            id=f"table1.{NAMES[k]}{suffix}",
            quantity=f"{SYMBOLS[k]}, {title} column of Table 1",
            paper=getattr(column, NAMES[k]),
            ours=INERTIA * vector[k],
            unit=UNITS[k],
            tolerance=ROUNDING * LAST_DIGIT[k],
            why=f"Eq. {equation} times J_w; the tolerance is half the last digit of Table 1.",
        )
        for k in range(count)
    ]


def _motor_constant_drop() -> Claim:
    drop = 100.0 * (1.0 - STATISTICAL.motor_constant / DETERMINISTIC.motor_constant)
    return Claim(
        id="table1.motor_constant_drop_percent",
        quantity="statistical motor constant below the deterministic one",
        paper=15.0,
        ours=drop,
        unit="%",
        tolerance=0.5,
        why=f"Table 1 gives {drop:.1f} %, which rounds to 16 and not to the 15 of the text.",
    )


def _coulomb_currents() -> tuple[Claim, Claim]:
    """The current that balances Coulomb friction: what a record shows of c."""
    before, after = (c.coulomb / c.motor_constant for c in (DETERMINISTIC, STATISTICAL))
    return (
        Claim(
            id="coulomb_over_km_A",
            quantity="current that balances Coulomb friction, c / k_m, statistical column",
            ours=after,
            unit="A",
            why="Table 1 implies it; a record shows c only through this ratio.",
        ),
        Claim(
            id="coulomb_over_km_det_A",
            quantity="current that balances Coulomb friction, c / k_m, deterministic column",
            ours=before,
            unit="A",
            why=f"It moved by {100.0 * (after / before - 1.0):.0f} % between the columns although "
            "c itself is printed alike to four digits.",
        ),
    )
