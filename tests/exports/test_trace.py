"""Trace from requirements to lines of C and to the steps that execute them; page of evidence."""

import csv
import hashlib
import shutil
import subprocess
from pathlib import Path
from typing import Annotated, NamedTuple

import equinox as eqx
import numpy as np
import pytest

import gyrostat as gs
from gyrostat.codegen.flight.c import emit
from gyrostat.core.arrays import Scalar
from gyrostat.core.files import write_texts
from gyrostat.core.jax64 import jax, jnp
from gyrostat.exports import files, read_results
from gyrostat.exports.evidence.content import read_content
from gyrostat.exports.evidence.pivot import pivots
from gyrostat.exports.evidence.results import Figure
from gyrostat.exports.evidence.results_text import results_text
from gyrostat.exports.evidence.trace import trace
from gyrostat.exports.target import STEPS, flight_module
from gyrostat.reports.evidence import evidence_page
from gyrostat.wheel import WheelModel
from gyrostat.wheel.friction import ViscousCoulomb

VALUES = {"inertia": 1.5e-3, "motor_constant": 0.0228, "viscous": 4.8e-6, "coulomb": 8.8e-4}
TOOLS = ("cc", "sh")
needs_tools = pytest.mark.skipif(
    any(shutil.which(tool) is None for tool in TOOLS), reason="needs a C compiler and sh"
)


class State(NamedTuple):
    """State of the law."""

    angle: Annotated[Scalar, "rad"]


class Saturated(eqx.Module):
    """u = -k x, limited.

    A. Author, "A law with a limit", Journal 12 (1999).

    Attributes:
        gain: Gain.
    """

    gain: Scalar

    def torque(self, angle):
        """See `Saturated`."""
        torque = -self.gain * angle

        def limited(value):
            return jnp.clip(value, -1.0, 1.0)

        return limited(torque)


def integrate(law: Saturated, state: State, rate: Scalar) -> tuple[State, Scalar]:
    """Integrate the rate over a period of 1 s."""
    angle = state.angle + rate
    torque = jax.lax.cond(angle > 2.0, lambda: angle * 0.5, lambda: law.torque(angle))
    return State(angle), torque


def target(rates):
    return flight_module(
        "saturated",
        {"law": Saturated(0.3)},
        {"state": State(0.0)},
        [("start", lambda: State(jnp.array(0.0)), ("state",))],
        [("step", integrate, ("state", "torque"))],
        title="A law with a limit",
        period=1.0,
        constants={},
        inputs={"rate": rates},
    )


@pytest.fixture(scope="module")
def traced():
    module = emit("saturated", target(np.zeros(STEPS)).entries)
    return module, *trace(module)


def test_a_requirement_is_a_function_with_its_docstring_and_source(traced):
    _, requirements, _ = traced
    found = {each.name: (each.statement, each.reference) for each in requirements}
    assert found == {
        "integrate": ("Integrate the rate over a period of 1 s.", ""),
        # the docstring of the method refers to that of the class, the function inside has none
        "Saturated.torque": (
            "u = -k x, limited.",
            'A. Author, "A law with a limit", Journal 12 (1999).',
        ),
    }
    assert [each.identifier for each in requirements] == ["R1", "R2"]


def test_the_lines_of_a_group_are_those_of_its_equation(traced):
    module, requirements, groups = traced
    rows = module.source.splitlines()
    lines = Path(__file__).read_text(encoding="utf-8").splitlines()
    names = {each.identifier: each.name for each in requirements}
    for group in groups:
        assert lines[group.line - 1].strip() == group.equation
        assert f"test_trace.py:{group.line}: " in rows[group.first - 1]
        assert rows[group.body - 2].endswith("*/")
        assert rows[group.last - 1].strip() not in ("", "}")
    (product,) = (each for each in groups if each.equation.startswith("torque = -self.gain"))
    assert names[product.requirement] == "Saturated.torque"
    assert any("gain" in row for row in rows[product.body - 1 : product.last])
    bodies = [k for group in groups for k in range(group.first, group.last + 1)]
    assert len(bodies) == len(set(bodies))


def folder_of(rates, folder):
    write_texts(folder, files(target(rates), "double", "Made by a test."))
    for kind in ("trace", "warnings"):
        script = folder / "evidence" / "run.sh"
        subprocess.run(["sh", script, kind], capture_output=True, timeout=60)
    return next(each for each in read_results(folder) if each.name == "trace")


def steps_by_equation(folder):
    """Start of an equation -> first step that executes it, and number of steps."""
    steps = (folder / "evidence/results/trace.tsv").read_text(encoding="utf-8").splitlines()
    with (folder / "evidence/trace/groups.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {
        row["equation"].partition(" = ")[0]: tuple(map(int, line.split("\t")))
        for row, line in zip(rows, steps, strict=True)
    }


