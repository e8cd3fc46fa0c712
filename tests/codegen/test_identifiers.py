"""Names of users' fields, keys and classes in C: a compiler takes every one, as C and as C++."""

import re
import shutil
import subprocess
import sys
from collections import namedtuple
from enum import IntEnum
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from gyrostat.codegen.flight import Entry, emit
from gyrostat.codegen.flight.identifiers import identifier, member_names, public_identifier
from gyrostat.core.jax64 import jax, jnp

HEADERS = "".join(
    f"#include <{name}.h>\n"
    for name in ("float", "math", "stdbool", "stddef", "stdint", "stdio", "stdlib", "string")
)
NAMES = """
auto break case char const continue default do double else enum extern float for goto if inline int
long register restrict return short signed sizeof static struct switch typedef union unsigned void
volatile while _Bool _Complex _Imaginary _Generic _Alignas _Atomic _Static_assert _Thread_local
and and_eq or or_eq not not_eq xor xor_eq bitand bitor compl new this delete operator template
typename namespace private public protected class virtual friend using try catch throw explicit
export mutable nullptr constexpr decltype noexcept alignas thread_local typeid wchar_t asm
typeof true false bool NAN INFINITY HUGE_VAL HUGE_VALF INT64_MAX INT8_MIN UINT64_C EOF NULL errno
M_PI M_1_PI DBL_MAX FLT_EPSILON SEEK_SET stdin unix linux int64_t int32_t size_t offsetof
GYROSTAT_NAMES_H __LINE__ __x _K _ isnan y0 sin status main double_ double__2 NAN_
x-y x_y x.y ω θ ϑ omega Ω Δθ λ größe naïve е 中 文 ∂ ∇ 1st _1 item_1st
"""
WORDS = NAMES.split()
CLASSES = {
    "controller": namedtuple("controller", "a b"),
    "controller_step": namedtuple("controller_step", "a c"),
    "memory": namedtuple("memory", "a d"),
    "output": namedtuple("output", "a e"),
    "gamma": namedtuple("gamma", "a f"),
    "div": namedtuple("div", "a g"),
    "FILE": namedtuple("FILE", "a h"),
    "new": namedtuple("new", "a i"),
    "Größe": namedtuple("Größe", "ä ö"),
    "hypot": namedtuple("hypot", "a j"),
    "vector": namedtuple("vector", "a k"),
    "NAN": namedtuple("NAN", "a l"),
    "largest": namedtuple("largest", "smallest sense"),
}


@jax.jit
def hypot(x, y):
    """A function of the user with the name of one of math.h."""
    return jnp.sqrt(jnp.maximum(x * x, 1.0) + y * y) + jnp.where(x > y, jnp.exp(x), jnp.tanh(y))


def controller_step(memory, x):
    """Another factor for each field, so that exchanged fields have other values."""
    leaves, tree = jax.tree.flatten(memory)
    factors = 1.0 + jnp.arange(len(leaves))
    new = [factor * leaf + x for factor, leaf in zip(factors, leaves, strict=True)]
    ω = hypot(leaves[0], x) + hypot(leaves[1], leaves[2])
    θ = jnp.where(ω > x, ω * leaves[3], leaves[4])
    return jax.tree.unflatten(tree, new), θ + ω * θ


@pytest.fixture(scope="module")
def tools(module_at):
    return module_at(Path(__file__).with_name("compiled.py"))


@pytest.fixture(scope="module")
def memory():
    numbers = iter(np.linspace(0.1, 2.0, 2 * len(CLASSES) + len(WORDS)))
    words = {word: next(numbers) for word in WORDS}
    classes = {name: kind(next(numbers), next(numbers)) for name, kind in sorted(CLASSES.items())}
    return {"words": words, "classes": classes}


@pytest.fixture(scope="module")
def module(memory):
    given = {"memory": memory, "x": 0.5}
    results = ("memory", "output")
    return emit("names", [Entry("controller_step", controller_step, given, results)])


@pytest.fixture(scope="module")
def folder(tools, module, tmp_path_factory):
    """Folder with the header and the source."""
    folder = tmp_path_factory.mktemp("names")
    tools.write(module, folder)
    return folder


