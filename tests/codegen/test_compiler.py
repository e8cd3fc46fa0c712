"""The cache of compiled lanes, and what is said where the compiler does not do its part."""

import ctypes
from pathlib import Path

import pytest

from gyrostat.codegen.simd.compiler import (
    compiled,
    compiler,
    compiler_options,
    compiler_version,
    library,
    require_compiler,
)
from gyrostat.core.errors import InputError


def module(number):
    return f'#include "lanes.h"\nint found(void) {{ return LANES * 0 + {number}; }}\n'


@pytest.fixture
def compiler_is(tmp_path, monkeypatch):
    def call(text, flags=""):
        script = tmp_path / "a compiler"
        script.write_text(text)
        script.chmod(0o755)
        monkeypatch.setenv("CC", f"{script}{flags}")

    monkeypatch.setenv("GYROSTAT_CACHE", str(tmp_path / "kept"))
    return call


def test_a_compiler_may_be_named_with_flags(tmp_path, monkeypatch):
    path, *_ = require_compiler()
    monkeypatch.setenv("GYROSTAT_CACHE", str(tmp_path))
    monkeypatch.setenv("CC", f"{path} -DTOLD=3")
    assert compiler() == (path, "-DTOLD=3")
    assert compiler_version().endswith(" -DTOLD=3")
    assert library(module("TOLD")).found() == 3
    monkeypatch.setenv("CC", f"{path} -DTOLD=4")  # and is not mistaken for the other
    assert library(module("TOLD")).found() == 4
    monkeypatch.setenv("CC", "no-such-compiler -O1")
    assert compiler() is None
    monkeypatch.setenv("CC", " ")
    assert compiler() is not None


@pytest.mark.parametrize(
    ("version", "is_gcc"),
    [("cc 12.2.0\nCopyright (C) 2022 Free Software Foundation, Inc.", True), ("clang 19", False)],
)
def test_only_gcc_gets_the_flags_of_gcc(compiler_is, version, is_gcc):
    compiler_is(f"#!/bin/sh\necho '{version}'\n")
    assert ("-fira-region=one" in compiler_options()) is is_gcc
    assert "-O2" in compiler_options()


def test_a_damaged_library_is_made_again_and_never_loaded(tmp_path, monkeypatch):
    monkeypatch.setenv("GYROSTAT_CACHE", str(tmp_path / "cache"))
    content = compiled(module(4))
    (entry,) = (tmp_path / "cache").glob("lanes-*")
    whole = entry.read_bytes()
    for broken in (whole[:100], whole[:-1] + bytes([whole[-1] ^ 1]), compiled(module(5)), b""):
        entry.write_bytes(broken)
        assert compiled(module(4)) == content
        assert entry.read_bytes() == whole


def test_no_place_for_a_cache_is_needed(tmp_path, monkeypatch):
    monkeypatch.setenv("GYROSTAT_CACHE", str(tmp_path / "file"))
    (tmp_path / "file").write_text("")
    with pytest.warns(UserWarning, match=r"file: Not a directory, expected .* temporary folder"):
        assert library(module(5)).found() == 5

    def homeless():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("GYROSTAT_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    with pytest.warns(UserWarning, match="found no home folder"):
        assert library(module(6)).found() == 6
    monkeypatch.delenv("GYROSTAT_CACHE")


def test_a_folder_where_nothing_may_be_executed_is_no_hindrance(tmp_path, monkeypatch):
    monkeypatch.setenv("GYROSTAT_CACHE", str(tmp_path))
    load = ctypes.CDLL

    def refusing(path):
        if path.startswith(str(tmp_path)):
            raise OSError("failed to map segment from shared object")
        return load(path)

    monkeypatch.setattr(ctypes, "CDLL", refusing)
    assert library(module(17)).found() == 17


def test_a_cache_here_is_found_again(tmp_path, monkeypatch):
    monkeypatch.setenv("GYROSTAT_CACHE", ".")
    monkeypatch.chdir(tmp_path)
    first = compiled(module(7))
    (made,) = tmp_path.glob("lanes-*")
    before = made.stat().st_ino
    assert compiled(module(7)) == first
    assert made.stat().st_ino == before


def test_the_line_with_the_error_is_told(compiler_is):
    compiler_is(
        '#!/bin/sh\n[ "$1" = --version ] && exit 0\n'
        'echo "program.c: In function fly:" >&2; echo "program.c:3: error: no such thing" >&2\n'
        "exit 1\n"
    )
    with pytest.raises(InputError, match="error: no such thing"):
        library(module(8))


@pytest.mark.parametrize("text", ["\0 no program", "#!/bin/sh\nexit 0\n"])
def test_a_compiler_that_makes_nothing_is_refused(compiler_is, text):
    compiler_is(text)
    with pytest.raises(InputError, match="C compiler: found"):
        library(module(9))


def test_other_instructions_make_fewer_lanes():
    text = '#include "lanes.h"\nint found(void) { return LANES; }\n'
    assert library(text, ("-mno-avx512f",)).found() == 4