@needs_tools
def test_the_steps_that_execute_an_equation_are_counted(tmp_path):
    rates = np.where(np.arange(STEPS) < 10, 0.5, -0.5)  # the angle is above 2 in steps 5 to 15
    result = folder_of(rates, tmp_path)
    assert (result.outcome, result.reason) == ("passed", "")
    steps = steps_by_equation(tmp_path)
    angles = np.cumsum(rates)
    assert steps["angle"] == (1, STEPS)
    assert steps["return jnp.clip(value, -1.0, 1.0)"] == (1, STEPS - np.sum(angles > 2.0))


@needs_tools
def test_statements_that_no_step_executes_are_counted(tmp_path):
    result = folder_of(np.full(STEPS, 3.0), tmp_path)
    groups = [group for each in read_content(tmp_path).trace for group in each.groups]
    missed = [group.equation for group, _, count in groups if count == 0]
    assert len(missed) == 2
    assert any("clip" in equation for equation in missed)
    assert any("self.gain" in equation for equation in missed)
    figures = {figure.name: figure.value for figure in result.figures}
    assert figures["groups that no step executes"] == "2"


@needs_tools
def test_a_run_that_is_not_that_of_python_fails(tmp_path):
    folder_of(np.zeros(STEPS), tmp_path)
    expected = tmp_path / "expected.txt"
    text = expected.read_text(encoding="utf-8").replace("as in Python", "otherwise", 1)
    expected.write_text(text, encoding="utf-8")
    subprocess.run(["sh", tmp_path / "evidence" / "run.sh", "trace"], capture_output=True)
    result = next(each for each in read_results(tmp_path) if each.name == "trace")
    assert (result.outcome, result.reason) == ("failed", "the run is not as in Python")


@needs_tools
def test_the_page_shows_results_trace_and_code(tmp_path):
    folder_of(np.where(np.arange(STEPS) < 10, 0.5, -0.5), tmp_path)
    content = read_content(tmp_path)
    assert content.title == "A law with a limit"
    assert content.outcomes["passed"] >= 1
    assert content.outcomes["not run"] >= 1
    assert [what for what, _ in content.digests] == ["generator"]
    page = evidence_page(content, command="gyrostat export ...")
    assert "R2 Saturated.torque" in page
    assert "Journal 12 (1999)" in page
    assert "://" not in page, "a page needs no network"
    for each in content.trace:
        for group, _, _ in each.groups:
            assert f'id="L{group.first}"' in page
    assert results_text(read_results(tmp_path)).count("| passed |") == content.outcomes["passed"]


def test_without_results_the_page_says_not_run(tmp_path):
    write_texts(tmp_path, files(target(np.zeros(STEPS)), "double", "Made by a test."))
    content = read_content(tmp_path)
    assert content.outcomes.keys() == {"not run"}
    page = evidence_page(content, command="gyrostat export ...")
    assert page.count('<span class="open">not run</span>') > len(content.trace)


def test_figures_of_one_group_are_a_table():
    figures = [
        Figure("M4: step, bound", "12", "bytes"),
        Figure("M4: start, bound", "3", "bytes"),
        Figure("M4: step, used", "10", "bytes"),
        Figure("options", "-Os", ""),
    ]
    (table,), others = pivots(figures)
    assert (table.title, table.columns) == ("M4", ("bound (bytes)", "used (bytes)"))
    assert table.rows == (("step", ("12", "10")), ("start", ("3", "")))
    assert others == figures[3:]


def test_an_export_shows_the_results_of_the_same_code(tmp_path):
    """Those of an earlier run in the folder, until the code changes; they are no file of it."""
    words = {"to": "c", "what": "controller", "period": 0.1}
    model = WheelModel(ViscousCoulomb, VALUES)
    gs.export(model, tmp_path, gains=(0.1, 0.01, 0.3), **words)
    page, readme = (tmp_path / name for name in ("evidence.html", "README.md"))
    assert '<span class="good">passed</span>' not in page.read_text(encoding="utf-8")
    assert "### Results" not in readme.read_text(encoding="utf-8")
    code = (tmp_path / "controller.h").read_bytes() + (tmp_path / "controller.c").read_bytes()
    digest = hashlib.sha256(code).hexdigest()
    (tmp_path / "evidence" / "results").mkdir()
    result = f"outcome\tpassed\ncode\t{digest}\nfigure\tof a test\t17\tbytes\n"
    (tmp_path / "evidence" / "results" / "warnings.txt").write_text(result, encoding="utf-8")
    gs.export(model, tmp_path, gains=(0.1, 0.01, 0.3), **words)
    assert '<span class="good">passed</span>' in page.read_text(encoding="utf-8")
    assert "| of a test | 17 bytes |" in readme.read_text(encoding="utf-8")
    gs.export(model, tmp_path, gains=(0.1, 0.01, 0.4), **words)
    assert '<span class="good">passed</span>' not in page.read_text(encoding="utf-8")
    assert "the result is that of other code" in readme.read_text(encoding="utf-8")
