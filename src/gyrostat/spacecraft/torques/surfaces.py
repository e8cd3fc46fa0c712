"""Outer surfaces of a spacecraft as flat facets, for air drag and solar radiation pressure."""

from typing import Annotated, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float
from numpy.typing import ArrayLike

from gyrostat.core.checked import Checked, finite, share, size
from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix
from gyrostat.core.validation import require
from gyrostat.wheel.array import UNIT_TOLERANCE, listed

ABSORBED_TOLERANCE = 1e-9
"""Largest excess of the reflected share of the light over 1, from rounding."""


class Surfaces(Checked):
    """Flat facets, each of which is seen from its outer side only.

    Facets do not shade each other: a face behind a panel receives the full air flow and the full
    light. The light that is neither reflected specularly nor diffusely is absorbed.

    Attributes:
        area: Area of each facet, (facets,), m².
        normal: Outward normal in body axes, unit length, (facets, 3).
        centre: Centre of each facet in body axes, from their origin, (facets, 3), m.
        specular: Share of the light that is reflected as by a mirror, (facets,).
        diffuse: Share of the light that is reflected diffusely, by Lambert's law, (facets,).
    """

    area: Annotated[Float[Array, " facets"], size("facet area", "m²")] = eqx.field(converter=listed)
    normal: Float[Array, "facets 3"] = eqx.field(converter=listed)
    centre: Annotated[Float[Array, "facets 3"], finite("facet centre", "m")] = eqx.field(
        converter=listed
    )
    specular: Annotated[Float[Array, " facets"], share("specular share of a facet")] = eqx.field(
        converter=listed
    )
    diffuse: Annotated[Float[Array, " facets"], share("diffuse share of a facet")] = eqx.field(
        converter=listed
    )

    @classmethod
    def facet(
        cls,
        area: float,
        normal: ArrayLike,
        centre: ArrayLike,
        *,
        specular: float = 0.0,
        diffuse: float = 0.0,
    ) -> Self:
        """Create one facet.

        Args:
            area: Area, m².
            normal: Outward normal in body axes, of any length, (3,).
            centre: Centre in body axes, (3,), m.
            specular: Share of the light that is reflected as by a mirror.
            diffuse: Share of the light that is reflected diffusely.

        Raises:
            InputError: The area is not above 0, or the normal is zero.
        """
        require("facet area", area, "m²", positive=True)
        direction = np.asarray(normal, dtype=float)
        length = np.linalg.norm(direction)
        if not length > 0.0:
            raise InputError(f"facet normal: found {direction}, expected a direction")
        middle = np.asarray(centre, dtype=float)
        shares = (np.array([specular], dtype=float), np.array([diffuse], dtype=float))
        return cls(np.array([area]), (direction / length)[None], middle[None], *shares)

    @classmethod
    def panel(
        cls,
        area: float,
        normal: ArrayLike,
        centre: ArrayLike,
        *,
        specular: float = 0.0,
        diffuse: float = 0.0,
    ) -> Self:
        """Create both sides of a thin panel, such as a solar array; see `facet`."""
        shares = {"specular": specular, "diffuse": diffuse}
        back = -np.asarray(normal, dtype=float)
        return cls.joined(
            cls.facet(area, normal, centre, **shares), cls.facet(area, back, centre, **shares)
        )

    @classmethod
    def box(
        cls,
        size: ArrayLike,
        centre: ArrayLike = (0.0, 0.0, 0.0),
        *,
        specular: float = 0.0,
        diffuse: float = 0.0,
    ) -> Self:
        """Create the six faces of a box with edges along the body axes.

        Args:
            size: Lengths of the edges along x, y and z, (3,), m.
            centre: Centre of the box in body axes, (3,), m.
            specular: Share of the light that is reflected as by a mirror.
            diffuse: Share of the light that is reflected diffusely.

        Raises:
            InputError: A length is not above 0.
        """
        edges, middle = np.asarray(size, dtype=float), np.asarray(centre, dtype=float)
        require("size of the box", edges, "m", positive=True)
        faces = [
            cls.facet(
                float(np.prod(np.delete(edges, axis))),
                side * np.eye(3)[axis],
                middle + 0.5 * side * edges * np.eye(3)[axis],
                specular=specular,
                diffuse=diffuse,
            )
            for axis in range(3)
            for side in (1.0, -1.0)
        ]
        return cls.joined(*faces)

    @classmethod
    def joined(cls, *parts: Self) -> Self:
        """Create the surfaces that consist of all facets of some surfaces, one or more."""
        return cls.of_rows(np.concatenate([part.rows() for part in parts]))

    @classmethod
    def of_rows(cls, rows: Float[Array, "facets 9"] | Matrix) -> Self:
        """Create surfaces from rows of `rows`."""
        return cls(rows[:, 0], rows[:, 1:4], rows[:, 4:7], rows[:, 7], rows[:, 8])

    def rows(self) -> Matrix:
        """Area, normal, centre, specular and diffuse share of each facet, (facets, 9), SI."""
        columns = (self.area, self.normal, self.centre, self.specular, self.diffuse)
        return np.column_stack([np.asarray(column, dtype=float) for column in columns])

    def check_own(self) -> None:
        """Validate shapes, normals and shares of the light.

        Raises:
            InputError: A parameter has another number of facets, a normal is not of unit length, or
                a facet reflects more than all the light.
        """
        count = np.shape(self.area)[-1:]
        shapes = {"normal": (*count, 3), "centre": (*count, 3), "specular": count, "diffuse": count}
        for name, shape in shapes.items():
            found = np.shape(getattr(self, name))[np.ndim(self.area) - 1 :]
            if not count or found != shape:
                raise InputError(f"facet {name}: found shape {found}, expected {shape}")
        lengths = np.linalg.norm(np.asarray(self.normal, dtype=float), axis=-1)
        bad = ~(np.abs(lengths - 1.0) < UNIT_TOLERANCE)
        if np.any(bad):
            raise InputError(
                f"facet normal: found a length of {lengths[bad].flat[0]:g}, expected unit vectors"
            )
        total = np.asarray(self.specular, dtype=float) + np.asarray(self.diffuse, dtype=float)
        if np.any(total > 1.0 + ABSORBED_TOLERANCE):
            raise InputError(
                f"facet specular and diffuse: found shares with the sum {np.max(total):g}, expected"
                " at most 1"
            )
