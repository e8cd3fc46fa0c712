"""Attitude control of an Earth observation satellite: wheels, unloaded by torque rods.

Quaternion feedback follows the reference with its rate and acceleration. A wheel that does not
respond is no longer used. The rods take momentum from the wheels.
"""

from typing import Annotated, Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp

import gyrostat as gs
from gyrostat.control import PseudoInverse, WheelFaultDetector
from gyrostat.control.allocation.allocation import within_limits
from gyrostat.core.rotations import error, to_body


class Command(NamedTuple):
    """Command of wheels and rods."""

    torque: Any  # motor torques, (wheels,), N·m
    torque_rods: Any  # dipole moments, (3,), A·m²
    works: Any  # wheels that are used, (wheels,)


class Memory(NamedTuple):
    """Memory between samples."""

    detector: Any
    period: Any


class MissionControl(eqx.Module):
    """Attitude control by wheels, with unloading by rods."""

    bandwidth: Annotated[float, gs.Key("rad/s", least=0.0, positive=True)] = 0.3
    damping: float = 0.8
    largest_error: Annotated[float, gs.Key("rad", least=0.0, positive=True)] = 0.2
    unloading: Annotated[float, gs.Key("1/s", least=0.0)] = 5e-3
    dipole_limit: Annotated[float, gs.Key("A·m²", least=0.0)] = 0.4
    failure_torque: Annotated[float, gs.Key("N·m", least=0.0, positive=True)] = 4e-4
    spacecraft: Any = None  # given
    reference: Any = None  # given

    def start(self, period):
        detector = self.detector.start(self.spacecraft.wheels.count)
        return Memory(detector, jnp.asarray(period))

    @property
    def detector(self):
        return WheelFaultDetector(failure_time=1.0, failure_torque=self.failure_torque)

    def __call__(self, memory, measurement):
        wheels = self.spacecraft.wheels
        axes, inertia = jnp.asarray(wheels.axes), jnp.asarray(wheels.inertia)
        rate, speed = measurement.rate, measurement.wheel_speed
        detector = self.detector(
            memory.detector,
            inertia * (speed + axes.T @ rate),
            measurement.wheel_measured,
            jnp.asarray(wheels.torque_limit),
            measurement.time,
            memory.period,
        )
        momentum = axes @ (inertia * speed)
        rods = self.dipole(measurement.magnetometer, momentum)
        torque = self.torque(measurement, momentum, memory.period)
        torque = torque - jnp.cross(rods, measurement.magnetometer)
        motors = PseudoInverse()(axes, wheels.torque_limit, detector.works, -torque)
        motors = within_limits(motors + detector.drag, jnp.asarray(wheels.torque_limit))
        memory = Memory(self.detector.commanded(detector, motors), memory.period)
        return memory, Command(motors, rods, detector.works)

    def torque(self, measurement, momentum, period):
        """Torque on the body, (3,), N·m, in the middle of the period in which it acts."""
        inertia, rate = self.spacecraft.inertia_locked(), measurement.rate
        now = self.reference(measurement.time)
        soon = self.reference(measurement.time + 0.5 * period)
        turned = error(measurement.attitude, now.attitude)
        angle = 2.0 * turned[1:]
        size = jnp.sqrt(angle @ angle)
        angle = angle * self.largest_error / jnp.maximum(size, self.largest_error)
        slip = rate - to_body(turned, now.rate)
        wanted = to_body(turned, soon.acceleration)
        wanted = wanted - self.bandwidth**2 * angle - 2.0 * self.damping * self.bandwidth * slip
        return inertia @ wanted + jnp.cross(rate, inertia @ rate + momentum)

    def dipole(self, field, momentum):
        """Dipole moments whose torque m x B takes momentum from the wheels, (3,), A·m²."""
        wanted = self.unloading * jnp.cross(momentum, field) / jnp.maximum(field @ field, 1e-12)
        return jnp.clip(wanted, -self.dipole_limit, self.dipole_limit)
