"""Integers that loops carry, whose range follows from the number of passes."""

from gyrostat.codegen.program import Assign, Block, Carried, Loop, Name, Number


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


def is_number_of_a_pass(carried: Carried, loop: Loop) -> bool:
    """Whether each pass keeps a carried integer or replaces it by the number of the pass."""
    if carried.name.kind != "integer":
        return False
    made = {s.target: s for s in loop.body if isinstance(s, Assign)}

    def by(operand: object, operation: str) -> Assign | None:
        found = made.get(operand) if isinstance(operand, Name) else None
        return found if found is not None and found.operation == operation else None

    chosen = by(carried.next, "select")
    if chosen is None:
        return False
    others = {operand for operand in chosen.operands[1:] if operand is not carried.name}
    number = by(next(iter(others)), "to_integer") if len(others) == 1 else None
    return number is not None and number.operands == (loop.counter,)
