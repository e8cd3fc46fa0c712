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
    """Between two samples.

    Attributes:
        momentum: (wheels,) absolute momentum of the rotors at the last sample, N·m·s.
        torque: (delay + 1, wheels) commanded at the last samples, the oldest first, N·m.
        drag: (wheels,) slow mean of what was lost, N·m.
        lost: (wheels,) quick mean of what was lost, N·m.
        works: (wheels,) which wheels are taken to work.
        begun: whether there was a sample.
    """

    momentum: PerWheel
    torque: Sent
    drag: PerWheel
    lost: PerWheel
    works: Working
    begun: Bool[Array, ""]


_time = within("time at which a failure is notified", "s", lambda value: ~np.isnan(value))


class WheelFaultDetector(Checked):
    """Two low passes of the torque that a rotor loses: commanded torque less change of momentum.

    The slow one estimates the drag of the bearing, which is added to the next command. The quick
    one detects a motor that does not respond or a rotor that seizes: above `failure_torque` the
    wheel is declared failed, for good. Choose that above the drag of the bearings and below the
    commanded torque at times: compensated drag raises the command to a dead motor until it is
    detected. A wheel whose speed is not measured is neither judged nor corrected.

    Attributes:
        drag_time: of the slow low pass, s.
        failure_time: of the quick one, s.
        failure_torque: (wheels,) or one for all, N·m; infinite: none is detected.
        notified: (wheels,) or one for all: time of a notified failure, s; infinite: never.
        delay: control periods from a sample to the start of its command, see
            `gyrostat.simulation.simulate`; a delay that is not told is taken for a loss of torque.
    """

    drag_time: Annotated[Scalar, positive("drag time", "s")] = 10.0
    failure_time: Annotated[Scalar, positive("failure time", "s")] = 5.0
    failure_torque: Annotated[PerWheel | float, limit("failure torque", "N·m in every wheel")] = (
        eqx.field(converter=listed, default=np.inf)
    )
    notified: Annotated[PerWheel | float, _time] = eqx.field(converter=listed, default=np.inf)
    delay: Annotated[int, is_delay] = eqx.field(static=True, default=0)

    def start(self, count: int) -> WheelFaultMemory:
        """Nothing measured yet, all wheels working."""
        none = jnp.zeros(count)
        torque = empty_line(none, self.delay + 1)
        return WheelFaultMemory(none, torque, none, none, none == 0.0, jnp.array(False))

    def commanded(self, memory: WheelFaultMemory, torque: PerWheel) -> WheelFaultMemory:
        """Take in what is commanded at this sample, (wheels,), N·m."""
        return memory._replace(torque=pushed(memory.torque, torque)[0])

    def missed(self, memory: WheelFaultMemory, torque: PerWheel) -> WheelFaultMemory:
        """Memory after a sample that is missing: the next one is not compared with an older one.

        Args:
            memory: from the last sample.
            torque: (wheels,) that is sent, N·m.
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
        """Take in a sample.

        Args:
            memory: from the last sample, with the torques commanded up to there.
            momentum: (wheels,) of the rotors, inertia times their speed in space, N·m·s.
            measured: (wheels,) which of these are measured.
            limit: (wheels,) of the torques, N·m: no drag beyond half of it is made up for.
            time: of the sample, s.
            period: since the last one, s.
        """
        lost, judged = lost_torque(memory, momentum, period), memory.begun & measured
        quick = low_passed(memory.lost, lost, self.failure_time, period, judged)
        failed = (jnp.abs(quick) > self.failure_torque) | (jnp.asarray(self.notified) <= time)
        works = memory.works & ~failed
        slow = low_passed(memory.drag, lost, self.drag_time, period, judged)
        drag = jnp.where(works, jnp.clip(slow, -limit / 2.0, limit / 2.0), 0.0)
        return WheelFaultMemory(momentum, memory.torque, drag, quick, works, jnp.array(True))
