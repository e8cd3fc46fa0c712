"""Evidence of MISRA C:2012: a finding needs a recorded deviation, and a deviation a finding."""

import re
import shutil
import subprocess

import pytest

from gyrostat.codegen.flight.expressions import HELPERS, Dialect
from gyrostat.codegen.program import Number

needs_cppcheck = pytest.mark.skipif(shutil.which("cppcheck") is None, reason="found no cppcheck")
DEVIATIONS = "evidence/misra/deviations.tsv"


@needs_cppcheck
def test_exported_code_has_no_finding_without_a_deviation(law, check, tmp_path):
    result = check("misra", tmp_path, law)
    assert result.outcome == "passed", result.reason
    figures = {figure.name: figure.value for figure in result.figures}
    assert figures == {"findings": "1", "findings without a recorded deviation": "0"}


@needs_cppcheck
def test_a_finding_without_a_deviation_fails(law, check, tmp_path):
    result = check("misra", tmp_path, law | {DEVIATIONS: "rule\treason\n"})
    assert result.outcome == "failed"
    assert "rule 2.4" in result.reason


@needs_cppcheck
def test_a_deviation_without_a_finding_fails(law, check, tmp_path):
    result = check("misra", tmp_path, law | {DEVIATIONS: law[DEVIATIONS] + "15.1\tgoto\n"})
    assert result.outcome == "failed"
    assert result.reason == "rule 15.1: deviation without a finding"


@needs_cppcheck
def test_rules_about_values_of_constants_are_checked(law, check, tmp_path):
    shift = "\nstatic uint32_t shifted(uint32_t u)\n{\n    return u << 40;\n}\n"
    result = check("misra", tmp_path, law | {"controller.c": law["controller.c"] + shift})
    assert result.outcome == "failed"
    assert result.reason.endswith("rule 12.2")


@needs_cppcheck
@pytest.mark.parametrize("real", ["double", "float"])
def test_helper_functions_have_no_finding(tmp_path, real):
    dialect = Dialect(real)
    texts = dict.fromkeys(dialect.helper(operation) for operation in HELPERS)
    names = ["math", "stdbool", "stdint", "string"]
    lines = [f"#include <{name}.h>\n" for name in names] + [*texts]
    least = dialect.number(Number("integer", -(2**63))).text
    lines.append(f"static int64_t least_integer(void)\n{{\n    return {least};\n}}\n")
    (tmp_path / "helpers.c").write_text("\n".join(lines))
    command = ["cppcheck", "-q", "--addon=misra", "--std=c99", "helpers.c"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    rules = set(re.findall(r"\[misra-c2012-([\d.]+)\]", done.stderr))
    assert not rules, done.stderr
