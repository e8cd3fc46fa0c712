"""Labelled histories, their netCDF file, and their conversion to `xarray.Dataset`.

xarray takes a quarter of a second to import, so that only those who ask for a dataset load it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

RUN = "run"
"""Dimension of the runs, and the coordinate with their numbers."""


class Signal(NamedTuple):
    """Labelled array.

    Attributes:
        dimensions: Names of its axes.
        values: The array.
        attributes: Name -> value, such as "units" and "long_name".
    """

    dimensions: tuple[str, ...]
    values: Any
    attributes: Mapping[str, Any] = {}


@dataclass(frozen=True)
class Labelled:
    """Signals with named axes.

    Attributes:
        variables: Signals by name.
        coordinates: Coordinates by name; that of a dimension has its name.
        attributes: Attributes of all together.
    """

    variables: Mapping[str, Signal]
    coordinates: Mapping[str, Signal]
    attributes: Mapping[str, Any] = field(default_factory=dict)

    def arrays(self) -> dict[str, Any]:
        """Arrays by name, of variables and coordinates."""
        every = {**self.variables, **self.coordinates}
        return {name: np.asarray(signal.values) for name, signal in every.items()}

    def of_run(self, number: int) -> "Labelled":
        """Signals of one run, without the dimension of runs.

        Args:
            number: Number of the run, a value of the coordinate `run`.
        """
        index = list(self.coordinates[RUN].values).index(number)

        def select(signals: Mapping[str, Signal]) -> dict[str, Signal]:
            return {
                name: each._replace(dimensions=each.dimensions[1:], values=each.values[index])
                if each.dimensions[:1] == (RUN,)
                else each
                for name, each in signals.items()
            }

        return replace(self, variables=select(self.variables), coordinates=select(self.coordinates))

    def dataset(self) -> "xr.Dataset":
        """The same as a dataset of xarray."""
        import xarray as xr

        return xr.Dataset(dict(self.variables), dict(self.coordinates), dict(self.attributes))

    def write(self, path: Path) -> None:
        """Write one run as a netCDF file, as xarray writes it.

        Args:
            path: File, which must not exist.
        """
        import h5netcdf  # slow to import
        import h5py

        every = {**self.variables, **self.coordinates}
        scalars = " ".join(name for name, each in self.coordinates.items() if not each.dimensions)
        with h5netcdf.File(path, "w") as file:
            file.dimensions = {
                dimension: size
                for each in every.values()
                for dimension, size in zip(each.dimensions, np.shape(each.values), strict=True)
            }
            for name, each in every.items():
                about, values = dict(each.attributes), np.asarray(each.values)
                if name in self.variables:
                    about["coordinates"] = scalars
                if values.dtype == bool:
                    about["dtype"], values = "bool", values.astype(np.int8)
                text = values.dtype.kind == "U"
                variable = file.create_variable(
                    name,
                    each.dimensions,
                    h5py.string_dtype() if text else values.dtype,
                    data=values.astype(object) if text else values,
                    fillvalue=np.nan if values.dtype.kind == "f" else None,
                )
                variable.attrs.update(about)
            file.attrs.update(self.attributes)


def joined(parts: Sequence[Labelled]) -> Labelled:
    """Runs of several parts with the same signals, one after the other."""

    def join(signals: Sequence[Mapping[str, Signal]]) -> dict[str, Signal]:
        return {
            name: each._replace(values=np.concatenate([s[name].values for s in signals]))
            if each.dimensions[:1] == (RUN,)
            else each
            for name, each in signals[0].items()
        }

    return replace(
        parts[0],
        variables=join([part.variables for part in parts]),
        coordinates=join([part.coordinates for part in parts]),
    )
