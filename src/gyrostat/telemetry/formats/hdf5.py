"""HDF5 files, read by h5py."""

from dataclasses import replace
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.channels import Channel, content_of, is_time, read_channels
from gyrostat.telemetry.fault import damaged, fault, shown
from gyrostat.telemetry.record_format import RecordFormat, Request

_WANTED = "an HDF5 file"


class Hdf5(RecordFormat):
    """Vectors of all groups, and fields of tables; links to other files are not followed.

    Units are those of the attribute `units` or `unit`. Vectors are unpacked by attributes of the CF
    conventions (version 1.11, sections 2.5.1 and 8.1): `scale_factor`, `add_offset`, and
    `_FillValue` or `missing_value` where there is none.
    """

    suffixes: ClassVar[tuple[str, ...]] = (".h5", ".hdf5", ".hdf")

    @staticmethod
    def read(file: Path, request: Request) -> Measured:
        """See `RecordFormat.read`."""
        import h5py

        try:
            with h5py.File(file, "r") as source:
                channels: list[Channel] = []

                def visit(name: str, item: Any) -> None:
                    if isinstance(item, h5py.Dataset):
                        channels.extend(_channels(name, item))

                source.visititems(visit)
                return read_channels(file, _with_bases(channels), request, _WANTED)
        except InputError:
            raise
        except Exception as error:  # h5py raises errors of many classes on damaged files
            raise damaged(file, _WANTED, error) from None


def _with_bases(channels: list[Channel]) -> list[Channel]:
    """Channels whose base is the nearest group about them that has a channel of times."""
    timed = {PurePosixPath(each.name).parent for each in channels if is_time(each.name)}

    def base(name: str) -> PurePosixPath | None:
        return next((group for group in PurePosixPath(name).parents if group in timed), None)

    return [replace(each, base=base(each.name)) for each in channels]


def _channels(name: str, data: Any) -> list[Channel]:
    """Vector as a channel, or the fields of a table as channels."""
    if data.dtype.names and data.ndim == 1:
        return [
            Channel(
                f"{name}/{field}",
                data.size,
                lambda field=field: data[field],
                content=content_of(data.dtype[field]),
            )
            for field in data.dtype.names
        ]
    content = content_of(data.dtype)
    if data.size is None or data.size != max(data.shape, default=0):
        content = f"an array of shape {'x'.join(map(str, data.shape or ())) or 'none'}"

    values = partial(_unpacked, data)
    return [Channel(name, data.size or 0, values, unit_of(data), content=content)]


def _unpacked(data: Any) -> NDArray:
    """Values of a vector, (N,), masked where there is none."""
    values = np.asarray(data[()]).reshape(-1)
    missing = [*_attribute(data, "_FillValue"), *_attribute(data, "missing_value")]
    if missing:
        values = np.ma.masked_where(np.isin(values, missing), values)
    for scale in _attribute(data, "scale_factor", most=1):
        values = values * float(scale)
    for offset in _attribute(data, "add_offset", most=1):
        values = values + float(offset)
    return values


def _attribute(data: Any, name: str, most: float = np.inf) -> NDArray:
    """Numbers of an attribute, (N,), not more than `most`; empty without it."""
    numbers = np.atleast_1d(data.attrs.get(name, np.zeros(0)))
    if numbers.dtype.kind not in "iuf" or numbers.size > most:
        found = f"attribute {name} = {shown(str(data.attrs[name]))}"
        raise fault(Path(data.file.filename), found, "a number", column=data.name.lstrip("/"))
    return numbers


def unit_of(data: Any) -> str:
    """Unit in the attributes `units` or `unit` of a dataset of h5py; "" without one."""
    unit = data.attrs.get("units", data.attrs.get("unit", ""))
    return unit.decode("utf-8", "replace") if isinstance(unit, bytes) else str(unit)
