"""Formats that `export` knows, found in their folder."""

from collections.abc import Mapping

from gyrostat.core.classes_of import classes_of
from gyrostat.verbs import formats as folder
from gyrostat.verbs.export_format import CodeFormat, ExportFormat, WheelFormat

FORMATS: Mapping[str, type[ExportFormat]] = {
    kind.name: kind for kind in sorted(classes_of(folder, ExportFormat), key=lambda k: k.name)
}
"""Name on the command line -> format."""
CODE = " or ".join(name for name, kind in FORMATS.items() if issubclass(kind, CodeFormat))
"""Names of the formats of code, for messages."""
OF_PARTS = " or ".join(name for name, kind in FORMATS.items() if not issubclass(kind, WheelFormat))
"""Names of the formats of a part, for messages."""
