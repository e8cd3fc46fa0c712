"""Data sheet."""

from typing import TYPE_CHECKING

from gyrostat.verbs.export_format import WheelFormat

if TYPE_CHECKING:
    from gyrostat.wheel import WheelModel


class DataSheet(WheelFormat):
    """Data sheet of the wheel in JSON."""

    name = "json"
    about = "data sheet"

    @classmethod
    def texts(cls, model: "WheelModel") -> dict[str, str]:
        """See `WheelFormat.texts`."""
        from gyrostat.exports import sheet

        return {"wheel.json": sheet(model)}
