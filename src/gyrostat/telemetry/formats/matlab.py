"""MATLAB files of version 5 to 7.

A parser of our own, because scipy.io.loadmat crashes the process on some damaged files. The format
is described in "MAT-File Format" (MathWorks), chapter 1.
"""

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import BinaryIO, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.channels import Channel, read_channels
from gyrostat.telemetry.fault import damaged, fault
from gyrostat.telemetry.record_format import RecordFormat, Request

_WANTED = "a MATLAB file of version 5 to 7"
_FILE_HEADER = 128  # bytes
_MATRIX, _COMPRESSED = 14, 15  # types of the top-level elements of a file
_STORED = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
}
_NUMBERS = range(6, 16)  # classes of matrices of numbers: double to uint64
_OTHERS = {1: "cell", 2: "struct", 4: "char", 5: "sparse"}
_COMPLEX = 0x0800
_LONGEST_DESCRIPTION = 1024  # bytes for class, shape and name; a name has at most 63 characters


class _DamageError(Exception):
    """The bytes violate the format."""


_VIOLATIONS = (_DamageError, struct.error, zlib.error)


class _Element(NamedTuple):
    """Tagged data element: type, start of its data, size of its data, start of the next element."""

    kind: int
    start: int
    size: int
    after: int


@dataclass(frozen=True)
class _Variable:
    """Variable as described in the file."""

    name: str
    kind: int
    is_complex: bool
    shape: tuple[int, ...]
    data: int
    """Offset of the data in the content, bytes."""
    content: Callable[[int], bytes]
    """Returns the first bytes of the variable's uncompressed content; argument: their number."""


class Matlab(RecordFormat):
    """Vectors of numbers in a file of version 5 to 7."""

    suffixes: ClassVar[tuple[str, ...]] = (".mat",)

    @staticmethod
    def read(file: Path, request: Request) -> Measured:
        """See `RecordFormat.read`."""
        with file.open("rb") as stream:
            order = _byte_order(file, stream.read(_FILE_HEADER))
            try:
                variables = list(_variables(stream, order))
            except _VIOLATIONS as error:
                raise damaged(file, _WANTED, error) from None
            channels = [
                Channel(
                    name=variable.name,
                    count=max(variable.shape, default=0),
                    read=partial(_vector, variable, order),
                    content=_content_if_no_vector(variable),
                )
                for variable in variables
            ]
            return read_channels(file, channels, request, _WANTED)


def _byte_order(file: Path, header: bytes) -> str:
    """Byte order of the file, '<' or '>'. Unsupported versions are refused."""
    order = {b"IM": "<", b"MI": ">"}.get(header[126:])
    version = struct.unpack(f"{order}H", header[124:126])[0] if order else 0
    if version == 0x0100 and order:
        return order
    found = "a MATLAB file of version 7.3 (HDF5)" if version == 0x0200 else "other content"
    raise fault(file, found, f"{_WANTED} (MATLAB: save with '-v7'), or CSV")


def _variables(stream: BinaryIO, order: str) -> Iterator[_Variable]:
    """Describe each variable of a file without reading its data."""
    start = _FILE_HEADER
    end = stream.seek(0, 2)
    while start < end:
        stream.seek(start)
        kind, size = struct.unpack(f"{order}II", stream.read(8))
        if kind not in (_MATRIX, _COMPRESSED) or start + 8 + size > end:
            raise _DamageError(f"element of type {kind} and {size} bytes at byte {start}")
        yield _describe(_content(stream, start, size, kind == _COMPRESSED), order)
        start += 8 + size


def _content(stream: BinaryIO, start: int, size: int, compressed: bool) -> Callable[[int], bytes]:
    """Function that returns the first bytes of a variable, including its tag."""

    def first(count: int) -> bytes:
        stream.seek(start + 8 if compressed else start)
        if not compressed:
            return stream.read(min(count, size + 8))
        # Incompressible data grows when compressed, but by far less than this.
        packed = stream.read(min(size, 2 * count))
        return zlib.decompressobj().decompress(packed, count)

    return first


def _element(content: bytes, start: int, order: str) -> _Element:
    """Read the tag of the element at a position."""
    (kind,) = struct.unpack_from(f"{order}I", content, start)
    if kind >> 16:  # small element: up to four bytes of data are in the tag itself
        return _Element(kind & 0xFFFF, start + 4, kind >> 16, start + 8)
    (size,) = struct.unpack_from(f"{order}I", content, start + 4)
    return _Element(kind, start + 8, size, start + 8 + size + -size % 8)


def _describe(content: Callable[[int], bytes], order: str) -> _Variable:
    """Read class, shape and name from the beginning of a variable."""
    head = content(_LONGEST_DESCRIPTION)
    outer = _element(head, 0, order)
    flags = _element(head, outer.start, order)
    (bits,) = struct.unpack_from(f"{order}I", head, flags.start)
    kind = bits & 0xFF
    if kind not in _NUMBERS and kind not in _OTHERS:
        # Objects have another layout and cannot contain a record.
        return _Variable("", kind, False, (), 0, content)
    shape = _element(head, flags.after, order)
    name = _element(head, shape.after, order)
    if outer.kind != _MATRIX or shape.size > 4 * 32 or name.start + name.size > len(head):
        raise _DamageError("a variable without class, shape and name")
    return _Variable(
        name=head[name.start : name.start + name.size].decode("latin-1"),
        kind=kind,
        is_complex=bool(bits & _COMPLEX),
        shape=struct.unpack_from(f"{order}{shape.size // 4}i", head, shape.start),
        data=name.after,
        content=content,
    )


def _content_if_no_vector(variable: _Variable) -> str:
    """Content of a variable that is not a vector of real numbers; empty for such a vector."""
    kind, shape = variable.kind, variable.shape
    if kind in _NUMBERS and not variable.is_complex and len(shape) == 2 and min(shape) == 1:
        return ""
    description = "complex numbers" if variable.is_complex else _OTHERS.get(kind, "numbers")
    return f"{'x'.join(map(str, shape))} of {description}"


def _vector(variable: _Variable, order: str) -> NDArray[np.float64]:
    """Read the numbers of a vector, (N,); they may be stored in a narrower type."""
    count = max(variable.shape)
    # Ask for a few more bytes than there are, so that zlib checks the checksum.
    content = variable.content(variable.data + 8 + 8 * count + 8)
    data = _element(content, variable.data, order)
    dtype = _STORED.get(data.kind)
    if dtype is None or data.size != count * np.dtype(dtype).itemsize:
        raise _DamageError(f"{data.size} bytes of type {data.kind} for {count} numbers")
    if data.start + data.size > len(content):
        raise _DamageError("data that ends too soon")
    numbers = np.frombuffer(content, np.dtype(f"{order}{dtype}"), count, data.start)
    return numbers.astype(np.float64)
