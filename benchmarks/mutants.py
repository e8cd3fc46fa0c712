"""Mutation run: wrong factors, signs and terms in physics, control and statistics.

Each mutant is one change of one operator, constant or function in a copy of the sources. The tests
that import what was changed run first, the nearest before others, until one fails. What these do
not feel is put together into one copy, on which all tests run; those that fail there then run on
each of these mutants alone. A mutant that no test feels is a survivor.

    make mutants                                     200 mutants, about two hours of two cores
    python benchmarks/mutants.py --count 20 --seed 3 others
    python benchmarks/mutants.py --files control/guarded.py --count 1000    all of some files

Verdicts are kept in build/mutants.jsonl; a run that was stopped goes on from there. A verdict holds
for the text of its file and of the tests that ran.
"""

import argparse
import ast
import hashlib
import json
import os
import random
import subprocess
import sys
import tempfile
from collections import deque
from concurrent.futures import ThreadPoolExecutor, as_completed
from functools import cache
from pathlib import Path
from queue import SimpleQueue

ROOT = Path(__file__).parents[1]
SOURCES, TESTS = ROOT / "src", ROOT / "tests"
NUMERICAL = (
    *("wheel", "spacecraft", "simulation", "failures", "control", "estimation", "identification"),
    *("campaigns", "search", "runs/metrics", "scenario/metrics", "scenario/kinds/dispersion"),
)
"""Folders of gyrostat whose files compute numbers."""
NEAREST = 8
"""Files of tests that run alone."""
LIMIT = 100.0
"""Longest time for these, s; beyond it, the mutant is judged by all tests."""
ENDLESS = 90
"""Time after which a single test counts as one that does not end, s."""
OPTIONS = ("-p", "no:cacheprovider", "-o", f"faulthandler_timeout={ENDLESS}")
OPTIONS += ("-o", "faulthandler_exit_on_timeout=true")
VERDICTS = ROOT / "build" / "mutants.jsonl"
OPERATORS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
COMPARISONS = {ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.Gt, ast.GtE: ast.Lt}
FUNCTIONS = {
    **{"sin": "cos", "cos": "sin", "maximum": "minimum", "minimum": "maximum", "max": "min"},
    **{"min": "max", "any": "all", "all": "any", "floor": "ceil", "ceil": "floor", "exp": "expm1"},
    **{"mean": "sum", "sum": "mean", "std": "var", "var": "std", "log": "log1p"},
    **{"cumsum": "cumprod", "argmin": "argmax", "argmax": "argmin"},
}
TEXTS = (ast.JoinedStr, ast.Raise, ast.Assert, ast.Import, ast.ImportFrom)
"""Nodes in which nothing is computed."""
DROPPED = {"abs", "sqrt", "square", "conj", "negative", "sign", "absolute"}
"""Functions that a mutant leaves out."""


class Site(ast.NodeVisitor):
    """Places of a file that can be changed, each with the new nodes."""

    def __init__(self):
        self.found = []

    def generic_visit(self, node):
        for name, value in ast.iter_fields(node):
            if name in ("annotation", "returns", "decorator_list", "slice", "keywords"):
                # of keywords, the values; an index or an annotation is no physics
                value = [each.value for each in value] if name == "keywords" else []
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    self.visit(child)

    def visit_FunctionDef(self, node):
        if node.returns is None or "str" not in ast.unparse(node.returns):
            self.generic_visit(node)

    def visit(self, node):
        if not isinstance(node, TEXTS):
            super().visit(node)

    def visit_BinOp(self, node):
        new = OPERATORS.get(type(node.op))
        if new and not any(isinstance(n, ast.JoinedStr) for n in ast.walk(node)):
            self.found.append((node, ast.BinOp(node.left, new(), node.right)))
        self.generic_visit(node)

    def visit_Compare(self, node):
        new = COMPARISONS.get(type(node.ops[0]))
        if new and len(node.ops) == 1:
            self.found.append((node, ast.Compare(node.left, [new()], node.comparators)))
        self.generic_visit(node)

    def visit_UnaryOp(self, node):
        if isinstance(node.op, ast.USub) and not isinstance(node.operand, ast.Constant):
            self.found.append((node, node.operand))
        self.generic_visit(node)

    def visit_Constant(self, node):
        if type(node.value) is float and node.value != 0.0:
            self.found.append((node, ast.Constant(1.5 * node.value)))
        elif type(node.value) is int and node.value > 1:
            self.found.append((node, ast.Constant(node.value + 1)))

    def visit_Call(self, node):
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        if name in FUNCTIONS and isinstance(node.func, ast.Attribute):
            new = ast.Attribute(node.func.value, FUNCTIONS[name], ast.Load())
            self.found.append((node, ast.Call(new, node.args, node.keywords)))
        elif name in DROPPED and len(node.args) == 1:
            self.found.append((node, node.args[0]))
        self.generic_visit(node)


