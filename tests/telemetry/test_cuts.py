"""Gaps, frozen tachometers and clipped currents: what is cut, and what is left as it is."""

import dataclasses
import os

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.telemetry import Record, cut, pool, read_record, record_of_edges
from gyrostat.telemetry.edges import read_edges

RATE = 10.0


def sampled(current, speed, time=None, **fields):
    time = np.arange(len(speed)) / RATE if time is None else time
    return Record("r", time, current, speed, np.isfinite(speed), **fields)


def noisy(seed=0, count=400):
    """A speed with noise, under a current with noise."""
    random = np.random.default_rng(seed)
    phase = np.linspace(0.0, 12.0, count)
    speed = 30.0 * np.sin(phase) + 40.0 + 0.3 * random.standard_normal(count)
    current = 0.1 * np.cos(phase) + 1e-4 * random.standard_normal(count)
    return current, speed


def test_a_usual_record_is_one_segment_and_unchanged():
    record = sampled(*noisy())
    found = cut(record)
    assert found.segments == [slice(0, 400)]
    assert found.notes == ()
    np.testing.assert_array_equal(found.speed, record.speed)
    assert cut(found) is found


def test_a_gap_starts_a_segment():
    current, speed = noisy()
    time = np.arange(400) / RATE
    time[150:] += 30.0
    found = cut(sampled(current, speed, time))
    assert found.segments == [slice(0, 150), slice(150, 400)]
    assert "1 gaps longer" in found.notes[0]


def test_a_frozen_tachometer_is_masked_and_said():
    current, speed = noisy()
    speed[100:140] = speed[100]
    found = cut(sampled(current, speed))
    assert not found.valid[101:140].any()
    assert found.valid.sum() == 400 - 39
    assert "tachometer frozen: 39 samples masked (1 intervals)" in found.notes


def test_dropped_out_zeros_are_masked_and_a_wheel_at_rest_is_not():
    current, speed = noisy()
    speed[200:210] = 0.0
    assert cut(sampled(current, speed)).valid.sum() == 390
    rest = np.concatenate([np.linspace(5.0, 0.0, 200), np.zeros(200)])
    rest[:200] += 0.05 * np.random.default_rng(3).standard_normal(200)
    assert cut(sampled(current, rest)).valid.all()


def test_a_quantised_speed_is_not_frozen():
    current, speed = noisy()
    assert cut(sampled(current, 10.0 * np.round(speed / 10.0))).valid.all()


def test_a_clipped_current_ends_segments():
    current, speed = noisy()
    limited = np.clip(current, -0.07, 0.07)
    found = cut(sampled(limited, speed))
    assert len(found.segments) > 3
    assert "current clipped at 0.07 A" in found.notes[0]
    inside = np.abs(found.current) < 0.07
    # a segment ends with the first clipped sample, whose speed is still known
    ends = [part.stop - 1 for part in found.segments]
    assert set(np.flatnonzero(~inside)) <= set(ends)


def test_steps_of_equal_current_are_not_clipped():
    current = 0.1 * np.sign(np.sin(np.linspace(0.1, 20.0, 400)))
    assert cut(sampled(current, noisy()[1])).segments == [slice(0, 400)]


def test_an_encoder_angle_gives_mean_speeds(tmp_path):
    time = np.arange(200) / RATE
    speed = 3.0 * np.cos(0.2 * time)
    angle = 15.0 * np.sin(0.2 * time)
    counts = np.round(angle / (2.0 * np.pi) * 4096.0) % 4096
    path = tmp_path / "encoder.csv"
    rows = zip(time, 0.1 * speed, counts, strict=True)
    path.write_text("time_s,current_A,angle\n" + "".join(f"{a},{b},{c}\n" for a, b, c in rows))
    found = read_record(path, units={"angle": "rev/4096"})
    assert found.averaged
    assert not found.valid[0]
    exact = np.diff(angle) * RATE
    np.testing.assert_allclose(found.speed[1:], exact, atol=2.0 * np.pi / 4096 * RATE)


def test_an_angle_that_turns_too_far_between_samples_is_refused(tmp_path):
    path = tmp_path / "fast.csv"
    time = np.arange(100) / RATE
    rows = zip(time, np.ones(100), (29.8 * time) % (2.0 * np.pi), strict=True)
    path.write_text("time_s,current_A,angle_rad\n" + "".join(f"{a},{b},{c}\n" for a, b, c in rows))
    with pytest.raises(InputError, match="nearly half a turn"):
        read_record(path)


