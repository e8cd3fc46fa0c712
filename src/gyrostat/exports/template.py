"""Templates of texts in other languages, from the folder templates/."""

import re
from importlib.resources import files


def filled(template: str, **values: object) -> str:
    """Text of a template with its placeholders replaced.

    Args:
        template: File name under templates/.
        values: Name -> text that replaces @name@.
    """
    text = files("gyrostat.exports").joinpath("templates", template).read_text(encoding="utf-8")
    return re.sub(r"@(\w+)@", lambda gap: str(values[gap[1]]), text)
