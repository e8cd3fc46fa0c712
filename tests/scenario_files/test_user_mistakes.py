"""Mistakes in own parts: each gives one line with part, finding and expectation."""

import sys

import pytest

from gyrostat.core.errors import InputError
from gyrostat.scenario_files.scenario_file import read_scenario

HEAD = """
from typing import NamedTuple
import equinox as eqx
import jax.numpy as jnp
import numpy as np

class Command(NamedTuple):
    torque: jnp.ndarray
"""
START = "return jnp.zeros(3)"
CALL = "return memory, Command(jnp.zeros(4))"


def source(call=CALL, *, start=START, fields="kp: float = 1.0", base="eqx.Module"):
    begin = f"    def start(self, period):\n        {start}\n" if start else ""
    step = f"    def __call__(self, memory, measurement):\n        {call}\n"
    return f"{HEAD}\nclass P({base}):\n    {fields}\n{begin}{step}"


FINE = {
    "module": source(),
    "plain class": source(base="object"),
    "list in a command": source("return memory, Command([0.0, 0.0, 0.0, measurement.rate[0]])"),
    "number from start": source("return 1.0, Command(jnp.zeros(4))", start="return 0.0"),
}
ONLY_IN_A_RUN = "a value that is only known in the run in `"
MISTAKES = {
    "no start": (source(start=""), "found no method start, expected start(period), which returns"),
    "no call": (
        source().partition("    def __call__")[0],
        "found no method __call__, expected __call__(memory, measurement)",
    ),
    "command only": (
        source("return Command(jnp.zeros(4))"),
        "found Command(torque) as result, expected (memory, command)",
    ),
    "command only, of two fields": (
        source("return NamedTuple('C', [('torque', int), ('x', int)])(jnp.zeros(4), 1.0)"),
        "found C(torque, x) as result, expected (memory, command)",
    ),
    "nothing returned": (source("pass"), "expected (memory, command)"),
    "shape of the memory": (
        source("return jnp.zeros(4), Command(jnp.zeros(4))"),
        "found memory of shape (4,) and type float64, expected (3,) and float64, as start returned",
    ),
    "type of the memory": (
        source("return memory + 0.5, Command(jnp.zeros(4))", start="return 0"),
        "expected () and int64, as start returned (write 0.0 for a real number)",
    ),
    "structure of the memory": (
        source("return (memory, memory), Command(jnp.zeros(4))"),
        "found a memory tuple of 2 entries, expected an array of shape (3,), as start returned",
    ),
    "text as memory": (source(start="return 'a'"), "found str as memory, expected numbers"),
    "if": (
        source("return (-memory if measurement.rate[0] > 0 else memory), Command(jnp.zeros(4))"),
        f", line 15: found if, while, and, or, min or max of {ONLY_IN_A_RUN}return (-memory if",
    ),
    "numpy": (
        source("return memory, Command(np.linalg.norm(measurement.rate) * jnp.zeros(4))"),
        f", line 15: found a NumPy function of {ONLY_IN_A_RUN}",
    ),
    "float": (
        source("return memory, Command(float(measurement.rate[0]) * jnp.zeros(4))"),
        f", line 15: found float(), int(), range() or a size from {ONLY_IN_A_RUN}",
    ),
    "length of the command": (
        source("return memory, Command(jnp.zeros(3))"),
        "found shape (3,) of command.torque, expected shape (4,)",
    ),
    "array as command": (
        source("return memory, jnp.zeros(4)"),
        "found an array of shape (4,) as command, expected a named tuple with the field torque",
    ),
    "no torque": (source("return memory, measurement"), "expected a named tuple with the field"),
    "text as torque": (source("return memory, Command('a')"), "found str as command.torque"),
    "complex torque": (source("return memory, Command(1j * jnp.zeros(4))"), "found complex"),
    "exception": (
        source("raise ValueError('boom' * 1000 + chr(10) + 'x')"),
        ", line 15: found ValueError (boomboom",
    ),
    "unknown field": (source("return memory, Command(measurement.speed)"), "no attribute 'speed'"),
    "recursion": (source("return self(memory, measurement)"), "found RecursionError"),
    "exit": (source("raise SystemExit(3)"), "found SystemExit (3)"),
    "assignment": (source("self.kp = 3.0"), "found an assignment to a field in `self.kp = 3.0`"),
    "assignment, plain class": (
        source("self.kp = 3.0", base="object"),
        "expected the value in the memory, which each call returns",
    ),
    "NaN": (
        source("return memory, Command(measurement.rate[0] / jnp.zeros(4))"),
        "found command.torque with NaN or an infinite number at the first sample",
    ),
    "NaN in the memory": (
        source("return memory / 0.0, Command(jnp.zeros(4))"),
        "found memory with NaN or an infinite number at the first sample",
    ),
    "field": (source(fields="kp: str = 'abc'"), "found kp = 'abc', expected a number or an array"),
    "field without value": (
        source(fields="kp: float"),
        "key controller.kp: found none, expected a finite number",
    ),
    "field with the name of a key": (source(fields="target: float = 1.0"), "found a field target"),
    "own __init__": (
        source(fields="def __init__(self): pass", base="object"),
        "found a method __init__, expected annotated fields such as `gain: float` instead",
    ),
    "dataclass that can change": (
        source().replace(
            "class P(eqx.Module)", "from dataclasses import dataclass\n@dataclass\nclass P"
        ),
        "found a dataclass that can change, expected @dataclass(frozen=True)",
    ),
    "arguments": (
        source().replace("memory, measurement)", "measurement)"),
        "takes 2 positional arguments but 3 were given",
    ),
    "function": ("def P(memory, measurement): pass", "found a function, expected a class"),
    "number": ("P = 3", "found int, expected a class or function"),
    "no class": ("class Q: pass", "own.py: found no P, expected one of Q"),
    "syntax": ("class P(:\n  pass", "own.py, line 1: found invalid syntax, expected Python"),
    "null byte": ("class P:\0", "found source code string cannot contain null bytes"),
    "import": ("import no_such_module\n", ", line 1: found ModuleNotFoundError"),
    "exit at import": ("import sys\nsys.exit('bye')", ", line 2: found SystemExit (bye)"),
    "exception at import": ("\n1 / 0\n", ", line 2: found ZeroDivisionError"),
    "exception with control characters": ("raise ValueError('a\\x1b[31m')", "\\x1b[31m"),
}


