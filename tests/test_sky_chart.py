"""Sky maps as SVG: the projection keeps areas, so that they can be measured in the drawing."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from gyrostat.failures import SkyMap
from gyrostat.reports import sky_chart
from gyrostat.reports.sky_map import ACROSS, UP

POLE = np.array([2.0, -1.0, 3.0]) / np.sqrt(14.0)


def sky(*bands, pole=POLE):
    edges = np.array(bands).reshape(-1, 2)
    fraction = float(np.sum(np.cos(edges[:, 0]) - np.cos(edges[:, 1]))) / 2.0
    return SkyMap(np.eye(3)[0], pole, edges, fraction)


def areas(chart):
    """Areas of the closed curves of a chart, and the number of their points."""
    root = ElementTree.fromstring(chart)
    (path,) = (e.get("d") for e in root if e.tag.endswith("path") and e.get("fill") == "#9cc3ea")
    found, count = [], 0
    for curve in path.split("Z")[:-1]:
        x, y = np.array(re.findall(r"[-\d.]+", curve), dtype=float).reshape(-1, 2).T
        found.append(0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
        count += len(x)
    return found, count


@pytest.mark.parametrize(
    "bands",
    [
        [(0.0, np.pi)],
        [(0.4, 1.2)],
        [(0.0, 0.7)],
        [(0.3, 0.9), (1.5, 2.8)],
        [(2.4, np.pi)],
        [(0.0, 0.3), (0.8, 1.1), (2.0, 2.2)],
    ],
)
@pytest.mark.parametrize("pole", [POLE, [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], ids=str)
def test_the_area_drawn_is_the_share_of_the_sphere(bands, pole):
    drawn = sky(*bands, pole=np.array(pole))
    found, count = areas(sky_chart(drawn))
    assert sum(found) / (np.pi * ACROSS * UP) == pytest.approx(drawn.fraction, abs=4e-3)
    assert count < 4000


def test_a_thin_band_is_a_line_at_its_angle_from_the_momentum():
    drawn = sky((1.0, 1.0))
    chart = sky_chart(drawn)
    assert areas(chart)[0] == []
    root = ElementTree.fromstring(chart)
    (line,) = (e.get("d") for e in root if e.get("stroke") == "#9cc3ea")
    x, y = np.array(re.findall(r"[-\d.]+", line), dtype=float).reshape(-1, 2).T
    (outline, *_) = (e for e in root if e.tag.endswith("ellipse"))
    x, y = x - float(outline.get("cx")), float(outline.get("cy")) - y
    turn = np.arcsin(np.clip(y / UP, -1.0, 1.0))
    latitude = np.arcsin((2.0 * turn + np.sin(2.0 * turn)) / np.pi)
    longitude = np.pi * x / (ACROSS * np.cos(turn))
    across = np.cos(latitude)
    points = [across * np.cos(longitude), across * np.sin(longitude), np.sin(latitude)]
    np.testing.assert_allclose(POLE @ points, np.cos(1.0), atol=3e-3)


def test_marks_are_named_and_each_is_at_its_place():
    chart = sky_chart(sky((0.4, 1.2)), target=np.array([1.0, 0.0, 0.0]), nearest=np.eye(3)[2])
    for name in ("can be held", "total momentum", "opposite direction", "target", "nearest"):
        assert f">{name}</text>" in chart
    assert "translate(380.0 197.0)" in chart  # the direction x is in the middle
    assert "translate(380.0 24.0)" in chart  # and z at the top
    without = sky_chart(SkyMap(np.eye(3)[0], np.zeros(3), np.array([[0.0, np.pi]]), 1.0))
    assert "momentum" not in without
    assert sum(areas(without)[0]) / (np.pi * ACROSS * UP) == pytest.approx(1.0, abs=2e-3)
