"""Data sheet of a wheel as JSON: each value with unit and uncertainty."""

import json

from gyrostat.core.units import si_unit
from gyrostat.wheel import WheelModel


def sheet(model: WheelModel) -> str:
    """Text of a JSON data sheet.

    Args:
        model: Content of a model file.

    Returns:
        {"friction": {"model", "title", "equation"}, "parameters": {NAME: {"value", "sigma",
        "unit"}}, "origin"}; sigma is null if it is unknown. A wheel that its identification marked
        has "impossible", the reason, in addition.
    """
    content = {
        "friction": {
            "model": model.friction.name,
            "title": model.friction.title,
            "equation": (model.friction.__doc__ or "").partition("\n")[0],
        },
        "parameters": {
            name: {
                "value": model.values[name],
                "sigma": model.sigma.get(name),
                "unit": si_unit(dimension),
            }
            for name, dimension in model.dimensions().items()
            if name in model.values
        },
        "origin": dict(model.origin),
        **({"impossible": model.impossible} if model.impossible else {}),
    }
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"