def test_every_field_has_its_value(tools, module, memory, folder):
    program = tools.Compiled(module, folder)
    lanes = jax.tree.map(lambda leaf: np.asarray(leaf)[None], {"memory": memory, "x": 0.3})
    status, found = program("controller_step", lanes)
    expected, output = controller_step(memory, 0.3)
    assert not status.any()
    got = np.array([leaf[0] for leaf in found["memory"]])
    np.testing.assert_allclose(got, jax.tree.leaves(expected), rtol=1e-14)
    np.testing.assert_allclose(found["output"][0], output, rtol=1e-14)


def test_program_with_all_headers_compiles_in_both_modes(tools, folder):
    text = f'{HEADERS}#include "names.h"\n'
    _checks(folder, tools.compiler(), "c99", "every.c", text)
    _checks(folder, tools.compiler(), "gnu17", "every.c", text)


def test_header_is_cpp(folder):
    if not shutil.which("g++"):
        pytest.skip("found no g++, which takes the header as C++17")
    text = f'{HEADERS}#include "names.h"\n'
    _checks(folder, "g++", "c++17", "every.cpp", text)
    _checks(folder, "g++", "c++17", "alone.cpp", '#include "names.h"\n')


def _checks(folder, program, standard, name, text):
    (folder / name).write_text(text, encoding="utf-8")
    options = (f"-std={standard}", "-Wall", "-Wextra", "-pedantic", "-Werror", "-fsyntax-only")
    done = subprocess.run([program, *options, name], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have macros of their own")
@pytest.mark.parametrize("standard", ["c99", "gnu17"])
def test_no_macro_of_the_headers_is_a_name(tools, standard):
    command = [tools.compiler(), f"-std={standard}", "-dM", "-E", "-"]
    done = subprocess.run(command, input=HEADERS, capture_output=True, text=True, check=True)
    macros = re.findall(r"^#define ([A-Za-z]\w*)(?!\()\b", done.stdout, re.MULTILINE)
    assert "NAN" in macros
    assert [name for name in macros if identifier(name) == name] == []


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("ω", "omega"),
        ("θ_rate", "theta_rate"),
        ("Δθ", "Delta_theta"),
        ("λ2", "lambda_2"),
        ("ά", "alpha"),
        ("émile", "emile"),
        ("ж", "zhe"),
        ("中", "u4e2d"),
        ("a-b", "a_b"),
        ("1st", "item_1st"),
        ("speed_2", "speed_2"),
        ("_private", "_private"),
        ("_K", "K"),
        ("_NAN", "NAN_"),
        ("I", "I"),
        ("", "item_"),
    ],
)
def test_letters_are_spelled(name, expected):
    assert public_identifier(name) == expected


def test_an_identifier_of_c_keeps_its_name_beside_others():
    assert member_names(["double", "x-y", "double_", "x_y", "ω", "omega"]) == [
        *("double__2", "x_y_2", "double_", "x_y", "omega_2", "omega"),
    ]


LISTS = st.lists(st.text(max_size=6) | st.sampled_from(WORDS), max_size=8, unique=True)


@given(LISTS)
@example(["L:0"])
@example(["_", "__", "\0", " ", "\u0301", "e\u0301", "é", "ﬁ", "\ud800", "𝜔", "ω"])
def test_any_names_become_different_identifiers(names):
    found = member_names(names)
    assert len({*found}) == len(names)
    for name, text in zip(names, found, strict=True):
        assert re.fullmatch(r"[A-Za-z_][0-9A-Za-z_]*", text)
        assert not re.match("_[A-Z]|__[A-Za-z]", text)
        assert public_identifier(text) == text
        if public_identifier(name) == name:
            assert text == name
        if any(letter.isalpha() for letter in name):
            assert text.strip("_")


def test_constants_of_an_enumeration_are_identifiers():
    Mode = IntEnum("Mode", ["ω", "safe"])

    class Memory(namedtuple("Memory", "mode rate")):
        ENUMS: ClassVar = {"mode": Mode}

    memory = Memory(np.int64(1), 0.5)
    entry = Entry("law", lambda memory: memory.rate * memory.mode, {"memory": memory}, ("y",))
    assert re.findall(r"MODE_\w+", emit("law", [entry]).header) == ["MODE_omega", "MODE_safe"]
