"""CCSDS packets with an XTCE description; the packets are packed here by the standard."""

import struct
import sys

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.telemetry import read_record

HEADER = [
    ("VERSION", 3),
    ("TYPE", 1),
    ("SEC_HDR_FLG", 1),
    ("PKT_APID", 11),
    ("SEQ_FLGS", 2),
    ("SRC_SEQ_CTR", 14),
    ("PKT_LEN", 16),
]
XTCE = """<?xml version="1.0" encoding="UTF-8"?>
<xtce:SpaceSystem xmlns:xtce="http://www.omg.org/space/xtce" name="Wheel"><xtce:TelemetryMetaData>
<xtce:ParameterTypeSet>
{header_types}
{integer_32}
<xtce:IntegerParameterType name="U16" signed="false">
  <xtce:IntegerDataEncoding sizeInBits="16" encoding="unsigned"/></xtce:IntegerParameterType>
<xtce:FloatParameterType name="MILLIAMPERE"><xtce:UnitSet><xtce:Unit>mA</xtce:Unit></xtce:UnitSet>
  <xtce:IntegerDataEncoding sizeInBits="16" encoding="twosComplement"><xtce:DefaultCalibrator>
  <xtce:PolynomialCalibrator><xtce:Term coefficient="0.5" exponent="1"/></xtce:PolynomialCalibrator>
  </xtce:DefaultCalibrator></xtce:IntegerDataEncoding></xtce:FloatParameterType>
<xtce:FloatParameterType name="RPM"><xtce:UnitSet><xtce:Unit>{unit}</xtce:Unit></xtce:UnitSet>
  <xtce:FloatDataEncoding sizeInBits="32"/></xtce:FloatParameterType>
</xtce:ParameterTypeSet>
<xtce:ParameterSet>
{header_parameters}
<xtce:Parameter name="SECONDS" parameterTypeRef="U32"/>
<xtce:Parameter name="SUBSECONDS" parameterTypeRef="U16"/>
<xtce:Parameter name="IQ" parameterTypeRef="MILLIAMPERE"/>
<xtce:Parameter name="N" parameterTypeRef="RPM"/>
</xtce:ParameterSet>
<xtce:ContainerSet>
<xtce:SequenceContainer name="{root}" abstract="true"><xtce:EntryList>
{header_entries}
</xtce:EntryList></xtce:SequenceContainer>
<xtce:SequenceContainer name="WheelPacket"><xtce:EntryList>
<xtce:ParameterRefEntry parameterRef="SECONDS"/><xtce:ParameterRefEntry parameterRef="SUBSECONDS"/>
<xtce:ParameterRefEntry parameterRef="IQ"/><xtce:ParameterRefEntry parameterRef="N"/>
</xtce:EntryList><xtce:BaseContainer containerRef="{root}"><xtce:RestrictionCriteria>
<xtce:Comparison parameterRef="PKT_APID" value="42" useCalibratedValue="false"/>
</xtce:RestrictionCriteria></xtce:BaseContainer></xtce:SequenceContainer>
</xtce:ContainerSet></xtce:TelemetryMetaData></xtce:SpaceSystem>
"""
MAP = """packets = "wheel.xml"
[columns]
time = "SECONDS"
time_fine = "SUBSECONDS"
current = "IQ"
speed = "{speed}"
[units]
time = "s"
time_fine = "s/65536"
"""
TIME = 1_000_000_000.0 + 0.25 * np.arange(6)
CURRENT = np.array([100, -200, 300, 250, 0, 125])
"""mA / 0.5"""
SPEED = np.array([0.0, 60.0, 120.0, -30.0, 15.0, 30.0])
"""rpm"""


