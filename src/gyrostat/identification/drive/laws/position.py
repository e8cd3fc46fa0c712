"""Position control."""

from dataclasses import dataclass

from gyrostat.identification.drive.control_law import ControlLaw


@dataclass(frozen=True)
class PositionControl(ControlLaw):
    """I = kp (q_r - q) + ki ∫(q_r - q) dt - kd w + speed_feedforward w_r + feedforward dw_r/dt.

    A cascade with the position gain k_1 (1/s) and the speed gain k_2 (A·s/rad) has kp = k_1 k_2 and
    kd = k_2. A derivative of the control error has speed_feedforward = kd.

    Attributes:
        kp: Gain of the position error, A/rad.
        ki: Gain of its integral, A/(rad·s).
        kd: Gain of the measured speed, A·s/rad.
        speed_feedforward: Gain of the commanded speed, A·s/rad.
        feedforward: Gain of the commanded acceleration, A·s²/rad.
    """

    name = "position"
    reference = "reference"

    kp: float = 0.0
    ki: float = 0.0
    kd: float = 0.0
    speed_feedforward: float = 0.0
    feedforward: float = 0.0

    def demand(self, gains, command, state):
        """See `ControlLaw.demand`."""
        return (
            gains["kp"] * (command.angle - state[0])
            + gains["ki"] * state[2]
            - gains["kd"] * state[1]
            + gains["speed_feedforward"] * command.speed
            + gains["feedforward"] * command.acceleration
        )

    def error(self, command, state):
        """See `ControlLaw.error`."""
        return command.angle - state[0]
