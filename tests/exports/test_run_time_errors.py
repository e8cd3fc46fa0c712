"""Proof by Frama-C: it holds for exported code, and finds each kind of error in changed code."""

import shutil

import pytest

from gyrostat.codegen.flight import outlining
from gyrostat.control import CurrentMode, EstimatingCompensator
from gyrostat.exports import files, targets

needs_frama_c = pytest.mark.skipif(shutil.which("frama-c") is None, reason="found no frama-c")


@needs_frama_c
@pytest.mark.parametrize(
    ("precision", "longest"),
    [("double", outlining.LONGEST), ("float", 150)],
    ids=["double", "parts"],
)
def test_the_compensator_has_no_alarm_and_finite_results(
    precision, longest, g2, check, tmp_path, monkeypatch
):
    """Also where its step has parts."""
    monkeypatch.setattr(outlining, "LONGEST", longest)
    monkeypatch.setattr(outlining, "PART", longest)
    tuned = EstimatingCompensator.tune(g2.law, g2.wheel, 0.495, 0.5, 0.1, delay=1)
    texts = files(targets.compensator(tuned, 0.1), precision, "Made by a test.")
    result = check("run_time_errors", tmp_path, texts)
    assert result.outcome == "passed", result.reason
    figures = {figure.name: figure.value for figure in result.figures}
    assert figures["alarms"] == "0"
    assert figures["results not proven to be finite"] == "0"
    assert ("static void correct(" in texts["compensator.c"]) == (longest == 150)
    contract = texts["evidence/run_time_errors.c"]
    assert int(figures["results proven to be finite"]) == contract.count("ensures") > 20


SEEDED = {
    "overflow of a counter": (
        "memory->guard.samples_missed = counted;",
        "memory->guard.samples_missed = memory->guard.samples_missed + 1;",
        "signed_overflow",
    ),
    "index out of bounds": (
        "report->samples_missed = counted;",
        "const double steps[3] = {1.0, 2.0, 3.0};\n"
        "        report->samples_missed = (steps[counted % 4] > 1.5) ? 1 : 0;",
        "index_bound",
    ),
    "division by zero": (
        "report->samples_missed = 0;",
        "report->samples_missed = 100 / memory->guard.samples_missed;",
        "division_by_zero",
    ),
    "command that is not tested": (
        "memory->guard.last.rate = measurement->rate;",
        "memory->guard.last.rate = measurement->rate / measurement->attitude;",
        "postcondition",
    ),
}


@needs_frama_c
@pytest.mark.parametrize("error", SEEDED)
def test_a_seeded_error_is_found(error, law, check, tmp_path):
    old, new, kind = SEEDED[error]
    changed = law["controller.c"].replace(old, new)
    assert changed != law["controller.c"]
    result = check("run_time_errors", tmp_path, law | {"controller.c": changed})
    assert result.outcome == "failed"
    assert kind in result.reason


def test_without_frama_c_the_proof_says_so(law, check, tmp_path, monkeypatch):
    programs = tmp_path / "bin"
    programs.mkdir()
    for name in ("sh", "mktemp", "mkdir", "rm", "cat", "sed", "dirname", "sha256sum"):
        if path := shutil.which(name):
            (programs / name).symlink_to(path)
    monkeypatch.setenv("PATH", str(programs))
    result = check("run_time_errors", tmp_path / "flight", law)
    assert (result.outcome, result.reason) == ("not run", "frama-c is not installed")


@pytest.mark.parametrize(("precision", "bits"), [("double", "uint64_t"), ("float", "uint32_t")])
def test_every_input_has_any_bits_in_an_endless_loop(precision, bits, g2):
    module = targets.controller(CurrentMode(g2.law, 0.0228), 0.1)
    program = files(module, precision, "Made by a test.")["evidence/run_time_errors.c"]
    assert f"extern volatile {bits} any_bits;" in program
    loop = program.partition("while (true) {")[2]
    for name in ("attitude", "rate", "speed"):
        assert f"measurement.{name} = any_real();" in loop
    assert loop.index("any_real") < loop.index("controller_step(")
    assert "controller_start(" not in loop
