"""Files of figures for papers."""

import re

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.reports.chart_figure import figure_of
from gyrostat.reports.drawing import panels
from gyrostat.reports.paper_figures import WIDE, figure_files
from gyrostat.reports.time_chart import time_chart

BEGINS = {"pdf": b"%PDF", "png": b"\x89PNG"}


@pytest.mark.parametrize("kind", ["pdf", "svg", "png"])
def test_a_file_is_as_wide_as_a_page_has_its_text_and_no_date(kind):
    time = np.linspace(0.0, 1.0, 50)
    charts = [time_chart(time, np.sin(time)[:, None], "wheel speed (rpm)", ["a"], 100)] * 2
    figure = figure_of(charts)
    size = figure.get_size_inches().tolist()
    (name, content), *_ = figure_files(kind, {"run": figure}).items()
    assert name == f"run.{kind}"
    assert figure.get_size_inches().tolist() == size
    assert figure_files(kind, {"run": figure})[name] == content
    if kind == "svg":
        text = content.decode()
        assert float(re.search(r'width="([\d.]+)pt"', text)[1]) == pytest.approx(72.0 * WIDE)
        assert text.count(">wheel speed (rpm)</text>") == 2
    else:
        assert content.startswith(BEGINS[kind])


def test_fonts_of_a_pdf_can_be_edited():
    with panels(height=2.0) as (figure, axes):
        axes.set_xlabel("time (s)")
    (content,) = figure_files("pdf", {"a": figure}).values()
    assert b"/Type3" not in content.replace(b" ", b"")


@pytest.mark.parametrize("verb", ["report", "reproduce"])
def test_an_unknown_kind_is_refused_before_anything_runs(verb, tmp_path):
    with pytest.raises(gs.InputError, match=r"^figures: found 'gif', expected one of pdf, svg"):
        getattr(gs, verb)("carrara-kuga" if verb == "reproduce" else tmp_path, figures="gif")


def test_a_report_of_a_campaign_has_its_figure(small, tmp_path):
    import shutil

    folder = tmp_path / "c"
    shutil.copytree(small.out, folder)
    said = []
    gs.report(folder, figures="svg", say=said.append)
    text = (folder / "report.svg").read_text(encoding="utf-8")
    assert ">requirement.ape</text>" in text
    assert any("report.svg" in line for line in said)
    gs.report(folder, figures="svg")  # its own file is replaced
