"""Jitter with harmonics, structural modes of the wheels and flexible modes of the spacecraft."""

import dataclasses

import equinox as eqx
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.spacecraft import (
    FlexibleModes,
    Gyrostat,
    Imbalance,
    ImbalancedGyrostat,
    Spacecraft,
    WheelHarmonics,
    WheelStructure,
)
from gyrostat.wheel import WheelArray, pyramid_axes

AXES = pyramid_axes(4)
INERTIA = np.array([[0.12, 0.004, 0.0], [0.004, 0.10, -0.003], [0.0, -0.003, 0.06]])
MASS = 14.0
CRAFT = Spacecraft(INERTIA, WheelArray(AXES, np.full(4, 2e-5)), mass=MASS)
MODES = FlexibleModes(
    frequency=[40.0, 95.0],
    damping=[0.01, 0.02],
    participation=[[0.08, 0.0, 0.02], [0.01, 0.1, 0.0]],
    translation=[[0.1, 0.2, 0.0], [0.0, 0.1, 0.3]],
)
HARMONICS = WheelHarmonics.joined(
    WheelHarmonics.single(
        2.0, 4, force=np.array([1e-7, 0.0, 3e-7, 2e-7]), torque=2e-8, axial=1e-7, phase=0.4
    ),
    WheelHarmonics.single(3.87, 4, force=5e-8, torque=np.array([0.0, 1e-8, 3e-8, 2e-8])),
)
STRUCTURE = WheelStructure(
    radial_frequency=np.array([900.0, 1100.0, np.inf, 1000.0]),
    radial_damping=np.full(4, 0.02),
    rocking_frequency=np.array([400.0, np.inf, 500.0, 600.0]),
    rocking_damping=np.full(4, 0.01),
    inertia_ratio=np.array([1.8, 1.8, 0.4, 1.2]),
)
IMBALANCE = Imbalance(
    np.array([1e-6, 2e-6, 0.5e-6, 1e-6]),
    np.array([1e-7, 3e-7, 2e-7, 1e-7]),
    0.1 * AXES[::-1],
    HARMONICS,
    STRUCTURE,
)
SPEED = np.array([300.0, -20.0, 23.0, -150.0])
ANGLE = np.array([0.0, 1.0, 2.0, 3.0])


def transmitted(ratio, number, speed):
    """Transmission of a rotating load by a rotor on springs: (k z + c z') / load."""
    if not np.isfinite(ratio["frequency"]):
        return 1.0
    own, damping, gyroscopic = ratio["frequency"], ratio["damping"], ratio.get("gyroscopic", 0.0)
    s = 1j * number * speed
    spring = own**2 + 2.0 * damping * own * s
    return spring / (s**2 - 1j * gyroscopic * speed * s + spring)


def full_response(number, speed, force, torque, modes):
    """Attitude and modal coordinates for complex loads: body and modes solved together."""
    damping, stiffness = np.diag(2 * modes.damping * modes.frequency), np.diag(modes.frequency**2)
    moved, turned = np.asarray(modes.translation), np.asarray(modes.participation)
    mass = np.block([[INERTIA, turned.T], [turned, np.eye(len(damping)) - moved @ moved.T]]).astype(
        complex
    )
    none = np.zeros((3, len(damping)))
    s = 1j * number * speed
    whole = s**2 * mass + np.block([[np.zeros((3, 3)), none], [none.T, s * damping + stiffness]])
    loads = np.concatenate([torque, -moved @ force / np.sqrt(MASS)])
    return np.linalg.solve(whole, loads)[:3]


def test_the_jitter_is_the_forced_response_of_the_coupled_equations():
    """Against complex linear solves of body, modes and rotors on springs, wheel by wheel."""
    structure, harmonics = STRUCTURE, HARMONICS
    number = np.array([1.0, *harmonics.number])
    forces = np.vstack([IMBALANCE.static, harmonics.force])
    torques = np.vstack([IMBALANCE.dynamic, harmonics.torque])
    axial = np.vstack([np.zeros(4), harmonics.axial])
    phase = np.vstack([np.zeros(4), harmonics.phase])
    expected, rate = np.zeros(3), np.zeros(3)
    for wheel, speed in enumerate(SPEED):
        axis = AXES[:, wheel]
        least = np.eye(3)[np.argmin(np.abs(axis))]
        first = np.cross(least, axis)
        first /= np.linalg.norm(first)
        rotating = first - 1j * np.cross(axis, first)
        radial = {
            "frequency": structure.radial_frequency[wheel],
            "damping": structure.radial_damping[wheel],
        }
        rocking = {
            "frequency": structure.rocking_frequency[wheel],
            "damping": structure.rocking_damping[wheel],
            "gyroscopic": structure.inertia_ratio[wheel],
        }
        for k, h in enumerate(number):
            force = forces[k, wheel] * rotating * transmitted(radial, h, speed)
            force = speed**2 * (force + axial[k, wheel] * axis)
            torque = -1j * torques[k, wheel] * rotating * transmitted(rocking, h, speed)
            torque = speed**2 * torque + np.cross(IMBALANCE.position[:, wheel], force)
            turn = np.exp(1j * (h * ANGLE[wheel] + phase[k, wheel]))
            part = full_response(h, speed, force, torque, MODES) * turn
            expected += part.real
            rate += (1j * h * speed * part).real
    found = jax.jit(
        lambda: (
            IMBALANCE.jitter(CRAFT, SPEED, ANGLE, MODES),
            IMBALANCE.jitter_rate(CRAFT, SPEED, ANGLE, MODES),
        )
    )()
    np.testing.assert_allclose(found[0], expected, rtol=1e-10, atol=1e-18)
    np.testing.assert_allclose(found[1], rate, rtol=1e-10, atol=1e-16)