class Mutant:
    """One change of one file."""

    def __init__(self, path, node, new):
        text = path.read_bytes()
        starts = [0]
        for line in text.splitlines(keepends=True):
            starts.append(starts[-1] + len(line))
        self.path, self.line, self.text = path, node.lineno, text
        self.start = starts[node.lineno - 1] + node.col_offset
        self.end = starts[node.end_lineno - 1] + node.end_col_offset
        self.new = f"({ast.unparse(ast.fix_missing_locations(new))})".encode()
        self.old = " ".join(text[self.start : self.end].decode().split())

    def __str__(self):
        place = self.path.relative_to(SOURCES / "gyrostat")
        return f"{place}:{self.line}: {self.old}  ->  {self.new.decode()}"

    def applied(self, text):
        """Text of the file with this change, after changes further down."""
        return text[: self.start] + self.new + text[self.end :]


def mutants(paths):
    """All mutants of files that use arrays."""
    for path in paths:
        text = path.read_text()
        if any(word in text for word in ("numpy", "jnp", "arrays")):
            site = Site()
            site.visit(ast.parse(text))
            yield from (Mutant(path, node, new) for node, new in site.found)


def file_of(module):
    """File of a module: that of a package if it is one."""
    path = SOURCES.joinpath(*module.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


@cache
def defining(module, name):
    """File that defines a name of a module, which a package can take from elsewhere."""
    inner = file_of(f"{module}.{name}")
    if inner.exists():
        return inner
    path = file_of(module)
    stub = path.with_suffix(".pyi")
    if path.name == "__init__.py":
        for node in ast.walk(ast.parse((stub if stub.exists() else path).read_text())):
            names = getattr(node, "names", ()) if isinstance(node, ast.ImportFrom) else ()
            if name in {alias.asname or alias.name for alias in names}:
                return defining(node.module, name)
    return path


@cache
def imported(path):
    """Files of gyrostat that a file takes names from."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("gyrostat"):
            found |= {defining(node.module, alias.name) for alias in node.names}
        elif isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "gs":
            found.add(defining("gyrostat", node.attr))
    return found


def nearest_tests(path):
    """Files of tests, the nearest first: fewest imports lie between, and it imports least."""
    sources, tests = sorted(SOURCES.rglob("*.py")), sorted(TESTS.rglob("test_*.py"))
    distance, queue = {path: 0}, deque([path])
    while queue:
        here = queue.popleft()
        for user in sources:
            if user not in distance and here in imported(user):
                distance[user] = distance[here] + 1
                queue.append(user)
    ranked = {}
    for test in tests:
        near = [distance[each] for each in imported(test) if each in distance]
        if near:
            room = test.parent.name not in path.parts
            ranked[test] = min(near), test.stem != f"test_{path.stem}", room, len(imported(test))
    return sorted(ranked, key=lambda test: ranked[test])[:NEAREST]


class Copies:
    """Copies of the project in which tests run, one for each worker."""

    def __init__(self, folder, count):
        self.free = SimpleQueue()
        names = subprocess.run(
            ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True
        ).stdout.split(b"\0")
        for number in range(count):
            copy = Path(folder) / str(number)
            for name in filter(None, map(os.fsdecode, names)):
                (copy / name).parent.mkdir(parents=True, exist_ok=True)
                (copy / name).write_bytes((ROOT / name).read_bytes())
            self.free.put(copy)

    def run(self, mutated, words, limit=None):
        """Exit code and output of pytest where these mutants are; None after the limit."""
        copy = self.free.get()
        plain = {copy / mutant.path.relative_to(ROOT): mutant.text for mutant in mutated}
        try:
            for mutant in sorted(mutated, key=lambda each: -each.start):  # the last one first
                path = copy / mutant.path.relative_to(ROOT)
                path.write_bytes(mutant.applied(path.read_bytes()))
            done = subprocess.run(
                [sys.executable, "-m", "pytest", "-q", *OPTIONS, *words],
                env={**os.environ, "PYTHONPATH": str(copy / "src"), "CI": "1"},
                cwd=copy,
                capture_output=True,
                text=True,
                check=False,
                timeout=limit,
            )
            return done.returncode, done.stdout
        except subprocess.TimeoutExpired:
            return None, ""
        finally:
            for path, text in plain.items():
                path.write_bytes(text)
            self.free.put(copy)


def failed(output):
    """Tests that failed, from the summary of pytest."""
    starts = ("FAILED ", "ERROR ")
    lines = (line for line in output.splitlines() if line.startswith(starts))
    return [line.split(" ", 1)[1].partition(" - ")[0] for line in lines]


class Verdicts:
    """Verdicts of this and earlier runs, in a file."""

    def __init__(self):
        lines = VERDICTS.read_text().splitlines() if VERDICTS.exists() else []
        self.known = {row["key"]: row for row in map(json.loads, lines)}

    def add(self, key, mutant, by, *, by_all=True):
        """Keep the test that feels a mutant, or None, from the nearest tests or from all."""
        row = {"key": key, "mutant": str(mutant), "by": by, "by_all": by_all}
        self.known[key] = row
        VERDICTS.parent.mkdir(exist_ok=True)
        with VERDICTS.open("a") as stream:
            stream.write(json.dumps(row, ensure_ascii=False) + "\n")
        verdict = "felt" if by else "NOT FELT" if by_all else "not felt by the nearest tests"
        print(f"{verdict}: {mutant}" + (f"   {by}" if by else ""), flush=True)

    def key(self, mutant, tests):
        texts = mutant.text, *(test.read_bytes() for test in tests)
        about = str(mutant.start).encode(), mutant.new, *texts
        return hashlib.sha256(b"\0".join(about)).hexdigest()


def judged_near(mutant, tests, copies):
    """Test that feels a mutant, of the nearest ones; None if there is none."""
    words = [str(test.relative_to(ROOT)) for test in tests]
    code, output = copies.run([mutant], ["-x", *words], LIMIT) if words else (0, "")
    if code not in (0, None):
        return (failed(output) or ["a test that does not end"])[0]
    return None


def judge_by_all(mutants_left, copies, jobs):
    """Mutant -> test that feels it, or None, of mutants that the nearest tests do not feel."""
    if not mutants_left:
        return
    _, output = copies.run(mutants_left, ["-n", str(jobs), "tests"])
    tests = [test for test in failed(output) if "::" in test]
    print(f"all tests on {len(mutants_left)} mutants together: {len(tests)} failed", flush=True)
    if tests:
        _, output = copies.run([], ["-n", str(jobs), *tests])
        broken = set(failed(output))
        print(f"of these fail without a mutant: {', '.join(sorted(broken)) or 'none'}", flush=True)
        tests = [test for test in tests if test not in broken]
    for mutant in mutants_left:
        code, output = copies.run([mutant], ["-x", *tests]) if tests else (0, "")
        yield mutant, (failed(output) or ["?"])[0] if code else None


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=200, help="mutants")
    parser.add_argument("--seed", type=int, default=0, help="of the sample")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--files", nargs="*", default=NUMERICAL, help="files or folders")
    parser.add_argument("--near", action="store_true", help="the nearest tests only")
    given = parser.parse_args()
    paths = [SOURCES / "gyrostat" / name for name in given.files]
    files = [file for path in paths for file in (sorted(path.rglob("*.py")) or [path])]
    every = list(mutants(files))
    random.Random(given.seed).shuffle(every)
    chosen = every[: given.count]  # more of them are the same and others
    print(f"{len(chosen)} of {len(every)} mutants of {len(files)} files", flush=True)
    verdicts = Verdicts()
    near = {path: nearest_tests(path) for path in {mutant.path for mutant in chosen}}
    keys = {mutant: verdicts.key(mutant, near[mutant.path]) for mutant in chosen}
    with tempfile.TemporaryDirectory() as folder:
        copies = Copies(folder, given.jobs)
        with ThreadPoolExecutor(given.jobs) as pool:
            asked = {
                pool.submit(judged_near, mutant, near[mutant.path], copies): mutant
                for mutant in chosen
                if keys[mutant] not in verdicts.known
            }
            for done in as_completed(asked):
                verdicts.add(keys[asked[done]], asked[done], done.result(), by_all=False)
        rows = {mutant: verdicts.known[keys[mutant]] for mutant in chosen}
        left = [mutant for mutant, row in rows.items() if not (row["by"] or row["by_all"])]
        if not given.near:
            for mutant, by in judge_by_all(left, copies, given.jobs):
                verdicts.add(keys[mutant], mutant, by)
    rows = [verdicts.known[keys[mutant]] for mutant in chosen]
    felt = sum(row["by"] is not None for row in rows)
    print(f"{felt} of {len(rows)} mutants are felt: {100.0 * felt / len(rows):.1f} %")
    for mutant, row in zip(chosen, rows, strict=True):
        if row["by"] is None:
            print(f"  {mutant}")


if __name__ == "__main__":
    main()
