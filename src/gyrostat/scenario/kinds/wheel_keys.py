"""Keys of the wheels of a scenario, except those of their friction."""

from math import inf

from gyrostat.scenario.schema import Key, positive, size, vector

WHEEL: dict[str, Key] = {
    "speed": Key("speed", 0.0, "Initial wheel speed relative to the body."),
    "inertia": positive("inertia", None, "Inertia of the rotor about its spin axis."),
    "torque_limit": positive("torque", inf, "Largest motor torque."),
    "momentum_limit": positive("momentum", inf, "Largest momentum, rotor inertia times speed."),
}
"""Keys of each wheel, in addition to friction; all but the speed are from the spacecraft file."""
WHEEL_PARTS: dict[str, tuple[str, dict[str, Key]]] = {
    "imbalance": (
        "Static and dynamic imbalance of the wheels, which causes jitter "
        "(`gyrostat.spacecraft.ImbalancedGyrostat`). Omit the section for balanced wheels.",
        {
            "static_imbalance": size(
                "imbalance", 0.0, "Mass of the rotor times its eccentricity.", source="imbalance"
            ),
            "dynamic_imbalance": size(
                "inertia", 0.0, "Product of inertia of the rotor.", source="imbalance"
            ),
            "position": vector("length", "Position of the wheel relative to the centre of mass."),
            "angle": Key("angle", 0.0, "Initial angle of the rotor."),
        },
    ),
    "wheel_structure": (
        "Structural modes of the wheels, which amplify imbalance and harmonics "
        "(`gyrostat.spacecraft.WheelStructure`); needs `[imbalance]`. Omit the section for rigid "
        "wheels.",
        {
            "radial_frequency": positive("frequency", inf, "Frequency of the radial mode."),
            "radial_damping": positive("1", 0.01, "Damping ratio of the radial mode."),
            "rocking_frequency": positive(
                "frequency", inf, "Frequency of the rocking mode of the wheel at rest."
            ),
            "rocking_damping": positive("1", 0.01, "Damping ratio of the rocking mode at rest."),
            "inertia_ratio": size("1", 2.0, "Polar over transverse inertia of the rotor; disc: 2."),
        },
    ),
    "wear": (
        "Wear of the wheels. The null-space control of a `wheel_array` keeps the speed of a worn "
        "wheel lower, and lets it cross zero and bands less often. Omit the section for wheels "
        "without wear.",
        {
            "wear": positive("1", 1.0, "Friction over that of a wheel without wear, or a weight."),
        },
    ),
    "driver": (
        "Motor electronics: current loop, current limit and bus voltage "
        "(`gyrostat.spacecraft.DrivenGyrostat`). Omit the section for motors without lag. For a "
        "delay see `run.command_delay`. The time resolution of the lag is `run.step`.",
        {
            "motor_constant": positive("motor_constant", None, "Torque per current of the motor."),
            "time_constant": size("time", 0.0, "Time constant of the current loop; 0: no lag."),
            "current_limit": positive("current", inf, "Largest current."),
            "current_quantum": size(
                "current",
                0.0,
                "Step of the commanded current; 0: none.",
                source="quantisation of the command",
            ),
            "bus_voltage": positive("V", inf, "Bus voltage, which limits the current."),
            "resistance": size("Ω", 0.0, "Resistance of the winding."),
        },
    ),
}
"""Optional section -> its meaning, and its keys; one value for all wheels or one for each wheel."""
WHEEL_ALL = {**WHEEL, **{k: v for _, keys in WHEEL_PARTS.values() for k, v in keys.items()}}
"""All keys of a wheel except those of its friction."""
