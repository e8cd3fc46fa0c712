"""Co-simulation unit."""

from pathlib import Path
from typing import TYPE_CHECKING

from gyrostat.verbs.arguments import Say
from gyrostat.verbs.export_format import ModuleFormat

if TYPE_CHECKING:
    from gyrostat.exports import Target


class CoSimulationUnit(ModuleFormat):
    """Co-simulation unit of FMI 2.0, with a binary if there is a C compiler."""

    name = "fmu"
    about = "co-simulation unit (FMI 2.0)"

    @classmethod
    def write(cls, target: "Target", folder: Path, say: Say) -> list[str]:
        """See `ModuleFormat.write`."""
        from gyrostat.exports import write_fmu

        name = f"{target.name}.fmu"
        if write_fmu(target, folder / name) is None:
            say("found no C compiler: the unit contains its sources only")
        return [name]
