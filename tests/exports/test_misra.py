"""Evidence of MISRA C:2012: a finding needs a recorded deviation, and a deviation a finding."""

import shutil

import pytest

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
