"""Later calls: telemetry that was corrected, came late or in few rows, and damaged states."""

import os
from dataclasses import replace

import pytest

import gyrostat
from gyrostat.core.errors import InputError
from gyrostat.monitoring import state as monitor_state
from tests.monitoring.test_stream import assert_same, flight, folder

__all__ = ["flight", "folder"]


def options(folder, out):
    return {"out": folder / out, "wheels": folder / "wheels.toml", "window": "6 h"}


@pytest.mark.parametrize("place", [0.1, 0.9])
def test_a_file_that_was_corrected_is_not_taken_for_the_one_before(folder, place):
    """In its first bytes it is another file, all late; behind them it has other rows."""
    lines = (folder / "two.csv").read_text().splitlines()
    row = int(place * 20000)
    wrong = [*lines[:row], lines[row].replace(lines[row].split(",")[2], "9.0"), *lines[row + 1 :]]
    (folder / "two.csv").write_text("\n".join(wrong))
    gyrostat.monitor(folder / "two.csv", **options(folder, "out"))
    state = (folder / "out" / "monitor.state").read_bytes()
    (folder / "two.csv").write_text("\n".join(lines))
    if place < 0.5:
        health = gyrostat.monitor(folder / "two.csv", **options(folder, "out"))
        assert any(note.startswith("all times of two.csv (2) had been") for note in health.notes)
    else:
        with pytest.raises(InputError, match=r"two.csv: found other values up to row 2\d+ than"):
            gyrostat.monitor(folder / "two.csv", **options(folder, "out"))
        assert (folder / "out" / "monitor.state").read_bytes() == state
    fresh = gyrostat.monitor(folder / "two.csv", wheels=folder / "wheels.toml", window="6 h")
    again = gyrostat.monitor(folder / "two.csv", **options(folder, "out"), restart=True)
    assert_same(fresh.windows, again.windows)


def test_a_checksum_notices_values_that_are_exchanged(flight):
    part = flight.part(slice(0, 100))
    first, rest = part.part(slice(0, 30)), part.part(slice(30, None))
    assert part.checksum() == (first.checksum() + rest.checksum()) % 2**64
    columns = replace(part, speed=part.drive, drive=part.speed)
    rows = replace(part, drive=part.drive[::-1])
    assert len({each.checksum() for each in (part, columns, rows)}) == 3


def test_a_few_rows_alone_are_no_telemetry_yet(folder):
    lines = (folder / "two.csv").read_text().splitlines()
    (folder / "two.csv").write_text("\n".join(lines[:6]))
    health = gyrostat.monitor(folder / "two.csv", **options(folder, "out"))
    assert health.notes[0].startswith("no window yet: no sample has a time that others confirm")


def test_a_copied_file_is_read_again_and_was_used_before(folder):
    said = []
    gyrostat.monitor(folder / "one.parquet", **options(folder, "out"))
    os.utime(folder / "one.parquet", (1.0, 1.0))
    health = gyrostat.monitor(folder / "one.parquet", **options(folder, "out"), say=said.append)
    assert said[0].endswith("one.parquet: left out, it was used before")
    assert health.telemetry["repeats"] == 0


def test_a_day_that_came_late_is_told(folder):
    gyrostat.monitor(folder / "two.csv", **options(folder, "out"))
    health = gyrostat.monitor(folder / "one.parquet", **options(folder, "out"))
    assert health.notes[0].startswith("all times of one.parquet had been reached")


def test_files_and_additions_of_a_few_rows_are_used(folder):
    """Fewer than ten rows confirm no jump, but they go on where the telemetry ended."""
    lines = (folder / "two.csv").read_text().splitlines()
    (folder / "two.csv").write_text("\n".join(lines[:3001]) + "\n")
    whole = gyrostat.monitor(folder / "two.csv", **options(folder, "whole"))
    for end in (2000, 2001, 2006, 3001):
        (folder / "two.csv").write_text("\n".join(lines[:end]) + "\n")
        grown = gyrostat.monitor(folder / "two.csv", **options(folder, "grown"))
    for k, (start, end) in enumerate([(1, 2000), (2000, 2001), (2001, 2008), (2008, 3001)]):
        (folder / f"part{k}.csv").write_text("\n".join([lines[0], *lines[start:end]]) + "\n")
        parts = gyrostat.monitor(folder / f"part{k}.csv", **options(folder, "parts"))
    for other in (grown, parts):
        assert_same(whole.windows, other.windows)
        assert other.telemetry["wild_times"] == 0


@pytest.mark.parametrize("size", [0, 100, 3000])
def test_a_damaged_state_is_refused_in_one_line(folder, size):
    gyrostat.monitor(folder / "one.parquet", **options(folder, "out"))
    state = folder / "out" / "monitor.state"
    state.write_bytes(state.read_bytes()[:size])
    with pytest.raises(InputError, match=r"found a damaged or other file, .*restart") as caught:
        gyrostat.monitor(folder / "one.parquet", **options(folder, "out"))
    assert "\n" not in str(caught.value)


def test_a_state_without_a_column_of_today_is_that_of_another_version(folder, monkeypatch):
    before = [name for name in monitor_state._FORMAT if name != "drive_noise"]
    assert len(before) < len(monitor_state._FORMAT)
    with monkeypatch.context() as patch:
        patch.setattr(monitor_state, "_FORMAT", before)
        gyrostat.monitor(folder / "one.parquet", **options(folder, "out"))
    with pytest.raises(InputError, match=r"found the state of a call of another version, "):
        gyrostat.monitor(folder / "one.parquet", **options(folder, "out"))