def test_edge_times_remove_the_quantum_of_counts():
    """Six edges a turn, counted over 0.1 s, are a step of 100 rpm; timed they are exact."""
    time = np.arange(300) / RATE
    fine = np.linspace(0.0, 29.9, 300_001)
    angle = 40.0 * fine + 10.0 * np.sin(0.3 * fine)
    edges = np.interp(np.arange(0.0, angle[-1], 2.0 * np.pi / 6.0), angle, fine)
    found = record_of_edges("edges", time, np.ones(300), edges, 6)
    at = np.interp(time, fine, angle)
    mean = np.append(np.nan, np.diff(at) * RATE)
    assert found.valid.sum() > 295
    quantum = 2.0 * np.pi / 6.0 * RATE
    assert np.nanmax(np.abs(found.speed - mean)) < 1e-4 * quantum


def test_a_file_of_edges_takes_the_place_of_a_speed(tmp_path):
    time = np.arange(300) / RATE
    (tmp_path / "r.csv").write_text("time_s,current_A\n" + "".join(f"{t},0.1\n" for t in time))
    (tmp_path / "edges.txt").write_text("time_s\n" + "".join(f"{0.02 * k}\n" for k in range(1500)))
    found = read_record(tmp_path / "r.csv", edges=tmp_path / "edges.txt", pulses=6)
    assert found.averaged
    speed = 2.0 * np.pi / 6.0 / 0.02
    np.testing.assert_allclose(found.speed[found.valid], speed, rtol=1e-9)


@pytest.mark.parametrize("last", ["inf", "nan"])
def test_an_edge_without_a_time_is_refused_by_its_row(tmp_path, last):
    (tmp_path / "edges.txt").write_text(f"time_s\n0.0\n0.1\n0.2\n{last}\n")
    with pytest.raises(InputError, match=f"row 5: found '{last}', expected a finite time in s"):
        read_edges(tmp_path / "edges.txt")


def test_a_pipe_with_edges_is_refused_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "edges")
    with pytest.raises(InputError, match="found a pipe or device, expected edge times"):
        read_edges(tmp_path / "edges")


@pytest.mark.parametrize(
    ("edges", "said"), [([0.0, 1.0], "at least 3"), ([0.0, 1.0, 0.5], "increasing")]
)
def test_bad_edges_are_refused(edges, said):
    with pytest.raises(InputError, match=said):
        record_of_edges("e", np.arange(4.0), np.ones(4), np.array(edges), 6)


def test_rows_without_numbers_are_left_out_where_that_is_asked_for(tmp_path):
    path = tmp_path / "holes.csv"
    path.write_text(
        "# serial: RW-07\n# date: 2026-03-01\n# temperature: 21 degC\n"
        "time_s,current_A,speed_rpm\n0,1,10\n0.1,NA,11\n0.2,1,nan\n0.3,1,12\n0.4,1,\n0.5,1,13\n"
    )
    with pytest.raises(InputError, match="row 6"):
        read_record(path)
    found = read_record(path, missing="drop")
    np.testing.assert_array_equal(found.time, [0.0, 0.2, 0.3, 0.4, 0.5])
    np.testing.assert_array_equal(found.valid, [True, False, True, False, True])
    assert "1 row without time or current dropped" in found.notes
    assert found.metadata == {"serial": "RW-07", "date": "2026-03-01", "temperature": "21 degC"}
    assert found.temperature is not None
    assert found.temperature[0] == pytest.approx(21.0)


def test_what_a_record_says_of_itself_survives_cutting():
    record = sampled(*noisy(), metadata={"serial": "RW-07"})
    assert cut(dataclasses.replace(record)).metadata == {"serial": "RW-07"}


def test_a_dense_record_is_pooled_into_exact_means():
    """A speed that is a parabola in time, under a current that is a straight line."""
    time = np.arange(200_001) * 1e-3
    random = np.random.default_rng(5)
    exact = 10.0 + 0.02 * time + 1e-4 * time**2
    record = sampled(0.1 + 1e-4 * time, exact + 0.5 * random.standard_normal(len(time)), time)
    found, size = pool(cut(record))
    assert size == 8
    assert found.averaged
    assert found.time.size == 25_001
    ends = found.time
    integral = 10.0 * ends + 0.01 * ends**2 + 1e-4 / 3.0 * ends**3
    error = (found.speed - np.append(np.nan, np.diff(integral) / np.diff(ends)))[1:]
    assert abs(error.mean()) < 5.0 * 0.5 / np.sqrt(200_000)
    assert error.std() == pytest.approx(0.5 / np.sqrt(8.0), rel=0.15)
    # the held current, its mean over each interval
    np.testing.assert_allclose(found.current[:-1], 0.1 + 1e-4 * (ends[:-1] + 3.5e-3), rtol=1e-9)
    assert pool(sampled(*noisy()))[1] == 1
