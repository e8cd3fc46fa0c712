"""Integers that loops carry and that count the passes."""

from gyrostat.codegen.program import Assign, Block, Carried, Loop, Name, Number
from gyrostat.codegen.ranges import of_kind


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


def counts_of(loop: Loop) -> dict[Name, int]:
    """Integers that count the passes of a loop from a known number -> that number."""
    return {
        each.name: int(each.first.value)
        for each in loop.carried
        if counts_passes(each, loop.body)
        and isinstance(each.first, Number)
        and of_kind((int(each.first.value), int(each.first.value) + loop.count), each.name.kind)
    }


def counted(loop: Loop, name: Name, first: int) -> list[Assign]:
    """Statements whose last result is an integer that counts passes, from the loop's counter."""
    number = Name("integer", name.hint, name.group, name.place)
    from_zero = Assign(number, "to_integer", (loop.counter,), loop.source)
    if first == 0:
        return [from_zero]
    shifted = Name("integer", name.hint, name.group, name.place)
    return [from_zero, Assign(shifted, "add", (number, Number("integer", first)), loop.source)]
