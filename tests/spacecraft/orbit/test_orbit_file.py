"""Orbit files: order of the interpolation, frames, segments and refusals."""

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.spacecraft.orbit.elements import KeplerElements
from gyrostat.spacecraft.orbit.ephemeris import Ephemeris, hermite
from gyrostat.spacecraft.orbit.frames import EARTH_RATE, States, gcrs_to_itrf, teme_to_gcrs
from gyrostat.spacecraft.orbit.orbit_file import OrbitFile
from gyrostat.spacecraft.orbit.time_scales import Epoch

ELEMENTS = KeplerElements(7e6, 0.02, 1.2, 0.4, 0.3, 0.2)
START = "2026-11-22T10:00:00"
EPOCH = Epoch.of(f"{START}Z")
HEADER = "time,x,y,z,vx,vy,vz"


@pytest.mark.parametrize("degree", [1, 3, 4, 7, 15])
def test_polynomials_of_the_degree_are_met_exactly(degree):
    rng = np.random.default_rng(degree)
    times = np.linspace(-1.0, 1.0, 20) + rng.uniform(-0.03, 0.03, 20)
    curves = [np.polynomial.Polynomial(rng.normal(size=degree + 1)) for _ in range(3)]

    def at(t):
        slopes = [curve.deriv()(t) for curve in curves]
        return States(np.stack([curve(t) for curve in curves], axis=1), np.stack(slopes, axis=1))

    wanted = np.concatenate([times, np.linspace(times[0], times[-1], 50)])
    found = hermite(times, at(times), degree, wanted)
    for near, true in zip(found, at(wanted), strict=True):
        # even a wide window of uneven rows keeps the digits but for a few thousand roundings
        np.testing.assert_allclose(near, true, atol=1e-9)


@pytest.mark.parametrize(("degree", "order"), [(3, 4), (5, 6), (7, 8)])
def test_the_error_falls_with_the_order_of_the_degree(degree, order):
    wanted = np.linspace(0.0, 4800.0, 201)
    true = ELEMENTS.two_bodies(wanted)

    def errors(step):
        times = np.arange(-2 * step, 4800.0 + 2.5 * step, step)
        found = hermite(times, ELEMENTS.two_bodies(times), degree, wanted)
        return [np.max(np.linalg.norm(a - b, axis=1)) for a, b in zip(found, true, strict=True)]

    ratio = np.log2(np.array(errors(480.0)) / errors(240.0))
    np.testing.assert_allclose(ratio, [order, order - 1], atol=0.6)


def csv_of(times, states):
    rows = np.column_stack([times, *states])
    return "\n".join([HEADER, *(",".join(f"{value:.17g}" for value in row) for row in rows)])


def test_a_csv_file_gives_its_orbit_back():
    times = np.arange(-60.0, 7000.0, 60.0)
    file = OrbitFile.read(csv_of(times, ELEMENTS.two_bodies(times)))
    trajectory = file.trajectory(EPOCH, 6900.0)
    wanted = np.linspace(0.0, 6900.0, 301)
    found, true = trajectory.states(wanted), ELEMENTS.two_bodies(wanted)
    np.testing.assert_allclose(found.position, true.position, atol=1e-5)
    np.testing.assert_allclose(found.velocity, true.velocity, atol=1e-6)
    assert file.period == pytest.approx(ELEMENTS.period, rel=1e-12)
    assert file.epoch is None
    # the stated error, of every second row, is above the true one
    (note,) = trajectory.notes
    stated = float(note.split("error is ")[1].split(" m")[0])
    assert np.max(np.linalg.norm(found.position - true.position, axis=1)) < stated < 1e-2


def times_of(seconds, day_of_year):
    dates = np.datetime64(START) + np.round(seconds * 1e3).astype("timedelta64[ms]")
    if not day_of_year:
        return dates.astype(str)
    first = dates.astype("datetime64[Y]").astype("datetime64[D]")
    days = (dates.astype("datetime64[D]") - first).astype(int) + 1
    return [
        f"{text[:4]}-{day:03d}{text[10:]}"
        for text, day in zip(dates.astype(str), days, strict=True)
    ]


def segment(times, states, frame, *, extra="", day_of_year=False, acceleration=False):
    rows = np.hstack([*states]) / 1e3
    if acceleration:
        rows = np.hstack([rows, np.full((len(rows), 3), 9.0)])
    texts = times_of(times, day_of_year)
    lines = [
        f"{text} {' '.join(f'{value:.15e}' for value in row)}"
        for text, row in zip(texts, rows, strict=True)
    ]
    return (
        f"META_START\nCOMMENT a = b\nOBJECT_NAME = A\nCENTER_NAME = EARTH\nREF_FRAME = {frame}\n"
        f"TIME_SYSTEM = UTC\nSTART_TIME = {texts[0]}\n{extra}META_STOP\n\nCOMMENT states\n"
        + "\n".join(lines)
        + "\n"
    )


