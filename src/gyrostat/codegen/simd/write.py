"""Write C in which each scalar of a program is a vector with one run in each lane.

Values that are the same for all runs remain single numbers. A branch on which the lanes differ
executes both blocks and selects the results. A loop continues while any lane does, and changes only
the values of those lanes.
"""

from collections.abc import Mapping, Sequence

from gyrostat.codegen.program import (
    Assign,
    Block,
    Branch,
    Fill,
    Loop,
    Name,
    Number,
    Operand,
    Statement,
    Store,
    Table,
)
from gyrostat.codegen.simd.operations import (
    BOUND,
    INFIX,
    MOST_COMMON,
    ONE,
    VECTOR,
    case_test,
    converted,
    number,
    on_one,
    shared_word,
)


class Writer:
    """Writer for the body of one function; `lines` are the lines so far."""

    def __init__(self, varying: set[Name | Table]) -> None:
        self.lines: list[str] = []
        self._varying = varying
        self._texts: dict[Name | Table, str] = {}
        self._kept: Mapping[Table, Sequence[tuple[str, int]]] = {}
        self._depth, self._common = 1, 0
        self._active: str | None = None
        self._declared_in: dict[Table, str | None] = {}

    def parameters(self, shared: Mapping[Name, int], own: Mapping[Name, int]) -> None:
        """Declare the parameters shared by all runs and those that differ, with their words."""
        for name, word in shared.items():
            self._declare(name, shared_word(name.kind, str(word)), constant=True)
        for name, word in own.items():
            logical = name.kind == "logical"
            text = f"OWN({'integer' if logical else VECTOR[name.kind]}, {word})"
            self._declare(name, f"mask_of_integer({text})" if logical else text, constant=True)

    def constants(self, tables: Sequence[Table]) -> str:
        """Definitions of constant tables, which stand before the function."""
        texts = []
        for table in tables:
            elements = ", ".join(number(Number(table.kind, each)) for each in table.values)
            head = f"TABLE {ONE[table.kind]} {self._new(table)}[{table.size}]"
            texts.append(f"{head} = {{{elements}}};\n")
        return "".join(texts)

    def results(self, results: Sequence[Operand]) -> None:
        """Store results one after the other."""
        for word, result in enumerate(results):
            self._store("made", str(word), result)

    def block(self, block: Block, kept: Mapping[Table, Sequence[tuple[str, int]]]) -> None:
        """Write statements; `kept` gives the memory and position of each kept table."""
        self._kept = kept
        self._block(block)

    def _line(self, text: str) -> None:
        self.lines.append("    " * self._depth + text)

    def _store(self, memory: str, index: str, value: Operand) -> None:
        kind, text = VECTOR[value.kind], self._lanes(value)
        if value.kind == "logical":
            kind, text = "integer", f"integer_of_mask({text})"
        self._line(f"PUT({kind}, {memory}, {index}, {text});")

    def _new(self, variable: Name | Table) -> str:
        self._texts[variable] = f"v{len(self._texts)}"
        return self._texts[variable]

    def _type(self, variable: Name | Table) -> str:
        return (VECTOR if variable in self._varying else ONE)[variable.kind]

    def _declare(self, name: Name, value: str, *, constant: bool) -> None:
        const = "const " if constant else ""
        self._line(f"{const}{self._type(name)} {self._new(name)} = {value};")

    def _assign(self, name: Name, value: str) -> None:
        """Declare a result; outside loops, real numbers common to all runs by a macro."""
        is_common = name.kind == "real" and self._is_one(name) and self._depth == 1
        self._common += is_common
        if is_common and self._common <= MOST_COMMON:
            self._line(f"COMMON({ONE[name.kind]}, {self._new(name)}, {value});")
        else:
            self._declare(name, value, constant=True)

    def _text(self, operand: Operand) -> str:
        """C expression of an operand, as one number or as lanes."""
        if isinstance(operand, Name):
            return self._texts[operand]
        return number(operand)

    def _lanes(self, operand: Operand) -> str:
        """C expression of an operand as lanes; a single number is broadcast."""
        if isinstance(operand, Name) and operand in self._varying:
            return self._texts[operand]
        return f"all_{VECTOR[operand.kind]}({self._text(operand)})"

    def _for(self, variable: Name | Table, operand: Operand) -> str:
        """C expression of an operand for a name or table: lanes if that varies between runs."""
        return self._lanes(operand) if variable in self._varying else self._text(operand)

    def _is_one(self, *operands: Operand) -> bool:
        return not any(operand in self._varying for operand in operands)

    def _block(self, block: Block) -> None:
        for statement in block:
            self._statement(statement)

    def _statement(self, statement: Statement) -> None:
        match statement:
            case Assign(target):
                self._assign(target, self._expression(statement))
            case Fill(table, values):
                elements = ", ".join(self._for(table, value) for value in values)
                const, filled = ("const ", f" = {{{elements}}}") if values else ("", "")
                head = f"{const}{self._type(table)} {self._new(table)}[{table.size}]"
                self._line(f"{head}{filled};")
                self._declared_in[table] = self._active
            case Store(table, (index,), value):
                if table.kept:
                    for memory, first in self._kept[table]:
                        if memory == "asked":
                            self._line("if (asked)")
                        self._store(memory, f"{first} + {self._text(index)}", value)
                else:
                    self._set_element(table, index, value)
            case Loop():
                self._loop(statement)
            case Branch():
                self._branch(statement)
            case _:
                raise TypeError(f"found {type(statement).__name__}, expected it lowered in place")

    def _set_element(self, table: Table, index: Operand, value: Operand) -> None:
        """Assign an element, in the lanes that are active if others may read the table later."""
        is_masked = self._active != self._declared_in[table] and table in self._varying
        name = self._texts[table]
        if self._is_one(index):
            element, text = f"{name}[{self._text(index)}]", self._for(table, value)
            if is_masked:
                text = f"select_{VECTOR[table.kind]}({self._active}, {text}, {element})"
            self._line(f"{element} = {text};")
            return
        active = self._active if is_masked else "all_mask(true)"
        arguments = f"{name}, {self._text(index)}, {self._lanes(value)}, {active}"
        self._line(f"set_{VECTOR[table.kind]}({arguments});")

    def _expression(self, statement: Assign) -> str:
        target, operation, operands = statement.target, statement.operation, statement.operands
        if statement.table is not None:
            return self._element(statement.table, *operands)
        if target not in self._varying:
            return on_one(operation, operands, [self._text(o) for o in operands])
        if operation == "select":
            test, yes, no = operands
            if self._is_one(test):
                return f"{self._text(test)} ? {self._lanes(yes)} : {self._lanes(no)}"
            arguments = ", ".join(self._lanes(operand) for operand in operands)
            return f"select_{VECTOR[target.kind]}({arguments})"
        if operation in INFIX and operands[0].kind != "logical":
            # C broadcasts a number that is combined with lanes
            return f" {INFIX[operation]} ".join(self._text(operand) for operand in operands)
        if operation in BOUND and target.kind == "real":
            for bound, value in (operands, operands[::-1]):
                if isinstance(bound, Number) and bound.value == bound.value:
                    return f"{BOUND[operation]}({self._text(bound)}, {self._lanes(value)})"
        texts = [self._lanes(operand) for operand in operands]
        if operation == "shift_right":
            return f"({VECTOR[target.kind]})((bits){texts[0]} >> (bits){texts[1]})"
        if operation in ("neg", "not") and operands[0].kind != "logical":
            return f"{'-' if operation == 'neg' else '~'}{texts[0]}"
        return converted(operation, operands[0].kind, texts[0]) or (
            f"{operation}_{VECTOR[operands[0].kind]}({', '.join(texts)})"
        )

    def _input(self, table: Table, index: Operand, offset: Number) -> str:
        """C expression of an element of a table in the memory of the inputs."""
        start, kind = table.start + int(offset.value), VECTOR[table.kind]
        if not self._is_one(index):
            text = f"{table.memory}_words({table.memory}, {start}, {self._text(index)})"
            return f"as_real((integer){text})" if kind == "real" else f"({kind}){text}"
        position = f"{start} + {self._text(index)}"
        if table.memory == "shared":
            return shared_word(table.kind, position)
        return f"OWN({kind}, {position})"

    def _element(self, table: Table, index: Operand, *offset: Operand) -> str:
        if offset:
            return self._input(table, index, *offset)  # pyright: ignore[reportArgumentType]
        name = self._texts[table]
        if self._is_one(index):
            return f"{name}[{self._text(index)}]"
        memory = "own" if table in self._varying else "shared"
        return f"{memory}_{VECTOR[table.kind]}({name}, {self._text(index)})"

    def _carry_in(self, loop: Loop) -> None:
        for each in loop.carried:
            self._declare(each.name, self._for(each.name, each.first), constant=False)
        for table in loop.stacked:
            if not table.kept:
                self._line(f"{self._type(table)} {self._new(table)}[{table.size}];")
                self._declared_in[table] = self._active

    def _loop(self, loop: Loop) -> None:
        self._carry_in(loop)
        counter, before = self._new(loop.counter), self._active
        alive = None
        if loop.goes_on is None:
            first = f"int64_t {counter} = {self._text(loop.start)}"
            align = " ALIGN;" if self._depth == 1 else ""
            self._line(f"for ({first}; {counter} < {loop.count}; ++{counter}) {{{align}")
        else:
            if loop.goes_on in self._varying:
                alive = f"alive_{counter}"
                self._line(f"mask {alive} = {before or 'all_mask(true)'};")
            self._line("for (;;) {")
        self._depth += 1
        if loop.goes_on is not None:
            self._block(loop.test)
            goes_on = self._text(loop.goes_on)
            if alive is None:
                self._line(f"if (!{goes_on}) break;")
            else:
                self._line(f"{alive} = and_mask({alive}, {goes_on});")
                self._line(f"if (!any({alive})) break;")
                self._active = alive
        self._block(loop.body)
        self._carry(loop, alive)
        self._active = before
        self._depth -= 1
        self._line("}")

    def _carry(self, loop: Loop, alive: str | None) -> None:
        names = {each.name for each in loop.carried}
        assignments = []
        for each in loop.carried:
            if each.next is each.name:
                continue
            after, name = self._for(each.name, each.next), self._text(each.name)
            if each.next in names:
                self._line(f"const {self._type(each.name)} next_{name} = {after};")
                after = f"next_{name}"
            if each.name in self._varying and alive is not None:
                after = f"select_{VECTOR[each.name.kind]}({alive}, {after}, {name})"
            assignments.append(f"{name} = {after};")
        for text in assignments:
            self._line(text)

    def _branch(self, branch: Branch) -> None:
        # the values of the first empty block are the defaults and need no test
        empty = next((k for k, block in enumerate(branch.blocks) if not block), None)
        for k, target in enumerate(branch.targets):
            text = "{0}" if empty is None else self._for(target, branch.values[empty][k])
            self._line(f"{self._type(target)} {self._new(target)} = {text};")
        last = len(branch.blocks) - 1
        is_one, before = self._is_one(branch.index), self._active
        for case, block in enumerate(branch.blocks):
            if case == empty:
                continue
            condition = case_test(branch.index.kind, self._text(branch.index), is_one, case, last)
            if is_one:
                self._line(f"if ({condition}) {{")
            else:
                name = f"here_{len(self.lines)}"
                condition = f"and_mask({before}, {condition})" if before else condition
                self._line(f"const mask {name} = {condition};")
                test = f"any({name})"
                self._line(f"if ({test if empty is None else f'SELDOM({test})'}) {{")
                self._active = name
            self._depth += 1
            self._block(block)
            for target, value in zip(branch.targets, branch.values[case], strict=True):
                name = self._text(target)
                text = self._for(target, value)
                if not is_one and target in self._varying:
                    text = f"select_{VECTOR[target.kind]}({self._active}, {text}, {name})"
                self._line(f"{name} = {text};")
            self._active = before
            self._depth -= 1
            self._line("}")
