"""Evidence by compilers: warnings, static analysis, the header in C++, sanitizers."""

import shutil
import subprocess

import pytest

from gyrostat.core.files import write_texts

needs_gcc = pytest.mark.skipif(
    any(shutil.which(tool) is None for tool in ("gcc", "g++")), reason="found no gcc or no g++"
)


@needs_gcc
def test_no_compiler_warns_and_the_header_is_cpp(law, check, tmp_path):
    result = check("warnings", tmp_path, law)
    assert result.outcome == "passed", result.reason
    figures = {figure.name: figure.value for figure in result.figures}
    for name in ("gcc, C99", "gcc, static analysis", "g++, header in C++17"):
        assert figures[name] == "0"
    clang = shutil.which("clang") or shutil.which("clang-19")
    assert figures["clang, C99"] == ("0" if clang else "not run")


SEEDED = {
    "gcc, C99": ("int64_t counted =", "int counted ="),
    "gcc, static analysis": (
        "    report->samples_missed = 0;",
        "    const int64_t *missing = 0;\n    report->samples_missed = *missing;",
    ),
}


@needs_gcc
@pytest.mark.parametrize("error", SEEDED)
def test_a_seeded_warning_is_found(error, law, check, tmp_path):
    old, new = SEEDED[error]
    changed = law["controller.c"].replace(old, new)
    assert changed != law["controller.c"]
    result = check("warnings", tmp_path, law | {"controller.c": changed})
    assert result.outcome == "failed"
    assert result.reason.startswith(error)


@needs_gcc
def test_a_header_that_cpp_refuses_is_found(law, check, tmp_path):
    changed = law["controller.h"].replace(
        "const CurrentMode *controller", "const CurrentMode *class"
    )
    assert changed != law["controller.h"]
    result = check("warnings", tmp_path, law | {"controller.h": changed})
    assert result.outcome == "failed"
    assert result.reason.startswith("g++, header in C++17")


@needs_gcc
def test_functions_are_linked_from_cpp(law, tmp_path):
    write_texts(tmp_path, law)
    text = (
        '#include "controller.h"\n'
        "int main() { CurrentMode law; MeasurementGuard guard;\n"
        "return controller_parameters(&law, &guard); }\n"
    )
    (tmp_path / "main.cpp").write_text(text, encoding="utf-8")
    subprocess.run(["gcc", "-c", "controller.c"], cwd=tmp_path, check=True)
    words = ["g++", "-std=c++17", "main.cpp", "controller.o", "-lm", "-o", "program"]
    subprocess.run(words, cwd=tmp_path, check=True)
    subprocess.run([tmp_path / "program"], check=True)


@needs_gcc
def test_sanitizers_find_an_access_outside_an_array(law, check, tmp_path):
    result = check("sanitizers", tmp_path / "as_exported", law)
    if result.outcome == "not run":
        pytest.skip(result.reason)
    assert result.outcome == "passed", result.reason
    old = "report->samples_missed = 0;"
    new = (
        "const int64_t zeros[2] = {0, 0};\n"
        "report->samples_missed = zeros[report->sample_status + 2];"
    )
    changed = law["controller.c"].replace(old, new)
    assert changed != law["controller.c"]
    result = check("sanitizers", tmp_path / "changed", law | {"controller.c": changed})
    assert result.outcome == "failed"
    assert "runtime error" in result.reason or "ERROR" in result.reason
