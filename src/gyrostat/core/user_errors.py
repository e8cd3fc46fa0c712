"""Mistakes in user-defined parts, each in one line: part, what was found, what was expected."""

import contextlib
import dataclasses
import linecache
import re
import sys
import traceback
from collections.abc import Iterator
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.random_keys import is_random_key
from gyrostat.core.undeclared_reads import UndeclaredReadError, watched_reads
from gyrostat.core.user_modules import PREFIX

UNKNOWN = "a value that is only known in the run"
ADVICE: tuple[tuple[type[Exception], str, str], ...] = (
    (
        jax.errors.TracerBoolConversionError,
        f"if, while, and, or, min or max of {UNKNOWN}",
        "jnp.where(condition, a, b), & and |, jnp.minimum and jnp.maximum",
    ),
    (
        jax.errors.TracerArrayConversionError,
        f"a NumPy function of {UNKNOWN}",
        "the same function of jax.numpy",
    ),
    (
        jax.errors.ConcretizationTypeError,
        f"float(), int(), range() or a size from {UNKNOWN}",
        "jnp.asarray, jnp.round, and loops and shapes of a fixed size",
    ),
    (
        jax.errors.UnexpectedTracerError,
        "a value of another call, stored outside the memory",
        "it in the memory, which each call returns",
    ),
    (
        dataclasses.FrozenInstanceError,
        "an assignment to a field",
        "the value in the memory, which each call returns",
    ),
)
"""Exception -> what it means in a part, and what to write instead."""

NO_KEY = (
    "numbers: the words of a key, jax.random.PRNGKey(1), or the number of the sample, from which "
    "each call makes its key by jax.random.fold_in(jax.random.key(1), number); both are the same "
    "in every run, and noise that differs from run to run comes from a sensor, which is given a key"
)
"""What to write instead of a random key in the memory."""


class UserPartError(InputError):
    """Mistake in a user-defined part; its message names the part."""


@contextlib.contextmanager
def reported(part: str, package: str = "") -> Iterator[None]:
    """Report any exception in a user's Python as a mistake of a part; it prints to stderr.

    stdout is for results, such as those of `--json`.

    Args:
        part: Name of the part, such as "controller mission.py:EarthPointer".
        package: Private package of the part, or a module of it, whose data files it can read by
            their paths.

    Raises:
        UserPartError: An exception was raised inside, or something was read that is not declared.
    """
    try:
        with contextlib.redirect_stdout(sys.stderr), watched_reads(package):
            yield
    except UserPartError:
        raise
    except UndeclaredReadError as error:
        file = "" if f" {error.read.file}:" in part else f" {error.read.file}"
        message = str(error).removeprefix(error.read.file)
        raise UserPartError(f"{part},{file}{message}") from None
    except InputError as error:
        raise UserPartError(f"{part}: {error}") from error
    except (Exception, SystemExit) as error:
        raise _mistake(part, error) from error


def _mistake(part: str, error: BaseException) -> UserPartError:
    """Error with the place of an exception in a user's Python, and what to write instead."""
    location, code = _location(part, error)
    for kind, found, expected in ADVICE:
        if isinstance(error, kind):
            quote = f" in `{code}`" if code else ""
            return UserPartError(f"{part}{location}: found {found}{quote}, expected {expected}")
    text = str(error).strip().partition("\n")[0][:200]
    name = type(error).__name__
    if isinstance(error, SyntaxError):
        location, text = f", line {error.lineno}", error.msg
    found = re.sub(rf"{PREFIX}\w+/", "", f"{name} ({text})" if text else name)
    expected = "Python that runs without an exception"
    if isinstance(error, FileNotFoundError):
        expected = 'a file of the scenario: data = ["FILE", ...] beside python'
    return UserPartError(f"{part}{location}: found {found}, expected {expected}")


def _location(part: str, error: BaseException) -> tuple[str, str]:
    """Innermost line of the user's Python that raised an exception, and its text."""
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        package, _, path = frame.filename.partition("/")
        if package.startswith(PREFIX):
            code = linecache.getline(frame.filename, frame.lineno or 0).strip()
            file = "" if f" {path}:" in part else f" {path}"
            return f",{file} line {frame.lineno}", code[:80]
    return "", ""


def numbers(part: str, what: str, value: Any, shape: tuple[int, ...] | None = None) -> Any:
    """Array of real numbers from a value that a part returned.

    Args:
        part: Name of the part.
        what: Name of the value.
        value: Returned value.
        shape: Expected shape; None for any.

    Raises:
        UserPartError: The value is not an array of numbers, or has another shape.
    """
    if is_random_key(value):
        raise UserPartError(f"{part}: found a random key of JAX as {what}, expected {NO_KEY}")
    expected = "numbers" if shape is None else f"shape {shape}"
    try:
        array = None if isinstance(value, str | bytes) else jnp.asarray(value)
    except (TypeError, ValueError):
        array = None
    if array is None:
        raise UserPartError(f"{part}: found {type(value).__name__} as {what}, expected {expected}")
    if jnp.iscomplexobj(array):
        raise UserPartError(f"{part}: found complex numbers as {what}, expected real {expected}")
    if shape is not None and array.shape != shape:
        raise UserPartError(f"{part}: found shape {array.shape} of {what}, expected shape {shape}")
    return array if shape is None else array.astype(float)


def same_memory(part: str, before: Any, after: Any) -> Any:
    """Memory that a call returned, validated against the memory before the call.

    Raises:
        UserPartError: Their structures, shapes or types differ.
    """
    old, _ = jax.tree_util.tree_flatten_with_path(before)
    new, _ = jax.tree_util.tree_flatten_with_path(after)
    if jax.tree.structure(before) != jax.tree.structure(after):
        found, expected = (described(tree) for tree in (after, before))
        raise UserPartError(
            f"{part}: found a memory {found}, expected {expected}, as start returned"
        )
    for (path, old_leaf), (_, new_leaf) in zip(old, new, strict=True):
        where = f"memory{jax.tree_util.keystr(path)}"
        new_leaf = numbers(part, where, new_leaf)
        if (old_leaf.shape, old_leaf.dtype) != (new_leaf.shape, new_leaf.dtype):
            hint = "" if old_leaf.dtype == new_leaf.dtype else " (write 0.0 for a real number)"
            raise UserPartError(
                f"{part}: found {where} of shape {new_leaf.shape} and type {new_leaf.dtype}, "
                f"expected {old_leaf.shape} and {old_leaf.dtype}, as start returned{hint}"
            )
    return jax.tree.map(jnp.asarray, after)


def described(tree: Any) -> str:
    """Kind of a result, for a message."""
    if isinstance(tree, jax.Array):
        return f"an array of shape {tree.shape}"
    fields = getattr(tree, "_fields", None)
    if fields is not None:
        return f"{type(tree).__name__}({', '.join(fields)})"
    return f"{type(tree).__name__} of {len(jax.tree.leaves(tree))} entries"
