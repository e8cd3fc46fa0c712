"""HDF5 files, read by h5py."""

from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.channels import Channel, content_of, read_channels
from gyrostat.telemetry.fault import damaged
from gyrostat.telemetry.record_format import RecordFormat, Request

_WANTED = "an HDF5 file"


class Hdf5(RecordFormat):
    """Vectors of all groups, and fields of tables; links to other files are not followed.

    Units are those of the attribute `units` or `unit`.
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
                return read_channels(file, channels, request, _WANTED)
        except InputError:
            raise
        except Exception as error:  # h5py raises errors of many classes on damaged files
            raise damaged(file, _WANTED, error) from None


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

    def read() -> NDArray:
        return np.asarray(data[()]).reshape(-1)

    return [Channel(name, data.size or 0, read, unit_of(data), content=content)]


def unit_of(data: Any) -> str:
    """Unit in the attributes `units` or `unit` of a dataset of h5py; "" without one."""
    unit = data.attrs.get("units", data.attrs.get("unit", ""))
    return unit.decode("utf-8", "replace") if isinstance(unit, bytes) else str(unit)
