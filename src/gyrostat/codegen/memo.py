"""What a lowering has made so far, and may use again."""

from dataclasses import dataclass, field
from typing import Any

from gyrostat.codegen.primitives import COMMUTATIVE
from gyrostat.codegen.program import Assign, Block, Operand, Table
from gyrostat.codegen.rows import RowLoop, operand_key


@dataclass(frozen=True)
class Memo:
    """Tables, loops and results so far.

    Attributes:
        tables: Constant tables, by their kind and elements.
        loops: Loops over rows, see `row_loops`.
        closings: Arrays with scalars of rows that have become tables.
        results: Block, operation and operands -> the block, and the result. The block is kept
            alive, because the identity of a deleted one may be used again.
    """

    tables: dict[Any, Table] = field(default_factory=dict)
    loops: dict[Any, RowLoop] = field(default_factory=dict)
    closings: list[Any] = field(default_factory=list)
    results: dict[Any, tuple[Block, Operand]] = field(default_factory=dict)

    def appended(self, block: Block, statement: Assign) -> Operand:
        """Append an operation to a block; return the result of an equal one if the block has it.

        Only real numbers are shared: a test has its place in the code.
        """
        operation, target = statement.operation, statement.target
        keys = [*map(operand_key, statement.operands)]
        if operation in COMMUTATIVE:
            keys.sort(key=hash)
        key = id(block), operation, target.kind, *keys
        if target.kind == "real" and key in self.results:
            return self.results[key][1]
        self.results[key] = block, target
        block.append(statement)
        return target
