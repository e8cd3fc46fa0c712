"""Imbalance and further harmonics of wheels, and the jitter that they cause."""

from typing import Annotated, Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import PerWheel, Scalar, Vector3
from gyrostat.core.checked import Checked, signed, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import from_rotation_vector, product
from gyrostat.spacecraft.flexible.modes import FlexibleModes
from gyrostat.spacecraft.gyrostat import Gyrostat
from gyrostat.spacecraft.gyrostat_state import GyrostatRecord, GyrostatState
from gyrostat.spacecraft.gyrostat_wrapper import GyrostatWrapper
from gyrostat.spacecraft.jitter import Phasor, rotation_of_body
from gyrostat.spacecraft.spacecraft import Spacecraft
from gyrostat.spacecraft.wheel_harmonics import WheelHarmonics, WheelStructure
from gyrostat.spacecraft.wheel_modes import Gain
from gyrostat.wheel.array import listed


class Imbalance(Checked):
    """Static imbalance U_s, dynamic imbalance U_d and further harmonics of every wheel.

    The imbalances cause a force U_s W² and a torque U_d W² that rotate with the rotor, where W is
    the wheel speed: the fundamental harmonic of R. A. Masterson, D. W. Miller, R. L. Grogan,
    "Development and validation of reaction wheel disturbance models", Journal of Sound and
    Vibration 249 (2002).

    Attributes:
        static: Static imbalance U_s, mass times eccentricity, (wheels,), kg·m.
        dynamic: Dynamic imbalance U_d, product of inertia, (wheels,), kg·m².
        position: Wheel positions from the centre of mass, body axes, (3, wheels), m.
        harmonics: Disturbances at other multiples of the wheel speed; None for none.
        structure: Structural modes of the wheels; None for rigid wheels.
    """

    static: Annotated[PerWheel, size("static imbalance", "kg·m")] = eqx.field(converter=listed)
    dynamic: Annotated[PerWheel, size("dynamic imbalance", "kg·m²")] = eqx.field(converter=listed)
    position: Annotated[Float[Array, "3 wheels"], signed("size of a wheel's position", "m")] = (
        eqx.field(converter=listed)
    )
    harmonics: WheelHarmonics | None = None
    structure: WheelStructure | None = None

    def loads(self, axes: Any, speed: PerWheel, angle: PerWheel) -> tuple[Vector3, Vector3]:
        """Force, N, and torque about the centre of mass, N·m, on the body, in body axes.

        Args:
            axes: Spin axes, (3, wheels).
            speed: Wheel speeds relative to the body, (wheels,), rad/s.
            angle: Rotor angles, (wheels,), rad.
        """
        number, phase = self._multiples()
        turn = number[:, None] * angle + phase
        force, torque = (jnp.sum(speed**2 * x.at(turn), (0, 2)) for x in self._loads(axes, speed))
        return force, torque

    def jitter(
        self,
        spacecraft: Spacecraft,
        speed: PerWheel,
        angle: PerWheel,
        modes: FlexibleModes | None = None,
    ) -> Vector3:
        """Rotation vector of the jitter at constant wheel speeds, (3,), rad.

        Without structural and flexible modes it depends on the rotor angles only.

        Args:
            spacecraft: Spacecraft with these wheels.
            speed: Wheel speeds relative to the body, (wheels,), rad/s.
            angle: Rotor angles, (wheels,), rad.
            modes: Flexible modes of the spacecraft; None for a rigid body.
        """
        number, phase = self._multiples()
        rotation = self._rotation(spacecraft, speed, modes)
        return jnp.sum(rotation.at(number[:, None] * angle + phase), axis=(0, 2))

    def jitter_rate(
        self,
        spacecraft: Spacecraft,
        speed: PerWheel,
        angle: PerWheel,
        modes: FlexibleModes | None = None,
    ) -> Vector3:
        """Time derivative of `jitter` at constant wheel speeds, (3,), rad/s."""
        number, phase = self._multiples()
        rotation = self._rotation(spacecraft, speed, modes)
        ahead = rotation.at(number[:, None] * angle + phase + 0.5 * jnp.pi)
        return jnp.sum(number[:, None, None] * speed * ahead, axis=(0, 2))

    def peak(
        self, spacecraft: Spacecraft, speed: Any = 0.0, modes: FlexibleModes | None = None
    ) -> Vector3:
        """Largest jitter about each body axis, (3,), rad; all at their worst phase.

        Args:
            spacecraft: Spacecraft with these wheels.
            speed: Wheel speeds, (wheels,), or one value for all, rad/s.
            modes: Flexible modes of the spacecraft; None for a rigid body.
        """
        speeds = jnp.zeros(spacecraft.wheels.count) + speed
        return jnp.sum(jnp.hypot(*self._rotation(spacecraft, speeds, modes)), axis=(0, 2))

    def check_own(self) -> None:
        """Validate shapes of harmonics and structure.

        Raises:
            InputError: They have another number of wheels.
        """
        count = np.shape(self.static)[-1]
        for part in (self.harmonics, self.structure):
            if part is not None:
                part.check_wheels(count)

    def _multiples(self) -> tuple[Any, Any]:
        """Multiples of the wheel speed, (harmonics,), and phases, (harmonics, wheels), rad."""
        number, phase = jnp.ones(1), jnp.zeros((1, np.shape(self.static)[-1]))
        if self.harmonics is None:
            return number, phase
        tones = self.harmonics
        return jnp.concatenate([number, tones.number]), jnp.concatenate([phase, tones.phase])

    def _loads(self, axes: Any, speed: PerWheel) -> tuple[Phasor, Phasor]:
        """Force and torque about the centre of mass over the squared wheel speed."""
        axes = jnp.asarray(axes)
        first, second = across(axes)
        radial = Phasor(first[None], -second[None])
        force, torque = (jnp.asarray(x)[None, :] for x in (self.static, self.dynamic))
        along = jnp.zeros_like(force)
        if self.harmonics is not None:
            tones = self.harmonics
            force, torque, along = (
                jnp.concatenate([a, b])
                for a, b in ((force, tones.force), (torque, tones.torque), (along, tones.axial))
            )
        force_gain, torque_gain = Gain(force, 0.0 * force), Gain(0.0 * torque, -torque)
        if self.structure is not None:
            frequency = self._multiples()[0][:, None] * speed
            gain = self.structure.radial(frequency)
            rocking = self.structure.rocking(frequency, speed)
            force_gain = Gain(force * gain.real, force * gain.imaginary)
            torque_gain = Gain(torque * rocking.imaginary, -torque * rocking.real)
        across_axis = radial.times(force_gain)
        total = Phasor(across_axis.real + along[:, None, :] * axes, across_axis.imaginary)
        arms = [jnp.cross(jnp.asarray(self.position)[None], part, axis=1) for part in total]
        turning = radial.times(torque_gain)
        return total, Phasor(arms[0] + turning.real, arms[1] + turning.imaginary)

    def _rotation(
        self, spacecraft: Spacecraft, speed: PerWheel, modes: FlexibleModes | None
    ) -> Phasor:
        force, torque = self._loads(spacecraft.wheels.axes, speed)
        return rotation_of_body(spacecraft, modes, self._multiples()[0], speed, force, torque)


