"""Control laws of magnetic torque rods."""

__all__: list[str] = []
