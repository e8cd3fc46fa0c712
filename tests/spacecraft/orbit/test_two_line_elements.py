"""Two-line elements against the published vectors of SGP4 and its implementation in Python."""

import erfa
import numpy as np
import pytest
from sgp4.model import Satrec as PythonSatrec

from gyrostat.core.errors import InputError
from gyrostat.spacecraft.orbit.frames import transposed
from gyrostat.spacecraft.orbit.time_scales import Epoch
from gyrostat.spacecraft.orbit.two_line_elements import TwoLineElements, checksum

LINES = (
    "1 00005U 58002B   00179.78495062  .00000023  00000-0  28098-4 0  4753",
    "2 00005  34.2682 348.7242 1859667 331.7664  19.3264 10.82419157413667",
)
TEXT = "\n".join(LINES)
PUBLISHED = {
    0.0: ((7022.46529266, -1400.08296755, 0.03995155), (1.893841015, 6.405893759, 4.534807250)),
    360.0: (
        (-7154.03120202, -3783.17682504, -3536.19412294),
        (4.741887409, -4.151817765, -2.093935425),
    ),
}
"""Minutes -> TEME position, km, and velocity, km/s, in the test cases of AIAA 2006-6753."""


def changed(line, start, text):
    """A line with other characters and the checksum that belongs to them."""
    line = line[:start] + text + line[start + len(text) :]
    return line[:-1] + str(checksum(line))


def to_teme(epoch, times, vectors):
    """GCRS -> TEME without Earth rotation: precession and nutation, equation of the equinoxes."""
    tt = epoch.tt(times)
    of_date = erfa.pnm06a(*tt) @ vectors[:, :, None]
    return (transposed(erfa.rz(-erfa.eqeq94(*tt), np.eye(3))) @ of_date)[:, :, 0]


def test_states_are_the_published_ones():
    orbit = TwoLineElements.read(f"TEME EXAMPLE\n{TEXT}\n")
    epoch = Epoch.of(orbit.epoch)
    minutes = np.array([*PUBLISHED])
    trajectory = orbit.trajectory(epoch, 21600.0)
    states = trajectory.states(60.0 * minutes)
    expected = 1e3 * np.array([*PUBLISHED.values()])
    # the two ways to TEME differ by milliarcseconds in 2000: 0.2 m in 8700 km
    found = [to_teme(epoch, 60.0 * minutes, part) for part in states]
    np.testing.assert_allclose(found[0], expected[:, 0], atol=0.2)
    np.testing.assert_allclose(found[1], expected[:, 1], atol=2e-4)
    assert trajectory.notes == ("the epochs of the run and of the elements are 0.00 days apart",)


def test_a_later_run_agrees_with_the_implementation_in_python():
    orbit = TwoLineElements.read(TEXT)
    epoch = Epoch.of("2000-07-10T00:00:00Z")
    times = np.linspace(0.0, 86400.0, 20)
    states = orbit.trajectory(epoch, 86400.0).states(times)
    reference = PythonSatrec.twoline2rv(*LINES)
    day = 2451735.5
    rows = [reference.sgp4(day, time / 86400.0)[1] for time in times]
    # the length does not depend on the frame
    np.testing.assert_allclose(
        np.linalg.norm(states.position, axis=1), 1e3 * np.linalg.norm(rows, axis=1), rtol=1e-10
    )
    np.testing.assert_allclose(
        to_teme(epoch, times, states.position), 1e3 * np.array(rows), atol=0.5
    )


def test_epoch_and_period_are_those_of_the_lines():
    orbit = TwoLineElements.read(TEXT)
    assert orbit.epoch == "2000-06-27T18:50:19.733568Z"
    assert orbit.period == pytest.approx(86400.0 / 10.82419157, rel=1e-9)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ((LINES[0][:-1] + "4", LINES[1]), "line 1: found the checksum 4, expected 3"),
        ((LINES[0], LINES[1][:-2]), "line 2: found '2 00005.*expected 69 characters"),
        ((LINES[1], LINES[0]), "line 1: found '2 "),
        ((LINES[0], changed(LINES[1], 2, "00006")), "objects 00005 and 00006"),
        ((LINES[0],), "found 1 lines, expected two"),
        (("a", "b", *LINES), "found 4 lines"),
        ((), "found 0 lines"),
    ],
)
def test_refuses_lines_of_no_elements(lines, words):
    with pytest.raises(InputError, match=words) as caught:
        TwoLineElements.read("\n".join(lines), "a.tle")
    assert str(caught.value).startswith("a.tle")


@pytest.mark.parametrize(
    ("line", "start", "text"),
    [
        (1, 18, "xx"),
        (1, 20, "zzz"),
        (1, 33, "x"),
        (1, 44, "x"),
        (1, 53, "x"),
        (2, 8, "  ab.cdef"),
        (2, 52, "00.00000000"),
        (2, 26, "99999x9"),
        (1, 20, "000.00000000"),
        (2, 8, "     nan"),
    ],
)
def test_refuses_lines_without_numbers(line, start, text):
    lines = [*LINES]
    lines[line - 1] = changed(lines[line - 1], start, text)
    with pytest.raises(InputError, match="two-line elements"):
        TwoLineElements(*lines).trajectory(Epoch.of("2000-06-28T00:00:00Z"), 60.0)


@pytest.mark.parametrize(
    ("text", "days"), [("2000-08-27T18:50:20Z", "61.0"), ("2000-05-18T18:50:20Z", "40.0")]
)
def test_refuses_a_run_far_from_the_elements(text, days):
    with pytest.raises(InputError, match=f"found a run up to {days} days from the epoch"):
        TwoLineElements.read(TEXT).trajectory(Epoch.of(text), 60.0)


@pytest.mark.filterwarnings("error")
def test_elements_before_leap_seconds_are_refused_without_a_warning():
    orbit = TwoLineElements(changed(LINES[0], 18, "58"), LINES[1])
    assert orbit.epoch.startswith("1958-06-28T18:50:1")
    with pytest.raises(InputError, match="days from the epoch of the elements"):
        orbit.trajectory(Epoch.of("2000-06-28T00:00:00Z"), 60.0)


def test_an_orbit_that_decays_is_one_line():
    low = (
        changed(LINES[0], 53, " 50000-2"),
        changed(LINES[1], 26, "0005000 331.7664  19.3264 16.40"),
    )
    orbit = TwoLineElements(*low)
    trajectory = orbit.trajectory(Epoch.of("2000-06-28T00:00:00Z"), 20 * 86400.0)
    with pytest.raises(InputError, match="by SGP4, expected an orbit"):
        trajectory.states(np.linspace(0.0, 20 * 86400.0, 100))