def across(axes: Any) -> tuple[Any, Any]:
    """Two unit vectors across each axis, (3, wheels) each; the second is 90° ahead of the first."""
    # the body axis farthest from the spin axis is never parallel to it
    x, y, z = jnp.abs(axes)
    by_x = (x <= y) & (x <= z)
    by_y = ~by_x & (y <= z)
    body_axis = jnp.stack([by_x, by_y, ~by_x & ~by_y]).astype(float)
    first = jnp.cross(body_axis, axes, axis=0)
    first = first / jnp.sqrt(jnp.sum(first**2, axis=0))
    return first, jnp.cross(axes, first, axis=0)


class ImbalancedGyrostat(GyrostatWrapper):
    """Gyrostat with imbalanced wheels, which cause jitter of the body.

    The momentum of an imbalance, W p(angle), is part of the total momentum. The body rate therefore
    contains the term -J^-1 W p(angle). W is the derivative of the angle, so the integral of this
    term is a function of the angle alone. The jitter is added in closed form to the motion with
    balanced wheels; the relative error is of the order of body rate over wheel speed. Nothing is
    sampled or integrated at the wheel frequency, so imbalance does not limit the control period.
    With flexible modes and structural modes of the wheels, the jitter is their steady response at
    the present wheel speeds. This holds while the frequency h W of a disturbance changes slowly
    compared with the decay of a mode near it: h dW/dt well below (z w)², with damping ratio z and
    frequency w. A faster passage through a resonance excites the mode less, and later, than this
    model. The state of the modes does not contain this part of their motion. Measurements contain
    the jitter at their time; an integrating gyro measures its mean rate.

    Attributes:
        gyrostat: Gyrostat with balanced wheels.
        imbalance: Imbalance of its wheels.
    """

    gyrostat: Gyrostat
    imbalance: Imbalance

    def check_own(self) -> None:
        """Validate shapes.

        Raises:
            InputError: The imbalance has another number of wheels, a mode of the spacecraft has no
                damping, or the mass is missing for modes with translation.
        """
        count = self.spacecraft.wheels.count
        for name in ("static", "dynamic", "position"):
            shape = np.shape(getattr(self.imbalance, name))[-1:]
            if shape != (count,):
                raise InputError(f"imbalance {name}: found {shape}, expected one of {count} wheels")
        modes = self.gyrostat.modes
        if modes is None:
            return
        if not np.all(np.asarray(modes.damping) > 0.0):
            raise InputError(
                "mode damping: found 0 with wheel imbalance, expected above 0: an undamped mode "
                "has no steady response in resonance"
            )
        if modes.translation is not None and self.spacecraft.mass is None:
            raise InputError(
                "mass of the spacecraft: found none, expected it: forces of the wheels excite "
                "modes with translation"
            )

    def start(self, *, wheel_angle: Any = 0.0, **motion: Any) -> GyrostatState:
        """Create a state from attitude, rate, wheel speeds and rotor angles.

        Args:
            wheel_angle: Rotor angles, (wheels,), or one value for all, rad.
            motion: See `Gyrostat.start`; attitude and rate without jitter.
        """
        state = self.gyrostat.start(**motion)
        angle = jnp.broadcast_to(jnp.asarray(wheel_angle, dtype=float), state.wheel_speed.shape)
        return self._turn(state._replace(wheel_angle=angle), 1.0)

    def check_state(self, state: GyrostatState) -> None:
        """Validate a state; raises `InputError`."""
        self.gyrostat.check_state(state)
        if state.wheel_angle is None:
            raise InputError("wheel_angle: found none, expected the angles of the rotors, rad")

    def rate(self, state: Any) -> Vector3:
        """Body rate with jitter, in body axes, (3,), rad/s."""
        jitter = self.imbalance.jitter_rate(
            self.spacecraft, state.wheel_speed, state.wheel_angle, self.gyrostat.modes
        )
        return self.balanced_rate(state) + jitter

    def balanced_rate(self, state: Any) -> Vector3:
        """Body rate without jitter, in body axes, (3,), rad/s."""
        return self.gyrostat.rate(self._balanced(state))

    def __call__(
        self, state: Any, command: Any, time: Scalar, duration: Scalar
    ) -> tuple[GyrostatState, Bool[Array, ""]]:
        """Integrate over an interval of constant command; see `Gyrostat`."""
        after, resolved = self.gyrostat(self._balanced(state), command, time, duration)
        # exact for constant wheel acceleration, which a constant torque gives approximately
        mean = 0.5 * (state.wheel_speed + after.wheel_speed)
        angle = state.wheel_angle + duration * mean
        return self._turn(after._replace(wheel_angle=angle), 1.0), resolved

    def _balanced(self, state: Any) -> GyrostatState:
        return self._turn(state, -1.0)._replace(wheel_angle=None)

    def _turn(self, state: GyrostatState, sense: float) -> GyrostatState:
        jitter = from_rotation_vector(sense * self._jitter(state))
        return state._replace(attitude=product(state.attitude, jitter))

    def diverged(self, state: Any) -> Bool[Array, ""]:
        """See `Gyrostat.diverged`."""
        return self.gyrostat.diverged(self._balanced(state))

    def record(self, state: Any, command: Any) -> GyrostatRecord:
        """Rate, wheel momentum and jitter at the start of a control period."""
        record = self.gyrostat.record(self._balanced(state), command)
        return record._replace(jitter=self._jitter(state))

    def _jitter(self, state: Any) -> Vector3:
        return self.imbalance.jitter(
            self.spacecraft, state.wheel_speed, state.wheel_angle, self.gyrostat.modes
        )
