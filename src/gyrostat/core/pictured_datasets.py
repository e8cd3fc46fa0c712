"""Datasets of xarray that are drawn, and shown with their picture in a notebook."""

from typing import TYPE_CHECKING, Any

import xarray as xr

from gyrostat.core.handed_down import handed_down

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_Plot: Any = xr.Dataset.plot
SCENARIO, VALUES, WHOLE = "scenario", "values", "whole"
"""Entries of `Dataset.encoding`, which is neither shown nor written: scenario, row of a run, and
sizes and names of a whole dataset."""


class _Picture(_Plot):
    """`plot` of xarray, such as `plot.scatter`, that can be called too."""

    def __call__(self) -> "Figure":
        """Draw the whole dataset; see `gyrostat.core.pictured.Pictured.plot`."""
        return handed_down("picture")(self._ds)


class _Drawn(xr.Dataset):
    """What `Run` and `Runs` have in common."""

    __slots__ = ()

    @property
    def plot(self) -> Any:
        """Draw the dataset by `plot()`; `plot.scatter` and others are those of xarray."""
        return _Picture(self)

    def __str__(self) -> str:
        """Lines of the command line, if the dataset is whole; otherwise as xarray shows it."""
        return handed_down("text_of")(self)

    def _repr_html_(self) -> str:
        """Text and picture, if the dataset is whole, and the dataset as xarray shows it."""
        pictured = handed_down("notebook_html")(self) if is_whole(self) else ""
        return pictured + super()._repr_html_()


def mark_whole(dataset: xr.Dataset) -> None:
    """Record what a whole dataset has, to know a part of it, whose metadata are the same."""
    dataset.encoding = {**dataset.encoding, WHOLE: _extent(dataset)}


def is_whole(dataset: xr.Dataset) -> bool:
    """Whether a dataset has all variables and all places that it had when it was made."""
    return dataset.encoding.get(WHOLE) == _extent(dataset)


def _extent(dataset: xr.Dataset) -> tuple[dict[str, int], set[str]]:
    return {str(k): n for k, n in dataset.sizes.items()}, {str(name) for name in dataset.variables}


class Run(_Drawn):
    """Histories of one run over `time`: a dataset of xarray with a picture."""

    __slots__ = ()


class Runs(_Drawn):
    """Table of the runs of a campaign over `run`: a dataset of xarray with a picture."""

    __slots__ = ()