@pytest.fixture
def read(folder, short):
    """Reads the scenario with a text of own.py."""

    def with_text(text, *controller):
        (folder / "own.py").write_text(text)
        return read_scenario(short(*controller))

    return with_text


@pytest.mark.parametrize("text", FINE.values(), ids=FINE)
def test_own_controllers_of_several_forms_are_read(read, text):
    assert read(text).controller == "own.py:P"


@pytest.mark.parametrize(("text", "expected"), MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_gives_one_line(read, text, expected):
    with pytest.raises(InputError) as caught:
        read(text)
    message = str(caught.value)
    assert expected in message
    assert "\n" not in message
    assert len(message) <= 900
    assert "own." in message
    assert "found " in message
    assert "expected " in message


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ('python = "other.py:P"', "other.py: found no such file or directory"),
        ('python = "own.py:Q"', "own.py: found no Q, expected one of"),
        ('python = "own.py"', "found 'own.py', expected FILE.py:NAME"),
        ('python = "own:P"', "expected FILE.py:NAME"),
        ('python = "../own.py:P"', "expected a file below the folder"),
        ('python = "/etc/own.py:P"', "expected a file below the folder"),
        ('python = "linked.py:P"', "found linked.py, expected a file below the folder"),
        ('python = "own.py:P"\nkind = "lqr"', "found 'lqr', expected none beside python"),
        ('python = "own.py:P"\nkp = "abc"', "found 'abc', expected a number in SI units or with"),
        ('python = "own.py:P"\nkp = [1.0]', "key controller.kp: found [1.0], expected a finite"),
        ('python = "own.py:P"\nkp = nan', "key controller.kp: found nan"),
        ('python = "own.py:P"\nkpp = 1.0', "found an unknown key (did you mean controller.kp?)"),
        ("python = 3", "key controller.python: found 3, expected a text"),
    ],
)
def test_a_wrong_table_gives_one_line(read, folder, tmp_path, line, expected):
    (tmp_path / "linked.py").write_text(source())
    if not (folder / "linked.py").is_symlink():
        (folder / "linked.py").symlink_to(tmp_path / "linked.py")
    with pytest.raises(InputError, match=r"own\.toml: ") as caught:
        read(source(), line)
    assert expected in str(caught.value)


def test_a_local_module_from_elsewhere_is_refused(read, tmp_path, monkeypatch):
    """Workers on other machines do not have it, and it is not part of the digest."""
    (tmp_path / "elsewhere_module.py").write_text("x = 1\n")
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    with pytest.raises(
        InputError, match=r"line 1: found an import of elsewhere_module from .*, exp"
    ):
        read("import elsewhere_module\n" + source())
    with pytest.raises(InputError, match="found an import from above the folder of the scenario"):
        read("from .. import helper\n" + source())


def test_a_mistake_in_another_file_names_it(read, folder):
    (folder / "broken_helper.py").write_text("def f(x):\n    return x.no_such_field\n")
    with pytest.raises(
        InputError, match=r"own.py:P, broken_helper.py line 2: found AttributeError"
    ):
        read("from broken_helper import f\n" + source("return memory, Command(f(measurement))"))


def test_what_is_printed_goes_to_stderr(read, capsys):
    """stdout has results only."""
    read("print('hello')\n" + source(f"print('called')\n        {CALL}"))
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "hello" in captured.err
    assert "called" in captured.err


@pytest.mark.parametrize(
    ("verb", "words"), [("check", ()), ("simulate", ("--out", "run.nc")), ("campaign", ())]
)
def test_the_command_line_prints_the_line_and_exits_with_2(
    run, read, folder, verb, words, tmp_path
):
    with pytest.raises(InputError):
        read(source("return memory, Command(jnp.zeros(3))"))
    words = [tmp_path / word if word.endswith(".nc") else word for word in words]
    words += ["--runs", "2", "--out", tmp_path / "campaign"] if verb == "campaign" else []
    code, out, err = run(verb, folder / "own.toml", *words)
    assert (code, out) == (2, "")
    assert err.splitlines() == [
        f"error: {folder}/own.toml: controller own.py:P: found shape (3,) of command.torque, "
        "expected shape (4,)"
    ]
    assert not [*tmp_path.iterdir()]
