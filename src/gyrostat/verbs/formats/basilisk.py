"""Module for Basilisk."""

from typing import TYPE_CHECKING

from gyrostat.verbs.export_format import WheelFormat

if TYPE_CHECKING:
    from gyrostat.wheel import WheelModel


class BasiliskModule(WheelFormat):
    """Python module that adds the wheel to a simulation of Basilisk."""

    name = "basilisk"
    about = "Python module"

    @classmethod
    def texts(cls, model: "WheelModel") -> dict[str, str]:
        """See `WheelFormat.texts`."""
        from gyrostat.exports import basilisk

        return {"wheel_basilisk.py": basilisk(model)}
