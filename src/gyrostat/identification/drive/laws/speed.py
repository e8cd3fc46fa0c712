"""Speed control."""

from dataclasses import dataclass

from gyrostat.identification.drive.control_law import ControlLaw


@dataclass(frozen=True)
class SpeedControl(ControlLaw):
    """I = kp (w_r - w) + ki ∫(w_r - w) dt + feedforward dw_r/dt.

    Attributes:
        kp: Gain of the speed error, A·s/rad.
        ki: Gain of its integral, A/rad.
        feedforward: Gain of the commanded acceleration, A·s²/rad.
    """

    name = "speed"
    reference = "setpoint"

    kp: float = 0.0
    ki: float = 0.0
    feedforward: float = 0.0

    def demand(self, gains, command, state):
        """See `ControlLaw.demand`."""
        return (
            gains["kp"] * (command.speed - state[1])
            + gains["ki"] * state[2]
            + gains["feedforward"] * command.acceleration
        )

    def error(self, command, state):
        """See `ControlLaw.error`."""
        return command.speed - state[1]
