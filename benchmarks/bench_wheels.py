"""Virtual bench records of wheels with torque ripple, friction drift and a tachometer lag.

An integrator of its own, independent of `gyrostat.wheel`: midpoint steps of 1 ms, a wheel that
changes sense rests for the remainder of the step.
"""

from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import RPM
from gyrostat.telemetry import Record

Size = float | np.ndarray

INERTIA, STRIBECK_SPEED, RATE, DURATION, STEP = 1.5e-3, 0.4189, 10.0, 300.0, 1e-3
NAMES = ("motor_constant", "viscous", "coulomb", "static")


@dataclass(frozen=True)
class Effects:
    """What distinguishes a record from the model plus white noise.

    Sizes are one number for all records or one for each.

    Attributes:
        ripple: Amplitude of the once-per-turn torque ripple, share of the Coulomb torque; a second
            harmonic of random order has half of it.
        drift: Largest change of the viscous coefficient from its mean, share.
        lag: Time constant of the tachometer, s.
        speed_sigma: Noise of the tachometer, rad/s.
        drift_shape: "linear" or "sine" (one and a half periods over the record).
        offset: True minus recorded current, A.
        asymmetry: Part of the dry friction that acts in one direction of the torque, share of the
            Coulomb torque.
        dry_drift: Largest change of the dry friction from its mean, linear, share.
        second: Amplitude of the second harmonic over that of the ripple.
    """

    ripple: Size = 0.0
    drift: Size = 0.0
    lag: Size = 0.0
    speed_sigma: float = 5.0 * RPM
    drift_shape: str = "linear"
    offset: Size = 0.0
    asymmetry: Size = 0.0
    dry_drift: Size = 0.0
    second: float = 0.5


NOISE_ONLY = Effects()
USUAL = Effects(ripple=0.05, drift=0.1, lag=0.05)


@lru_cache
def simulator():
    """Compile the speeds of wheels, (count, N), from their parameters, currents and drifts."""
    substeps = round(1.0 / (RATE * STEP))

    def lane(wheel, current, drift, dry_drift):
        motor, inertia, viscous, coulomb, static, ripple, order, phase, second, lag = wheel[:10]
        offset, asymmetry, share = wheel[10:]

        def waves(angle):
            return ripple * (jnp.sin(angle + phase) + share * jnp.sin(order * angle + second))

        def acceleration(speed, angle, direction, load, damping, dry):
            bend = jnp.exp(-((speed / STRIBECK_SPEED) ** 2))
            level = dry * (coulomb + (static - coulomb) * bend) * (1.0 + direction * asymmetry)
            friction = direction * level + damping * speed
            return (load + waves(angle) - friction) / inertia

        def substep(_, carry, load, damping, dry):
            speed, angle, shown = carry
            drive = load + waves(angle)
            breakaway = dry * static * (1.0 + jnp.sign(drive) * asymmetry)
            rests = (speed == 0.0) & (jnp.abs(drive) <= breakaway)
            direction = jnp.where(speed == 0.0, jnp.sign(drive), jnp.sign(speed))
            rate = acceleration(speed, angle, direction, load, damping, dry)
            half = speed + 0.5 * STEP * rate
            middle = angle + 0.5 * STEP * speed
            end = speed + STEP * acceleration(half, middle, direction, load, damping, dry)
            end = jnp.where(rests | (end * direction < 0.0), 0.0, end)
            # exact for a speed that is a straight line over the step
            mean = 0.5 * (speed + end)
            decay = jnp.where(lag > 0.0, jnp.exp(-STEP / jnp.where(lag > 0.0, lag, 1.0)), 0.0)
            return end, angle + STEP * mean, mean + (shown - mean) * decay

        def sample(carry, entry):
            load, damping = motor * (entry[0] + offset), viscous * (1.0 + entry[1])
            step = partial(substep, load=load, damping=damping, dry=1.0 + entry[2])
            carry = jax.lax.fori_loop(0, substeps, step, carry)
            return carry, jnp.where(lag > 0.0, carry[2], carry[0])

        zero = jnp.zeros(())
        entries = (current[:-1], drift[:-1], dry_drift[:-1])
        shown = jax.lax.scan(sample, (zero, zero, zero), entries)[1]
        return jnp.concatenate([zero[None], shown])

    return jax.jit(jax.vmap(lane))


def records(
    seed: int,
    count: int,
    effects: Effects,
    tolerance: float = 0.0,
    duration: float = DURATION,
    least_rise: float = 1.02,
) -> list[tuple[Record, dict[str, float], dict[str, float]]]:
    """Records of wheels with dispersed parameters.

    Args:
        seed: Of all random numbers.
        count: Number of records.
        effects: What the records contain beyond white noise.
        tolerance: Standard deviation of the true inertia and of the current scale, shares.
        duration: Of each record, s.
        least_rise: Smallest static torque over the Coulomb torque.

    Returns:
        Record; true parameters, SI, of one that drifts its mean over the record; and those that it
        shows at the nominal inertia and current scale, by the exact scaling law.
    """
    random = np.random.default_rng(seed)
    time = np.arange(round(duration * RATE) + 1) / RATE
    step = np.minimum(np.floor(time / 30.0 + 1e-9).astype(int), round(duration / 30.0) - 1)
    inertia = INERTIA * (1.0 + tolerance * random.standard_normal(count))
    scale = 1.0 + tolerance * random.standard_normal(count)
    motor = 0.0228 * random.uniform(0.8, 1.25, count)
    viscous = 4.83e-6 * random.uniform(0.6, 1.6, count)
    coulomb = 0.8795e-3 * random.uniform(0.7, 1.4, count)
    static = coulomb * random.uniform(least_rise, 1.3, count)
    levels = random.uniform(1.55, 3.9, (count, step[-1] + 1)) * (-1.0) ** np.arange(step[-1] + 1)
    current = (coulomb / motor)[:, None] * levels[:, step]
    share = time / duration
    if effects.drift_shape == "linear":
        shape = (2.0 * share - 1.0)[None] * random.choice([-1.0, 1.0], (count, 1))
    else:
        shape = np.sin(3.0 * np.pi * share[None] + random.uniform(0.0, 6.283, (count, 1)))
    shape = shape - shape.mean(axis=1, keepdims=True)

    def each(size: Size) -> np.ndarray:
        return np.broadcast_to(size, (count,))

    drift = each(effects.drift)[:, None] * shape
    dry_drift = each(effects.dry_drift)[:, None] * (2.0 * share - 1.0)
    wheel = np.column_stack(
        [
            motor,
            inertia,
            viscous,
            coulomb,
            static,
            effects.ripple * coulomb,
            random.integers(2, 9, count),
            random.uniform(0.0, 6.283, count),
            random.uniform(0.0, 6.283, count),
            each(effects.lag),
            each(effects.offset),
            each(effects.asymmetry),
            each(effects.second),
        ]
    )
    speed = np.asarray(simulator()(wheel, current, drift, dry_drift))
    noise = effects.speed_sigma * random.standard_normal(speed.shape)
    truth = np.column_stack([motor, viscous, coulomb, static])
    apparent = truth * (INERTIA / inertia)[:, None]
    apparent[:, 0] *= scale
    return [
        (
            Record(f"{seed}-{k}", time, current[k] / scale[k], speed[k] + noise[k], time >= 0.0),
            dict(zip(NAMES, truth[k].tolist(), strict=True)),
            dict(zip(NAMES, apparent[k].tolist(), strict=True)),
        )
        for k in range(count)
    ]
