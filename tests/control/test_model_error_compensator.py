"""The compensator on textbook plants, 30 % wrong: analytic steady states, and tuning."""

from typing import NamedTuple

import equinox as eqx
import numpy as np
import pytest

from gyrostat.control import FirstOrderLags, Integrators, ModelErrorCompensator, OnlineFrit
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation import simulate, stack

PERIOD, LAG = 0.05, 2.0
"""s."""
FEEDBACK = 3.0
"""Proportional: the nominal closed loop has the gain 3/4 and a fourth of the time constant."""
WRONG = 0.7
"""Gain of the plant over that of its model."""


class Level(NamedTuple):
    level: jnp.ndarray


class Push(NamedTuple):
    push: jnp.ndarray
    model_error: jnp.ndarray
    diagonal: jnp.ndarray


class Nothing(NamedTuple):
    pass


class Lag(eqx.Module):
    """level' = (gain push + disturbance - level) / LAG, exact."""

    gain: float = 1.0
    disturbance: float = 0.0

    def __call__(self, state, command, time, duration):
        kept = jnp.exp(-duration / LAG)
        end = self.gain * command.push + self.disturbance
        return Level(kept * state.level + (1.0 - kept) * end), jnp.array(True)

    def diverged(self, state):
        return jnp.any(jnp.abs(state.level) > 1e6)

    def record(self, state, command):
        return Nothing()


class Seen(eqx.Module):
    def start(self, state, period):
        return ()

    def __call__(self, memory, state, key):
        return memory, state


class Proportional(eqx.Module):
    """u = F (1 - y)."""

    def start(self, period):
        return ()

    def observe(self, memory, measurement):
        return memory, measurement.level

    def nominal_input(self, output):
        return FEEDBACK * (1.0 - output)

    def command(self, memory, measurement, input, compensation):
        return Push(input, compensation.model_error, jnp.diagonal(compensation.gain))


MODEL = FirstOrderLags(jnp.array([1.0 / LAG]))
IDEAL = FirstOrderLags(jnp.array([(1.0 + FEEDBACK) / LAG]), FEEDBACK / (1.0 + FEEDBACK))


def compensated(gain=0.0, tuner=None, model=MODEL):
    return ModelErrorCompensator(Proportional(), model, gain * jnp.eye(1), tuner)


def run(plant, controller, duration=40.0, start=0.0):
    return simulate(
        plant,
        controller,
        Seen(),
        start=Level(jnp.array([start])),
        duration=duration,
        control_period=PERIOD,
    )


def tuning(**changes):
    fields = {
        "feedback": jnp.array([FEEDBACK]),
        "reference": IDEAL,
        "forgetting": 0.95,
        "smoothing": 0.05,
        "dead_zone": jnp.array([0.02]),
        "initial_gain": jnp.zeros((1, 1)),
        "initial_covariance": 100.0,
    }
    return OnlineFrit(**{**fields, **changes})


def steady(gain):
    """y = g (u_n + K (u_n - y)), u_n = F (1 - y)."""
    ratio = WRONG * (1.0 + gain) / (1.0 + gain * WRONG)
    return ratio * FEEDBACK / (1.0 + ratio * FEEDBACK)


@pytest.mark.parametrize("gain", [0.0, 1.0, 8.0])
def test_steady_states_are_the_analytic_ones(gain):
    level = run(Lag(WRONG), compensated(gain)).level.values[-1, 0]
    assert level == pytest.approx(steady(gain), abs=1e-9)


def test_integrators_leave_a_disturbance_over_the_gain():
    class Drifting(Lag):
        def __call__(self, state, command, time, duration):
            return Level(state.level + duration * (command.push + 0.2)), jnp.array(True)

    found = run(Drifting(), compensated(2.0, model=Integrators()))
    assert found.model_error.values[-1, 0] == pytest.approx(-0.2 / 2.0, abs=1e-9)
    assert found.level.values[-1, 0] == pytest.approx(1.0, abs=1e-9)
    bare = run(Drifting(), compensated(0.0, model=Integrators()))
    assert bare.level.values[-1, 0] == pytest.approx(1.0 + 0.2 / FEEDBACK, abs=1e-9)


def test_on_a_plant_that_is_the_model_nothing_is_added():
    with_gain, without = (
        run(Lag(), compensated(8.0), start=0.4),
        run(Lag(), compensated(0.0), start=0.4),
    )
    np.testing.assert_allclose(with_gain.level, without.level, atol=1e-13)
    assert np.max(np.abs(with_gain.model_error)) < 1e-13