def description(unit="rpm", root="CCSDSPacket"):
    integer = (
        '<xtce:IntegerParameterType name="U{0}" signed="false"><xtce:IntegerDataEncoding '
        'sizeInBits="{0}" encoding="unsigned"/></xtce:IntegerParameterType>'
    )
    sizes = sorted({size for _, size in HEADER} - {16})
    return XTCE.format(
        header_types="\n".join(integer.format(size) for size in sizes),
        integer_32=integer.format(32),
        header_parameters="\n".join(
            f'<xtce:Parameter name="{name}" parameterTypeRef="U{size}"/>' for name, size in HEADER
        ),
        header_entries="\n".join(
            f'<xtce:ParameterRefEntry parameterRef="{name}"/>' for name, _ in HEADER
        ),
        unit=unit,
        root=root,
    )


def packet(apid, count, data):
    """Space packet, CCSDS 133.0-B-2: version, type and APID; sequence; length - 1; data."""
    return struct.pack(">HHH", apid, 0xC000 | count, len(data) - 1) + data


def packets():
    content = b""
    for k in range(TIME.size):
        seconds, fine = int(TIME[k]), round(TIME[k] % 1.0 * 65536)
        data = struct.pack(">IHhf", seconds, fine, CURRENT[k], SPEED[k])
        content += packet(42, k, data) + packet(7, k, b"other")
    return content


@pytest.fixture
def files(tmp_path):
    """Paths of packets and of their columns."""

    def write(content=None, speed="N", **changes):
        path, columns = tmp_path / "wheel.ccsds", tmp_path / "wheel.toml"
        path.write_bytes(packets() if content is None else content)
        columns.write_text(MAP.format(speed=speed))
        (tmp_path / "wheel.xml").write_text(description(**changes))
        return path, columns

    return write


@pytest.fixture
def parser():
    pytest.importorskip(
        "space_packet_parser", reason="found no space_packet_parser, of the extra bench"
    )


def refused(path, columns=None):
    with pytest.raises(InputError) as caught:
        read_record(path, columns)
    assert str(caught.value).isprintable(), "one line"
    return str(caught.value).replace(f"{path.parent}/", "")


@pytest.mark.parametrize("root", ["CCSDSPacket", "Telemetry"])
def test_fields_have_their_calibration_units_and_fine_time(files, parser, root):
    record = read_record(*files(root=root))
    np.testing.assert_array_equal(record.time, TIME)
    np.testing.assert_allclose(record.current, 0.5e-3 * CURRENT, rtol=1e-12)
    np.testing.assert_allclose(record.speed, SPEED * np.pi / 30.0, rtol=1e-7)


def test_bad_packets_and_descriptions_are_refused_in_one_line(files, parser, tmp_path):
    assert "expected a column 'M' for speed" in refused(*files(speed="M"))
    assert "column 'APID 42/N': found unit 'furlong'" in refused(*files(unit="furlong"))
    assert "wheel.ccsds: found no packet of the description" in refused(
        *files(packet(7, 0, b"other"))
    )
    assert "found no description of its packets" in refused(files()[0])
    content = packets()
    for size in (3, 9, len(content) - 1):
        path, columns = files(content[:size])
        assert "wheel.ccsds: found damaged or other content" in refused(path, columns)
    path, columns = files(packet(42, 0, b"short"))
    assert "wheel.ccsds: found damaged or other content" in refused(path, columns)
    path, columns = files(b"time_s,current_A,speed_rpm\n0,1,10\n1,1,11\n")
    assert "wheel.ccsds: found " in refused(path, columns)
    path, columns = files()
    for text in ("no XML", "<xml/>", description()[:-200]):
        (tmp_path / "wheel.xml").write_text(text)
        assert "wheel.xml: found " in refused(path, columns)
    (tmp_path / "wheel.xml").unlink()
    assert "wheel.xml: found no such file or directory" in refused(path, columns)


def test_missing_package_is_named_with_its_extra(files, monkeypatch):
    monkeypatch.setitem(sys.modules, "space_packet_parser", None)
    assert "wheel.ccsds: found no space_packet_parser" in refused(*files())
