"""Quick reproductions by the command line, each run once; and the published claims."""

import contextlib
import functools
import json
import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from gyrostat import cli
from gyrostat.core.jax64 import jax
from gyrostat.papers import PAPERS, Run, reproduction
from gyrostat.papers.carvalho_fenili import statements

KEYS = ["id", "quantity", "paper", "ours", "unit", "tolerance", "verdict", "why"]
DOCS = Path(__file__).parents[2] / "docs"
LONG = {"carvalho-fenili": [statements.flown]}
"""Simulations of a quick run that take longer than their compilation, by paper."""


@functools.cache
def published_claims():
    """Rows of docs/claims.md: paper -> id -> verdict."""
    papers = {}
    for line in (DOCS / "claims.md").read_text(encoding="utf-8").splitlines():
        if found := re.match(r"`gyrostat reproduce ([a-z0-9-]+) ", line):
            rows = papers[found[1]] = {}
        elif line.startswith("| `"):
            cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)]
            rows[cells[1].strip("`")] = cells[5]
    return papers


@pytest.fixture(scope="session")
def published():
    """Rows of docs/claims.md: paper -> id -> verdict."""
    return published_claims()


@contextlib.contextmanager
def optimised():
    """Compile with optimisation, which the marks of a test would do for all that it compiles."""
    before = jax.config.values["jax_disable_most_optimizations"]
    jax.config.update("jax_disable_most_optimizations", False)
    try:
        yield
    finally:
        jax.config.update("jax_disable_most_optimizations", before)


@pytest.fixture(scope="session")
def quick(tmp_path_factory):
    """Run `reproduce --quick` on a paper: its rows and page, and the run with what it shared."""

    @functools.cache
    def reproduce(paper):
        folder = tmp_path_factory.mktemp(paper)
        arguments = ["reproduce", paper, "--quick", "--json", "--out", str(folder)]
        runs = []

        def kept(*arguments):
            runs.append(Run(*arguments))
            with optimised():
                for simulated in LONG.get(paper, ()):
                    runs[-1].once(simulated)
            return runs[-1]

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(reproduction, "Run", kept)
            result = CliRunner().invoke(cli.app, arguments)
        assert result.exit_code == 0, result.output
        content = json.loads((folder / "claims.json").read_text(encoding="utf-8"))
        rows = content["claims"]
        return SimpleNamespace(
            folder=folder,
            run=runs[0],
            content=content,
            rows={row["id"]: row for row in rows},
            ours={row["id"]: row["ours"] for row in rows},
            page=(folder / "report.html").read_text(encoding="utf-8"),
            stdout=result.stdout,
            stderr=result.stderr,
        )

    return reproduce


@pytest.fixture(scope="session")
def judged_as_published(quick, published):
    """Check a quick run: its ids, keys and verdicts, its report and its messages."""

    def check(paper):
        run = quick(paper)
        assert json.loads(run.stdout) == run.content
        assert list(run.content) == ["paper", "claims"]
        assert run.content["paper"] == paper
        assert list(run.rows) == list(published[paper])
        full = {row.id for row in PAPERS[paper].rows if row.full}
        for name, row in run.rows.items():
            assert list(row) == KEYS
            assert (row["ours"] is None) == (row["verdict"] in ("not-testable", "infeasible"))
            assert (row["tolerance"] is None) == (row["paper"] is None)
            assert row["why"].endswith(".")
            assert ("Not computed" in row["why"]) == (name in full)
            if name not in full:
                assert row["verdict"] == published[paper][name]
                assert "{" not in row["quantity"] + row["why"]
            assert name in run.page
        assert "Quick" in run.page
        assert sorted(path.name for path in run.folder.iterdir()) == [
            ".gyrostat.json",
            "claims.json",
            "report.html",
        ]
        assert f"{paper}: " in run.stderr
        assert "not-reproduced" in run.stderr

    return check