def test_wheels_at_rest_and_stiff_structures_have_the_jitter_of_rigid_bodies():
    """At zero speed the response is that without modes, and finite."""
    rigid = dataclasses.replace(IMBALANCE, structure=None)
    both = jax.jit(
        lambda speed: (
            IMBALANCE.jitter(CRAFT, speed, ANGLE, MODES),
            rigid.jitter(CRAFT, speed, ANGLE),
        )
    )
    for speed in (np.zeros(4), np.full(4, 1e-3)):
        np.testing.assert_allclose(*both(speed), rtol=1e-8)


def test_an_unloaded_spring_mass_rotor_has_the_transmission_of_the_structure():
    """Rotor tilting on springs with gyroscopic torque, integrated until it is steady."""
    own, damping, ratio, speed, number = 50.0, 0.05, 1.6, 40.0, 3.0
    made = WheelStructure(*(np.full(1, x) for x in (np.inf, 1.0, own, damping, ratio)))
    gain = eqx.filter_jit(made.rocking)(np.array([[number * speed]]), np.array([speed]))

    def slope(time, y):
        tilt, rate = y[0] + 1j * y[1], y[2] + 1j * y[3]
        load = np.exp(1j * number * speed * time)
        bend = load + 1j * ratio * speed * rate - 2 * damping * own * rate - own**2 * tilt
        return [rate.real, rate.imag, bend.real, bend.imag]

    # the backward mode decays at 1.15 / s
    end = 20.0
    y = solve_ivp(slope, (0.0, end), np.zeros(4), "DOP853", rtol=1e-10, atol=1e-13).y[:, -1]
    passed = 2 * damping * own * (y[2] + 1j * y[3]) + own**2 * (y[0] + 1j * y[1])
    passed *= np.exp(-1j * number * speed * end)
    found = complex(gain.real[0, 0], gain.imaginary[0, 0])
    assert abs(passed - found) < 1e-7
    assert abs(found) > 0.1


def passage(slowness):
    """Pass a mode with a wheel; largest body rate, and largest error of the steady response.

    Args:
        slowness: Squared decay rate of the mode, (z w)², over the change of the wheel speed.
    """
    inertia, mode, own, damping, load = 0.1, 0.05, 40.0, 0.06, 1e-6
    free = own / np.sqrt(1.0 - mode**2 / inertia)
    change = (damping * free) ** 2 / slowness
    begin, span = 0.9 * free, 0.2 * free / change
    craft = Spacecraft(inertia * np.eye(3), WheelArray(np.eye(3)[:, 2:], np.full(1, 1e-5)))
    alone = Imbalance(np.zeros(1), np.full(1, load), np.zeros((3, 1)))
    modes = FlexibleModes([own], [damping], [[0.0, mode, 0.0]])
    # the torque of an imbalance that points along x at angle 0 is along y for this phase
    torque = np.asarray(
        jax.jit(lambda: alone.loads(craft.wheels.axes, np.ones(1), np.zeros(1)))()[1]
    )
    quarter = np.arctan2(-torque[0], torque[1])

    def angle(time):
        return begin * time + 0.5 * change * time**2

    @jax.jit
    @jax.vmap
    def steady(time):
        speed = jax.numpy.reshape(begin + change * time, 1)
        return alone.jitter_rate(craft, speed, speed * 0.0 + angle(time) - quarter, modes)[1]

    def slope(time, y):
        spring = -(2.0 * damping * own * y[2] + own**2 * y[1])
        pushed = load * (begin + change * time) ** 2 * np.cos(angle(time))
        turn = (pushed - mode * spring) / (inertia - mode**2)
        return [turn, y[2], spring - mode * turn]

    times = np.linspace(0.0, span, 4001)
    own_start = [float(steady(np.zeros(1))[0]), 0.0, 0.0]
    y = solve_ivp(slope, (0.0, span), own_start, "DOP853", times, rtol=1e-7, atol=1e-12).y
    late = times > 8.0 / (damping * free)
    told = np.asarray(steady(times))[late]
    # the mean rate depends on the phase at which the motion began
    error = y[0][late] - told
    return np.max(np.abs(told)), np.max(np.abs(error - np.mean(error)))


def test_a_slow_passage_through_resonance_follows_the_steady_response():
    """The error is of first order in the change of the speed."""
    (largest, error), (_, half) = passage(20.0), passage(40.0)
    assert half < 0.05 * largest
    assert 1.7 < error / half < 2.3


@pytest.mark.parametrize(
    ("modes", "mass", "found"),
    [
        (dataclasses.replace(MODES, damping=np.array([0.01, 0.0])), MASS, "mode damping: found 0"),
        (MODES, None, "mass of the spacecraft: found none"),
    ],
)
def test_modes_without_a_steady_response_are_refused(modes, mass, found):
    plant = Gyrostat(dataclasses.replace(CRAFT, mass=mass), modes=modes)
    with pytest.raises(InputError, match=found):
        ImbalancedGyrostat(plant, IMBALANCE).check()


def test_harmonics_of_other_wheels_are_refused():
    other = dataclasses.replace(IMBALANCE, harmonics=WheelHarmonics.single(2.0, 3))
    with pytest.raises(InputError, match=r"wheel harmonics force: found shape \(1, 3\)"):
        other.check()
