"""Role that a column of a file can have in a record."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Role:
    """Role that a column can have in a record; the annotation of a field of `Record`.

    Attributes:
        name: Name of the role.
        names: Usual column names of this role, without unit, used if the caller gives no name.
        dimension: Key of `gyrostat.core.units.SI_UNIT`; None for a role without unit.
        required: Whether a file must have the column.
        unit_optional: Whether the column may be without unit.
        written: Name of the column in a written file.
        hint: What else to do if the column has no unit.
    """

    name: str
    names: tuple[str, ...]
    dimension: str | None
    required: bool = False
    unit_optional: bool = False
    written: str = ""
    hint: str = ""
