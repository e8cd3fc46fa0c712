"""Versions of JAX from which C can be generated, and what differs between them.

C is generated from jaxprs. JAX documents neither the parameters of their equations nor which
primitives there are, and changes them from one minor version to the next. Rules read what differs
through this module. JAX itself computes with any version.
"""

import re
from collections.abc import Sequence
from typing import Any, NamedTuple

from jax.extend import core

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax

LOWEST, NEWEST = (0, 10), (0, 12)
"""Lowest and newest minor version that the tests have run with, as pyproject.toml has them."""


class UnsupportedVersionError(InputError):
    """Version of JAX from which C cannot be generated."""


def require_supported() -> None:
    """Check that C can be generated from the jaxprs of the installed JAX.

    Raises:
        UnsupportedVersionError: The version is outside the range from `LOWEST` to `NEWEST`.
    """
    match = re.match(r"(\d+)\.(\d+)", jax.__version__)
    if match is None or not LOWEST <= tuple(map(int, match.groups())) <= NEWEST:
        low, high = (".".join(map(str, version)) for version in (LOWEST, NEWEST))
        raise UnsupportedVersionError(
            f"JAX: found version {jax.__version__}, expected {low} to {high} to generate C: "
            f"pip install 'jax>={low},<{NEWEST[0]}.{NEWEST[1] + 1}'"
        )


class ScanCounts(NamedTuple):
    """Number of operands of a scan of each kind, in their order.

    Attributes:
        constants: Operands that are the same in each pass.
        carries: Operands that one pass hands to the next; the others are read row by row.
    """

    constants: int
    carries: int


def scan_counts(params: dict[str, Any]) -> ScanCounts:
    """Count the operands of a scan.

    Args:
        params: Parameters of the equation: `num_consts` and `num_carry` up to JAX 0.10, then
            `ft_in`, the trees of constants, carries and rows.
    """
    if "ft_in" not in params:
        return ScanCounts(params["num_consts"], params["num_carry"])
    constants, carries, _ = params["ft_in"].unpack()
    return ScanCounts(len(constants.vals), len(carries.vals))


def closed(jaxpr: Any, constants: Sequence[Any]) -> Any:
    """Closed jaxpr of a jaxpr and the values of its constants; from JAX 0.11 on, each is closed."""
    return jaxpr if hasattr(jaxpr, "consts") else core.ClosedJaxpr(jaxpr, constants)