class SecondOrder(eqx.Module):
    """y'' = w^2 (u - y) - 2 z w y', exact, as a nominal model of the user's own."""

    transition: jnp.ndarray
    drive: jnp.ndarray

    @classmethod
    def sampled(cls, frequency=1.5, damping=0.6, gain=1.0):
        from scipy.linalg import expm

        full = np.zeros((3, 3))
        full[0, 1] = 1.0
        full[1] = -(frequency**2), -2.0 * damping * frequency, gain * frequency**2
        whole = expm(full * PERIOD)
        return cls(jnp.asarray(whole[:2, :2]), jnp.asarray(whole[:2, 2]))

    def start(self, output):
        return jnp.concatenate([output, jnp.zeros(1)])

    def __call__(self, state, input, period):
        return self.transition @ state + self.drive * input[0]

    def output(self, state):
        return state[:1]


class SecondOrderPlant(Lag):
    model: SecondOrder = eqx.field(default_factory=lambda: SecondOrder.sampled(gain=WRONG))

    def __call__(self, state, command, time, duration):
        return Level(self.model(state.level, command.push, duration)), jnp.array(True)


class FirstOnly(Seen):
    def __call__(self, memory, state, key):
        return memory, Level(state.level[:1])


@pytest.mark.parametrize("gain", [0.0, 1.0])
def test_a_second_order_plant_comes_to_the_analytic_state_too(gain):
    found = simulate(
        SecondOrderPlant(model=SecondOrder.sampled(gain=WRONG)),
        compensated(gain, model=SecondOrder.sampled()),
        FirstOnly(),
        start=Level(jnp.zeros(2)),
        duration=60.0,
        control_period=PERIOD,
    )
    assert found.measured_level.values[-1, 0] == pytest.approx(steady(gain), abs=1e-8)


def test_tuning_raises_the_gain_until_the_dead_zone_and_brings_the_plant_to_its_ideal():
    ideal = run(Lag(), compensated(0.0)).level.values[:, 0]
    runs = {
        "none": run(Lag(WRONG), compensated(0.0)),
        "one": run(Lag(WRONG), compensated(1.0)),
        "tuned": run(Lag(WRONG), compensated(0.0, tuning()), duration=60.0),
    }
    apart = {name: abs(one.level.values[-1, 0] - ideal[-1]) for name, one in runs.items()}
    assert apart["one"] < 0.7 * apart["none"]
    assert apart["tuned"] < 0.2 * apart["one"]
    tuned = runs["tuned"]
    gain, error = tuned.diagonal.values[-1, 0], tuned.model_error.values[-1, 0]
    assert 0.0 < error < 0.02
    assert np.all(tuned.diagonal.values[-100:, 0] == gain)
    # e = (1 - g) u_n / (1 + g K): the gain that the dead zone asks for, and no estimate beyond it
    nominal = FEEDBACK * (1.0 - tuned.level.values[-1, 0])
    assert error == pytest.approx((1.0 - WRONG) * nominal / (1.0 + WRONG * gain), rel=1e-6)
    assert gain >= ((1.0 - WRONG) * nominal / 0.02 - 1.0) / WRONG


def test_at_rest_the_estimate_is_one_more_than_the_gain_in_use_whatever_that_is():
    for gain in (0.5, 4.0):
        level = run(Lag(WRONG), compensated(gain)).level.values[-1]
        nominal = FEEDBACK * (1.0 - level)
        frit = tuning(initial_covariance=1e6, smoothing=1e-9)
        error = nominal - level

        def step(memory, _, frit=frit, error=error, nominal=nominal, gain=gain, level=level):
            input = nominal + gain * error
            return frit(memory, error=error, input=input, output=level, period=PERIOD), None

        memory, _ = jax.lax.scan(step, frit.start(jnp.asarray(level)), None, length=1500)
        assert float(memory.rows.estimate[0, 0]) == pytest.approx(gain + 1.0, abs=1e-4)


def test_a_gain_that_diverges_is_refused_where_the_theory_says():
    def flown(gain, model):
        return run(Lag(), compensated(gain, model=model), duration=1.0)

    flown(1.99 / PERIOD, Integrators())
    with pytest.raises(InputError, match="on integrators it must be below 40 1/s"):
        flown(2.01 / PERIOD, Integrators())
    kept = np.exp(-PERIOD / LAG)
    most = (1.0 + kept) / (1.0 - kept)
    flown(0.999 * most, MODEL)
    with pytest.raises(InputError, match="with which the compensator diverges"):
        flown(1.001 * most, MODEL)
    several = stack([compensated(gain) for gain in (1.0, 1.001 * most)])
    with pytest.raises(InputError, match="with which the compensator diverges"):
        simulate(
            Lag(),
            several,
            Seen(),
            start=Level(jnp.zeros(1)),
            duration=1.0,
            control_period=PERIOD,
            runs=2,
        )
    with pytest.raises(InputError, match="compensator gain: found"):
        run(Lag(), ModelErrorCompensator(Proportional(), MODEL, jnp.zeros((1, 2))))
    with pytest.raises(InputError, match="FRIT forgetting"):
        run(Lag(), compensated(0.0, tuning(forgetting=1.5)))
