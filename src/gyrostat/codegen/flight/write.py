"""Write a program of scalars as C."""

import textwrap
from collections import Counter
from collections.abc import Mapping, Sequence

from gyrostat.codegen.dependencies import stored, used
from gyrostat.codegen.flight.constant_tables import constant_tables, declared
from gyrostat.codegen.flight.expressions import HELPERS, OF_INTEGERS, WORD, Dialect, Text, simplest
from gyrostat.codegen.flight.identifiers import comment, free_name, identifier
from gyrostat.codegen.flight.inlining import (
    hint_for,
    is_known_element,
    last_change,
    takes_in,
    uses_of,
)
from gyrostat.codegen.flight.moves import LastBranch, last_branch, moves
from gyrostat.codegen.flight.pointers import Pointers
from gyrostat.codegen.flight.tested_sums import TestedSums
from gyrostat.codegen.flight.unrolling import fills_tables
from gyrostat.codegen.program import (
    Assign,
    Block,
    Branch,
    Call,
    Fill,
    Loop,
    Name,
    Number,
    Operand,
    Statement,
    Store,
    Table,
)
from gyrostat.codegen.source import NOWHERE, Source

WIDTH = 100


class Writer:
    """Writer for the body of one function.

    Attributes:
        helpers: Operations that need a helper function in the file.
        done: Destinations of an entry's results that its body assigns.
        pointers: Pointers to structs inside the arguments.
    """

    def __init__(
        self, dialect: Dialect, reserved: set[str], shared: Mapping[Table, str] | None = None
    ) -> None:
        self.helpers: set[str] = set()
        self._dialect = dialect
        self._taken = set(reserved)
        shared = shared or {}
        self._texts: dict[Name | Table, Text] = {t: Text(n, WORD) for t, n in shared.items()}
        self._lines: list[str] = []
        self._depth = 1
        self._uses: Counter[Name] = Counter()
        self._last: LastBranch | None = None
        self.done: set[str] = set()
        self.pointers = Pointers()
        self._source: Source = NOWHERE
        self._said: set[Source] = set()
        self._reads: dict[Operand, set[Table]] = {}
        self._sums = TestedSums()

    def name(self, name: Name | Table, hint: str) -> str:
        """Assign a C name to a scalar or a table."""
        suffix = "".join(f"_{k}" for k in name.place) if isinstance(name, Name) else ""
        self._texts[name] = Text(self.free((hint or "value") + suffix), WORD)
        return self._texts[name].text

    def free(self, hint: str) -> str:
        """Unused C name."""
        text = free_name(identifier(hint), self._taken)
        self._taken.add(text)
        return text

    def text(self, operand: Operand) -> Text:
        """C expression of an operand."""
        if isinstance(operand, Number):
            return self._dialect.number(operand)
        if operand.fixed:
            return Text(self.pointers.path(operand.hint), WORD)
        return self._texts[operand]

    def line(self, text: str) -> None:
        """Add a line of C, wrapped if it is long."""
        indent = "    " * self._depth
        self._lines += textwrap.wrap(
            text,
            WIDTH,
            initial_indent=indent,
            subsequent_indent=indent + "    ",
            break_long_words=False,
            break_on_hyphens=False,
        )

    def body(self, block: Block, results: list[Operand], places: Sequence[str] = ()) -> list[str]:
        """Lines of a function's block, the results of which other lines will read.

        Args:
            block: Block of the function.
            results: Results of the function.
            places: Destinations of an entry's results; those that the lines assign are in `done`.
        """
        self._last = last_branch(block, results, places) if places else None
        for table in constant_tables(block):
            if table not in self._texts:
                name = self.name(table, f"{table.hint or 'constant'}_table")
                self.line(declared(table, name, self._dialect))
        self._uses = uses_of(block, results)
        self._block(block, results)
        return self.taken_lines()

    def taken_lines(self) -> list[str]:
        """Lines written since the last call; clears them."""
        lines, self._lines = self._lines, []
        return lines

    def _block(self, block: Block, results: list[Operand], then: Sequence[Assign] = ()) -> None:
        """Write a block; its results get names, but for one that `then` reads."""
        readers = {
            operand: position
            for position, statement in enumerate([*block, *then])
            for operand in used(statement)
            if isinstance(operand, Name)
        }
        reads = self._reads
        result_ids = {id(each) for each in results} - {id(each.operands[0]) for each in then}
        for number, statement in enumerate(block):
            self._add(self._sums.before(statement))
            if isinstance(statement, Assign):
                expression = self._expression(statement)
                reader = readers.get(statement.target)
                tables = set().union(*(reads.get(each, ()) for each in statement.operands))
                tables |= {statement.table} if statement.table is not None else set()
                target = statement.target
                is_inlined = (
                    is_known_element(statement)
                    or (
                        self._uses[target] == 1
                        and id(target) not in result_ids
                        and reader is not None
                        and takes_in([*block, *then][reader], statement, expression)
                        # a table may have other elements by then
                        and not (tables and tables & stored(block[number:reader]))
                    )
                )
                if is_inlined:
                    self._texts[target] = expression
                    reads[target] = tables
                    continue
                self._say(statement.source)
                text = self.name(statement.target, hint_for(statement, block[number + 1 :]))
                kind = self._dialect.type_of(statement.target.kind)
                self.line(f"const {kind} {text} = {expression.text};")
                self._add(self._sums.after(statement, text))
            else:
                self._say(statement.source)
                self._statement(statement)

    def _add(self, lines: list[str]) -> None:
        for text in lines:
            self.line(text)

    def _expression(self, statement: Assign) -> Text:
        operands = [self.text(operand) for operand in statement.operands]
        if statement.table is not None:
            return Text(self._element(statement.table, statement.operands), WORD)
        operation, kind = statement.operation, statement.operands[0].kind
        operation = simplest(operation, statement.operands)
        if kind == "integer":
            operation = OF_INTEGERS.get(operation, operation)
        if operation == "to_integer" and kind == "real":
            operation = "to_whole"
        if kind == "logical" and operation in ("to_integer", "to_real"):
            one, zero = (self._dialect.number(Number(statement.target.kind, k)) for k in (1, 0))
            return self._dialect.operation("select", [*operands, one, zero])
        if operation in HELPERS:
            self.helpers.add(operation)
        return self._dialect.operation(operation, operands)

    def _element(self, table: Table, indices: Sequence[Operand]) -> str:
        name = self.pointers.path(table.hint) if table.shape else self._texts[table].text
        return name + "".join(f"[{self.text(index).text}]" for index in indices)

    def _say(self, source: Source) -> None:
        if source != self._source and source != NOWHERE:
            self._lines.append("")
            # the text of a line of Python is in its first comment
            text = comment(str(source)) if source not in self._said else source.place
            self.line(f"/* {text} */")
            self._source = source
            self._said.add(source)

    def _statement(self, statement: Statement) -> None:
        kinds = self._dialect.type_of
        match statement:
            case Fill(table, values):
                name = self.name(table, f"{table.hint or 'value'}_table")
                elements = ", ".join(self.text(value).text for value in values)
                const, filled = ("const ", f" = {{{elements}}}") if values else ("", "")
                self.line(f"{const}{kinds(table.kind)} {name}[{table.size}]{filled};")
            case Store(table, indices, value):
                self.line(f"{self._element(table, indices)} = {self.text(value).text};")
            case Loop():
                self._loop(statement)
            case Branch():
                self._branch(statement)
            case Call():
                self._call(statement)
            case Assign():
                raise TypeError("an assignment is written with its block")

    def _loop(self, loop: Loop) -> None:
        kinds = self._dialect.type_of
        for each in loop.carried:
            first = self.text(each.first).text
            self.line(f"{kinds(each.name.kind)} {self.name(each.name, each.name.hint)} = {first};")
        for table in loop.stacked:
            name = self.name(table, f"{table.hint or 'value'}_table")
            self.line(f"{kinds(table.kind)} {name}[{table.size}];")
        counter = self.name(loop.counter, loop.counter.hint)
        if fills_tables(loop):  # Frama-C then knows that every element is set
            self.line(f"/*@ loop unroll {loop.count}; */")
        first = f"{kinds(loop.counter.kind)} {counter} = {self.text(loop.start).text}"
        self.line(f"for ({first}; {counter} < {loop.count}; ++{counter}) {{")
        self._depth += 1
        if loop.goes_on is not None:
            self._block(loop.test, [loop.goes_on])
            self.line(f"if (!{self.text(loop.goes_on).word()}) {{ break; }}")
        self._block(loop.body, [each.next for each in loop.carried], last_change(loop))
        self._carry(loop)
        self._depth -= 1
        self.line("}")
        self._taken.discard(counter)  # the next loop may have a counter of the same name

    def _carry(self, loop: Loop) -> None:
        assignments = [
            (self.text(e.name).text, self.text(e.next).text, self._dialect.type_of(e.name.kind))
            for e in loop.carried
        ]
        self._add(moves(assignments, self.free))

    def _branch(self, branch: Branch) -> None:
        final_branch, destinations, path = self._last, {}, self.pointers.path
        if final_branch and final_branch.branch is branch and final_branch.safe(self._texts):
            destinations = final_branch.places
            self.done = set().union(*destinations.values())
        for target in branch.targets if not destinations else ():
            name = self.name(target, target.hint)
            self.line(f"{self._dialect.type_of(target.kind)} {name};")
        index = self.text(branch.index)
        last = len(branch.blocks) - 1
        order = [1, 0] if branch.index.kind == "logical" else range(last + 1)
        for step, number in enumerate(order):
            if branch.index.kind == "logical":
                test = index.text
            else:
                test = f"{index.beside()} {'<=' if number == 0 else '=='} {number}"
            head = f"if ({test}) {{" if step == 0 else f"}} else if ({test}) {{"
            self.line("} else {" if step == last else head)
            self._depth += 1
            self._block(branch.blocks[number], branch.values[number])
            assignments = [
                (path(destination), self.text(value).text, self._dialect.type_of(target.kind))
                for target, value in zip(branch.targets, branch.values[number], strict=True)
                for destination in (destinations.get(target) or [self.text(target).text])
            ]
            self._add(moves(assignments, self.free))
            self._depth -= 1
        self.line("}")

    def _call(self, call: Call) -> None:
        arguments = [*call.function.given, *(self.text(operand).text for operand in call.operands)]
        arguments += [self._texts[table].text for table in call.function.tables]
        name = call.function.name
        if len(call.targets) == 1:
            target = call.targets[0]
            kind = self._dialect.type_of(target.kind)
            text = self.name(target, target.hint)
            self.line(f"const {kind} {text} = {name}({', '.join(arguments)});")
            return
        for target in call.targets:
            text = self.name(target, target.hint)
            self.line(f"{self._dialect.type_of(target.kind)} {text};")
            arguments.append(f"&{text}")
        self.line(f"{name}({', '.join(arguments)});")
