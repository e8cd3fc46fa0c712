"""Array types, units, errors, small linear algebra, rotations, validation and files."""

__all__: list[str] = []
