"""Control laws of magnetic torque rods."""
