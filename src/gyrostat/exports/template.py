"""Texts of other languages with gaps, in the folder templates/."""

import re
from importlib.resources import files


def filled(template: str, **values: object) -> str:
    """Text of a template.

    Args:
        template: File name under templates/.
        values: What takes the place of each @name@.
    """
    text = files("gyrostat.exports").joinpath("templates", template).read_text(encoding="utf-8")
    return re.sub(r"@(\w+)@", lambda gap: str(values[gap[1]]), text)
