"""Integers that loops carry and that count the passes."""

from gyrostat.codegen.program import Assign, Block, Carried, Number


def counts_passes(carried: Carried, body: Block) -> bool:
    """Whether each pass adds 1 to a carried integer."""
    if carried.name.kind not in ("integer", "index"):
        return False
    return any(
        isinstance(s, Assign)
        and s.target is carried.next
        and s.operation == "add"
        and set(s.operands) == {carried.name, Number(carried.name.kind, 1)}
        for s in body
    )
