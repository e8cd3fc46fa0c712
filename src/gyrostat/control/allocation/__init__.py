"""Distribution of torque over wheels: allocation, null space, unloading, fault detection."""