OPENING = "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2026-11-22T00:00:00\nORIGINATOR = A\n\n"
COVARIANCE = f"COVARIANCE_START\nEPOCH = {START}\n1.0\n2.0 3.0\nCOVARIANCE_STOP\n"


def seen_in(frame, times, states):
    """GCRS -> a frame, by matrices and their derivatives."""
    position, velocity = (part[:, :, None] for part in states)
    if frame == "EME2000":
        # IERS Conventions (2010), section 5.5.4: pole (-16.617, -6.8192) mas, equinox -14.6 mas
        xi, eta, equinox = np.radians(np.array([-16.617, -6.8192, -14.6]) / 3.6e6)
        bias = np.array([[1.0, equinox, -xi], [-equinox, 1.0, -eta], [xi, eta, 1.0]])
        return States((bias @ position)[:, :, 0], (bias @ velocity)[:, :, 0])
    if frame.startswith("ITRF"):
        step = 1.0
        matrices = gcrs_to_itrf(EPOCH, times)
        slope = gcrs_to_itrf(EPOCH, times + step) - gcrs_to_itrf(EPOCH, times - step)
        factor = EARTH_RATE / np.sin(EARTH_RATE * step) / 2.0  # exact for a uniform turn
        return States(
            (matrices @ position)[:, :, 0],
            (matrices @ velocity + factor * slope @ position)[:, :, 0],
        )
    matrices = np.swapaxes(teme_to_gcrs(EPOCH, times), 1, 2) if frame == "TEME" else np.eye(3)
    return States((matrices @ position)[:, :, 0], (matrices @ velocity)[:, :, 0])


@pytest.mark.parametrize("frame", ["GCRF", "ICRF", "EME2000", "TEME", "ITRF2014", "ITRF-97"])
def test_a_message_in_every_frame_gives_its_orbit_back(frame):
    times = np.arange(-120.0, 3000.0, 60.0)
    rows = seen_in(frame, times, ELEMENTS.two_bodies(times))
    text = OPENING + segment(
        times, rows, frame, day_of_year=frame == "ICRF", acceleration=frame == "TEME"
    )
    file = OrbitFile.read(text + COVARIANCE)
    wanted = np.linspace(0.0, 2800.0, 57)
    found, true = file.trajectory(EPOCH, 2800.0).states(wanted), ELEMENTS.two_bodies(wanted)
    np.testing.assert_allclose(found.position, true.position, atol=2e-3)
    np.testing.assert_allclose(found.velocity, true.velocity, atol=3e-4)
    assert file.period == pytest.approx(ELEMENTS.period, rel=1e-5)
    assert Epoch.of(file.epoch).seconds_to(EPOCH.utc) == pytest.approx(120.0, abs=1e-6)


def test_the_segment_that_covers_the_run_is_taken():
    early, late = np.arange(-600.0, 1.0, 60.0), np.arange(0.0, 1801.0, 60.0)
    shifted = States(*(2.0 * part for part in ELEMENTS.two_bodies(early)))
    text = OPENING + segment(early, shifted, "GCRF") + COVARIANCE
    text += segment(late, ELEMENTS.two_bodies(late), "GCRF", extra="INTERPOLATION_DEGREE = 9\n")
    file = OrbitFile.read(text)
    assert file.segments[1].degree == 9
    found = file.trajectory(EPOCH, 1800.0).states(np.array([30.0]))
    np.testing.assert_allclose(found.position, ELEMENTS.two_bodies(np.array([30.0])).position)
    with pytest.raises(InputError, match=r"segments -600 s to 0 s, 0 s to 1800 s after the epoch"):
        file.trajectory(EPOCH, 1900.0)


TIMES = np.arange(0.0, 601.0, 60.0)
GOOD = OPENING + segment(TIMES, ELEMENTS.two_bodies(TIMES), "GCRF")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("REF_FRAME = GCRF", "REF_FRAME = MCI", "REF_FRAME 'MCI', expected one of GCRF"),
        ("CENTER_NAME = EARTH", "CENTER_NAME = MOON", "CENTER_NAME 'MOON'"),
        ("TIME_SYSTEM = UTC", "TIME_SYSTEM = TDB", "TIME_SYSTEM TDB, expected UTC"),
        ("OBJECT_NAME = A", "OBJECT_NAME", "line 7: found 'OBJECT_NAME', expected KEY = value"),
        (f"{START}.000 ", f"{START}.000 x", "line 15: .*expected a time and six numbers"),
        (f"{START}.000 ", "22-11-2026 ", "line 15: found '22-11-2026', expected a time UTC"),
        ("T10:02:00", "T10:00:30", "row 3: found the time 30 s after 60 s, expected ascending"),
        ("META_START\n", "", "expected META_START"),
        ("META_STOP", "INTERPOLATION_DEGREE = x\nMETA_STOP", "INTERPOLATION_DEGREE 'x'"),
        ("META_STOP", "INTERPOLATION_DEGREE = 40\nMETA_STOP", "interpolation degree 40"),
    ],
)
def test_refuses_a_message_that_is_damaged(old, new, words):
    assert old in GOOD
    with pytest.raises(InputError, match=words) as caught:
        OrbitFile.read(GOOD.replace(old, new), where="a.oem")
    assert str(caught.value).startswith("a.oem")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "found the header ''"),
        ("t,x,y,z,vx,vy,vz\n", "found the header 't,x,y,z,vx,vy,vz'"),
        (HEADER, "found 0 rows"),
        (f"{HEADER}\n0,1,2,3,4,5,6", "found 1 rows"),
        (f"{HEADER}\n0,1,2,3,4,5,6\n1,2,3\n", "line 3: found '1,2,3'"),
        (f"{HEADER}\n0,1,2,3,4,5,6\n1,a,2,3,4,5,6\n", "line 3: found '1,a"),
        (f"{HEADER}\n0,1,2,3,4,5,6\n1,nan,2,3,4,5,6\n", "row 2: found no finite"),
        (OPENING, "no states"),
    ],
)
def test_refuses_rows_of_no_orbit(text, words):
    with pytest.raises(InputError, match=words):
        OrbitFile.read(text)


