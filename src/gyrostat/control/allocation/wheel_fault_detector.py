"""Wheel fault detector: estimates drag on each wheel and declares failures."""

from typing import Annotated, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from gyrostat.control.allocation.allocation import Working
from gyrostat.control.allocation.drag_filter import lost_torque, low_passed
from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, limit, positive, within
from gyrostat.core.delay_line import Sent, empty_line, is_delay, pushed
from gyrostat.core.jax64 import jnp
from gyrostat.wheel.array import listed


class WheelFaultMemory(NamedTuple):
    """State of the detector between two samples.

    Attributes:
        momentum: Absolute momentum of the rotors at the last sample, (wheels,), N·m·s.
        torque: Torques commanded at the last samples, the oldest first, (delay + 1, wheels), N·m.
        drag: Lost torque after the slow low-pass filter, (wheels,), N·m.
        lost: Lost torque after the fast low-pass filter, (wheels,), N·m.
        works: Whether each wheel is taken to work, (wheels,).
        begun: Whether there has been a sample.
    """

    momentum: PerWheel
    torque: Sent
    drag: PerWheel
    lost: PerWheel
    works: Working
    begun: Bool[Array, ""]


_time = within("time at which a failure is notified", "s", lambda value: ~np.isnan(value))


class WheelFaultDetector(Checked):
    """Wheel fault detector by low-pass filters of the lost torque.

    The lost torque of a rotor is its commanded torque minus its change of momentum. A slow filter
    estimates the bearing drag, which is added to the next command. A fast filter detects a motor
    that does not respond or a rotor that seizes: if its output exceeds `failure_torque`, the wheel
    is declared failed, permanently. Choose this threshold above the bearing drag and below the
    largest commanded torques: drag compensation raises the command to a failed motor until the
    failure is detected. A wheel whose speed is not measured is neither tested nor compensated.

    Attributes:
        drag_time: Time constant of the slow filter, s.
        failure_time: Time constant of the fast filter, s.
        failure_torque: Threshold of the fast filter, (wheels,) or one for all, N·m; infinite: no
            failure is detected.
        notified: Time at which a failure is notified, (wheels,) or one for all, s; infinite: never.
        delay: Number of control periods from a sample to the start of its command, see
            `gyrostat.simulation.simulate`. A delay that is not stated here appears as a loss of
            torque.
    """

    drag_time: Annotated[Scalar, positive("drag time", "s")] = 10.0
    failure_time: Annotated[Scalar, positive("failure time", "s")] = 5.0
    failure_torque: Annotated[PerWheel | float, limit("failure torque", "N·m in every wheel")] = (
        eqx.field(converter=listed, default=np.inf)
    )
    notified: Annotated[PerWheel | float, _time] = eqx.field(converter=listed, default=np.inf)
    delay: Annotated[int, is_delay] = eqx.field(static=True, default=0)

    def start(self, count: int) -> WheelFaultMemory:
        """Initial memory, with all wheels working."""
        zero = jnp.zeros(count)
        torque = empty_line(zero, self.delay + 1)
        return WheelFaultMemory(zero, torque, zero, zero, zero == 0.0, jnp.array(False))

    def commanded(self, memory: WheelFaultMemory, torque: PerWheel) -> WheelFaultMemory:
        """Memory with the torques commanded at this sample, (wheels,), N·m."""
        return memory._replace(torque=pushed(memory.torque, torque)[0])

    def missed(self, memory: WheelFaultMemory, torque: PerWheel) -> WheelFaultMemory:
        """Memory after a missing sample; the next sample is not compared with an older one.

        Args:
            memory: Memory from the last sample.
            torque: Torques that are sent, (wheels,), N·m.
        """
        return self.commanded(memory, torque)._replace(begun=jnp.array(False))

    def __call__(
        self,
        memory: WheelFaultMemory,
        momentum: PerWheel,
        measured: Bool[Array, " wheels"],
        limit: PerWheel,
        time: Scalar,
        period: Scalar,
    ) -> WheelFaultMemory:
        """Update drag and failures with a sample.

        Args:
            memory: Memory from the last sample, with the torques commanded until then.
            momentum: Momentum of the rotors, inertia times their inertial speed, (wheels,), N·m·s.
            measured: Whether each of these is measured, (wheels,).
            limit: Torque limits, (wheels,), N·m; at most half of the limit is compensated as drag.
            time: Time of the sample, s.
            period: Time since the last sample, s.
        """
        loss, valid = lost_torque(memory, momentum, period), memory.begun & measured
        fast = low_passed(memory.lost, loss, self.failure_time, period, valid)
        failed = (jnp.abs(fast) > self.failure_torque) | (jnp.asarray(self.notified) <= time)
        works = memory.works & ~failed
        slow = low_passed(memory.drag, loss, self.drag_time, period, valid)
        drag = jnp.where(works, jnp.clip(slow, -limit / 2.0, limit / 2.0), 0.0)
        return WheelFaultMemory(momentum, memory.torque, drag, fast, works, jnp.array(True))
