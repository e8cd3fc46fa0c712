"""Tables of the environment against direct evaluation of orbit and models."""

import datetime
import socket
import sys

import erfa
import numpy as np
import ppigrf
import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.spacecraft.orbit.atmosphere import Activity
from gyrostat.spacecraft.orbit.elements import CircularElements, KeplerElements
from gyrostat.spacecraft.orbit.ephemeris import Ephemeris
from gyrostat.spacecraft.orbit.tables import TOLERANCE, orbit_environment, samples_at
from gyrostat.spacecraft.orbit.time_scales import Epoch

EPOCH = "2026-11-22T10:00:00Z"
ORBIT = CircularElements(450e3, np.radians(97.3), 0.4, 1.1)
ACTIVITY = Activity(f107=140.0, f107a=120.0, ap=7.0)
DURATION = 5700.0


@pytest.fixture(scope="module")
def made():
    """Environment and accuracy of an orbit over the poles, made without a network."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(socket.socket, "connect", None)
        patch.setattr(socket, "getaddrinfo", None)
        return orbit_environment(
            ORBIT, EPOCH, DURATION, **ACTIVITY._asdict(), ut1_utc=0.1, moon=True
        )


def test_values_of_a_run_are_those_of_the_models(made):
    environment, accuracy = made
    times = np.sort(np.random.default_rng(4).uniform(0.0, DURATION, 400))
    times[-1] = DURATION
    epoch = Epoch.of(EPOCH, 0.1)
    expected = samples_at(ORBIT.trajectory(epoch, DURATION), epoch, times, ACTIVITY, moon=True)
    names = ("position", "velocity", "sun", "field", "earth", "moon", "density")
    at = jax.jit(jax.vmap(lambda time: {name: getattr(environment, name)(time) for name in names}))
    found = {name: np.array(values) for name, values in at(times).items()}
    for name in names[:-1]:
        true = getattr(expected, name)
        error = np.linalg.norm(found[name] - true, axis=1)
        error = np.max(error) / np.sqrt(np.mean(np.sum(true**2, axis=1)))
        assert error < TOLERANCE, name
        # what is stated, from other times, is the size of the error
        assert error < 2.0 * accuracy.errors[name] + 1e-15, name
    error = np.max(np.abs(found["density"] / expected.density - 1.0))
    # the library computes the density in single precision
    assert error < 4e-5
    assert error < 3.0 * accuracy.errors["density"]


def test_the_step_is_the_longest_that_is_accurate(made):
    environment, accuracy = made
    assert max(error for name, error in accuracy.errors.items() if name != "density") < TOLERANCE
    assert accuracy.errors["field"] > 0.05 * TOLERANCE
    assert float(environment.step) == accuracy.step
    assert accuracy.step * (accuracy.rows - 1) >= DURATION + accuracy.step
    assert str(accuracy).startswith(f"{accuracy.rows} rows, {accuracy.step:g} s apart; ")
    # far from the Earth, all is slower
    _, far = orbit_environment(CircularElements(35786e3), EPOCH, 5000.0)
    assert far.step == 60.0 > accuracy.step
    assert max(far.errors.values()) < 5e-5


def test_the_field_is_that_of_the_library_in_axes_of_the_gcrs(made):
    environment, _ = made
    for time in (0.0, 1800.0, 4000.0):
        epoch, at = Epoch.of(EPOCH, 0.1), np.array([time])
        matrix = erfa.c2t06a(*epoch.tt(at), *epoch.ut1_at(at), 0.0, 0.0)[0]
        place = matrix @ np.array(environment.position(time))
        distance = np.linalg.norm(place)
        colatitude, longitude = np.arccos(place[2] / distance), np.arctan2(place[1], place[0])
        date = datetime.datetime(2026, 11, 22, 10) + datetime.timedelta(seconds=time)
        parts = ppigrf.igrf_gc(distance / 1e3, *np.degrees([colatitude, longitude]), date)
        up, east = place / distance, np.array([-np.sin(longitude), np.cos(longitude), 0.0])
        axes = np.stack([up, np.cross(east, up), east])  # radial, south, east
        expected = 1e-9 * np.ravel(parts) @ axes @ matrix
        error = np.linalg.norm(np.array(environment.field(time)) - expected)
        assert error < TOLERANCE * np.linalg.norm(expected)


def test_a_short_run_has_rows_enough():
    environment, accuracy = orbit_environment(ORBIT, EPOCH, 1.0)
    assert accuracy.rows >= 4
    assert np.all(np.isfinite(np.array(environment.splines)))


def test_an_orbit_file_is_tabulated_with_a_note_on_its_interpolation():
    elements = KeplerElements(7e6, 0.01, 1.0)
    times = np.arange(0.0, 1500.0, 30.0)
    orbit = Ephemeris(times, elements.two_bodies(times), frame="ITRF")
    _, accuracy = orbit_environment(orbit, EPOCH, 600.0)
    assert "; interpolated by polynomials of degree 7" in str(accuracy)


@pytest.mark.parametrize(
    ("orbit", "duration", "words"),
    [
        (ORBIT, 0.0, "duration"),
        (ORBIT, -5.0, "duration"),
        (ORBIT, float("nan"), "duration"),
        (ORBIT, 1e12, "expected 3.16224e\\+07 s or less"),
        (CircularElements(95e3), 60.0, "expected 100 km or more"),
        (KeplerElements(6.75e6, 0.05, true_anomaly=2.0), 6000.0, "expected 100 km or more"),
    ],
)
def test_refuses_a_run_of_no_orbit(orbit, duration, words):
    with pytest.raises(InputError, match=words):
        orbit_environment(orbit, EPOCH, duration)


@pytest.mark.parametrize(
    ("module", "package"), [("erfa", "pyerfa"), ("ppigrf", "ppigrf"), ("pymsis", "pymsis")]
)
def test_a_missing_library_is_one_line(monkeypatch, module, package):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(InputError) as caught:
        orbit_environment(ORBIT, EPOCH, 60.0)
    assert str(caught.value) == (
        f"orbit: found no {package}, expected the packages of the extra orbit: pip install "
        "'sgp4>=2.23' 'ppigrf>=2.0' 'pyerfa>=2.0.1.4' 'pymsis>=0.10'"
    )