def test_refuses_a_file_that_ends_before_the_run():
    file = OrbitFile.read(GOOD)
    with pytest.raises(InputError, match=r"from 0 s to 600 s after the epoch, expected .* 601 s"):
        file.trajectory(EPOCH, 601.0)
    with pytest.raises(InputError, match=r"from 30 s to 630 s after the epoch"):
        file.trajectory(Epoch.of("2026-11-22T09:59:30Z"), 300.0)


def test_refuses_an_orbit_that_leaves_the_earth():
    rows = ELEMENTS.two_bodies(TIMES)
    orbit = Ephemeris(TIMES, States(rows.position, 1.6 * rows.velocity))
    with pytest.raises(InputError, match="expected an elliptic orbit"):
        _ = orbit.period


def test_refuses_a_frame_that_is_unknown():
    with pytest.raises(InputError, match="found the frame 'LVLH', expected one of GCRS"):
        OrbitFile.read(csv_of(TIMES, ELEMENTS.two_bodies(TIMES)), "LVLH")


@pytest.mark.parametrize(
    ("factors", "cause"),
    [
        ((1.0 / 60.0, 1.0, 1.0), r"times in minutes\?"),
        ((1.0 / 3600.0, 1.0, 1.0), r"times in hours\?"),
        ((1.0 / 86400.0, 1.0, 1.0), r"times in days\?"),
        ((1e3, 1.0, 1.0), r"of a revolution .* times in ms\?"),
        ((1.0, 1.0, 1e-3), r"velocities in km/s\?"),
        ((1.0, 1e-3, 1.0), r"6\.\d+ km from the centre of the Earth"),
        ((1.0, 1.0, 1.1), "which contradict the positions"),
        ((1.0, 1.0, -1.0), "expected .* km by times and velocities"),
    ],
)
@pytest.mark.parametrize("count", [4, 200])
def test_refuses_units_that_contradict_each_other(factors, cause, count):
    """Times, positions and velocities of one orbit, one of them in another unit."""
    times = 60.0 * np.arange(count)
    states = ELEMENTS.two_bodies(times)
    time, position, velocity = factors
    file = OrbitFile.read(
        csv_of(time * times, States(position * states.position, velocity * states.velocity))
    )
    with pytest.raises(InputError, match=cause):
        file.trajectory(EPOCH, float(time * times[-1]) / 2.0)


def test_refuses_a_row_that_is_out_of_place():
    times = 60.0 * np.arange(50)
    states = ELEMENTS.two_bodies(times)
    states.position[20] += [30e3, 0.0, 0.0]
    with pytest.raises(InputError, match=r"from row 2[01] to row 2[12]"):
        Ephemeris(times, states).trajectory(EPOCH, 600.0)


@pytest.mark.parametrize("eccentricity", [0.0, 0.3, 0.7])
@pytest.mark.parametrize("step", [1.0, 60.0, 600.0, 1500.0])
@pytest.mark.parametrize("axis", [7e6, 42e6])
def test_accepts_every_honest_table(eccentricity, step, axis):
    """Also coarse ones, at any point of the orbit; the perigee is above the surface."""
    elements = KeplerElements(axis / (1.0 - eccentricity), eccentricity, 1.2, 0.4, 0.3, 0.2)
    times = step * np.arange(max(40, int(elements.period / step)))
    Ephemeris(times, elements.two_bodies(times)).trajectory(EPOCH, step)


def test_accepts_a_manoeuvre_between_two_rows():
    """100 m/s along the velocity, a minute after the last row of the first orbit."""
    before = 60.0 * np.arange(40)
    start = ELEMENTS.two_bodies(before)
    step = start.velocity[-1] * 100.0 / np.linalg.norm(start.velocity[-1])
    after = start.position[-1] + 60.0 * (start.velocity[-1] + step)
    rows = States(
        np.vstack([start.position, after]), np.vstack([start.velocity, start.velocity[-1] + step])
    )
    Ephemeris(np.append(before, before[-1] + 60.0), rows).trajectory(EPOCH, 600.0)
