"""CCSDS space packets with an XTCE description, read by space_packet_parser."""

import warnings
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.extras import missing
from gyrostat.core.toml_file import read_content
from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.channels import Channel, read_channels
from gyrostat.telemetry.fault import damaged, fault, listed, too_many
from gyrostat.telemetry.record_format import RecordFormat, Request

_WANTED = "CCSDS packets that match their description"
_XTCE = "an XTCE description of packets"
_ROOT = "CCSDSPacket"
"""Usual name of the container of all packets."""
_LARGEST = 50_000_000  # bytes of a description


class Ccsds(RecordFormat):
    """Fields of all packets, grouped by application: 'APID 42/FIELD'. Each packet is a sample.

    Packets of applications that the description lacks are omitted.
    """

    suffixes: ClassVar[tuple[str, ...]] = (".ccsds", ".pkts", ".bin")

    @staticmethod
    def read(file: Path, request: Request) -> Measured:
        """See `RecordFormat.read`."""
        try:
            import space_packet_parser  # pyright: ignore[reportMissingImports]
        except ImportError:
            raise missing(str(file), "space_packet_parser", "bench") from None
        if request.packets is None:
            expected = "packets = 'FILE.xml', an XTCE file, in the file of columns"
            raise fault(file, "no description of its packets", expected)
        read_content(request.packets, _XTCE, _LARGEST)
        try:
            with warnings.catch_warnings(action="ignore"):
                definition = space_packet_parser.load_xtce(request.packets)
        except Exception as error:  # lxml and the package raise errors of many classes
            raise damaged(request.packets, _XTCE, error) from None
        root = _root(request.packets, definition)
        packets: dict[int, list[Any]] = {}
        try:
            with file.open("rb") as stream, warnings.catch_warnings():
                # the package only warns of a truncated file, and of packets of another length
                warnings.simplefilter("error", UserWarning)
                for apid, packet in _packets(stream, definition, root):
                    packets.setdefault(apid, []).append(packet)
                    if len(packets[apid]) > request.max_samples:
                        raise too_many(file, request.max_samples)
        except (InputError, OSError):
            raise
        except Exception as error:
            raise damaged(file, _WANTED, error) from None
        if not packets:
            raise fault(file, "no packet of the description", _WANTED)
        return read_channels(file, _channels(packets, definition), request, _WANTED)


def _root(file: Path, definition: Any) -> str:
    """Container of all packets: the usual one, or the only one without a base."""
    bases = [
        name for name, each in definition.containers.items() if each.base_container_name is None
    ]
    if _ROOT in bases:
        return _ROOT
    if len(bases) != 1:
        raise fault(file, f"containers {listed(bases)}", f"one without a base, or {_ROOT}")
    return bases[0]


def _packets(stream: Any, definition: Any, root: str) -> Iterator[tuple[int, Any]]:
    """Application and fields of each packet that the description has."""
    from space_packet_parser import ccsds_generator  # pyright: ignore[reportMissingImports]
    from space_packet_parser.exceptions import (  # pyright: ignore[reportMissingImports]
        UnrecognizedPacketTypeError,
    )

    for content in ccsds_generator(stream):
        try:
            packet = definition.parse_bytes(content, root_container_name=root)
        except UnrecognizedPacketTypeError:
            continue
        yield content.apid, packet


def _channels(packets: dict[int, list[Any]], definition: Any) -> list[Channel]:
    """Fields that all packets of an application have."""
    channels = []
    for apid, samples in packets.items():
        common = set(samples[0]).intersection(*samples)
        for field in samples[0]:
            if field in common:
                unit = definition.parameters[field].parameter_type.unit
                channels.append(
                    Channel(
                        name=f"APID {apid}/{field}",
                        count=len(samples),
                        read=partial(_values, samples, field),
                        unit=unit if isinstance(unit, str) else "",
                        base=apid,
                    )
                )
    return channels


def _values(samples: list[Any], field: str) -> Any:
    """Values of a field, (N,)."""
    first = samples[0][field]
    kinds = (bool, int, float)
    plain = next((kind for kind in kinds if isinstance(first, kind)), type(first))
    return np.array([plain(sample[field]) for sample in samples])
