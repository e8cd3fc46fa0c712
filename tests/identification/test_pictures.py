"""Pictures of results: what is drawn is what the result says."""

from base64 import b64decode
from html import unescape

import numpy as np
import pytest
from matplotlib.figure import Figure

from gyrostat.core.text import measured
from gyrostat.core.units import RPM
from gyrostat.identification import Fit, Lot, Pool, compare_fits, stored_fit, validate
from gyrostat.identification.experiment.design import Design
from gyrostat.identification.result.fit_text import parameter_rows
from gyrostat.identification.result.temperature_trend import TemperatureTrend
from gyrostat.identification.uncertainty.averaging import Effect
from gyrostat.reports.pictures import picture


def line(axes, label):
    return next(each for each in axes.lines if each.get_label() == label)


def points(line):
    return np.array(line.get_data(), dtype=float)


def test_fit_shows_speeds_residuals_and_friction(plain):
    figure = plain.plot()
    assert isinstance(figure, Figure)
    speed, residual, friction = figure.axes
    np.testing.assert_array_equal(line(speed, "model").get_ydata(), plain.predicted[0] / RPM)
    np.testing.assert_array_equal(residual.lines[0].get_ydata(), plain.residuals[0] / RPM)
    band = np.asarray(residual.collections[0].get_paths()[0].vertices)[:, 1]
    expected = 2.0 * np.hypot(plain.predicted_sigma[0], plain.speed_sigma) / RPM
    assert band.max() == pytest.approx(expected.max(), rel=1e-12)
    curves = [each for each in map(points, friction.lines) if each.shape[1] == 400]
    for speeds, torques in curves:
        expected, _ = plain.friction_curve(speeds * RPM)
        np.testing.assert_allclose(torques, 1e3 * expected, rtol=1e-9)
    assert len(curves) == 2


def test_the_speed_at_the_start_has_no_verdict(plain):
    verdicts = {name: verdict for name, _, _, verdict in parameter_rows(plain)}
    assert verdicts["initial_speed"] == ""
    assert verdicts["coulomb"].startswith("yes (")


def test_notebook_shows_the_text_of_the_command_line_and_a_picture(plain, record):
    held = validate(plain.model, plain.parameters, record(seed=3))
    both = compare_fits([stored_fit(plain)] * 2, ["a", "b"], same_wheel=True, same_bench=True)
    for result in (plain, held, both):
        html = result._repr_html_()
        text, image = html.split("</pre>")
        assert unescape(text.removeprefix("<pre>")) == str(result)
        assert b64decode(image.split("base64,")[1].split('"')[0]).startswith(b"\x89PNG")
    assert "the model holds" in str(held)
    assert "significant over" in str(both)


def test_parts_of_results_have_their_uncertainty_and_unit_in_a_notebook(plain):
    both = compare_fits([stored_fit(plain)] * 2, ["a", "b"], same_wheel=True, same_bench=True)
    change = next(each for each in both.changes if each.parameter == "coulomb")
    effect = Effect("r", "ripple", 0.5, 2e-5, 1e-6, "N·m")
    values = np.array([[5.0, 40.0], [2e-3, 1e-3], [2e-5, 1e-5]])
    trend = TemperatureTrend("coulomb", "N·m", *values, -3e-5, 4e-7)
    for part, texts in (
        (change, (measured(change.difference, change.sigma), "N·m")),
        (effect, (measured(2e-5, 1e-6), "N·m", "50 %")),
        (trend, ("5 °C", measured(2e-3, 2e-5), measured(-3e-5, 4e-7), "N·m/°C")),
    ):
        html = unescape(part._repr_html_())
        assert [text for text in texts if text not in html] == []


@pytest.mark.parametrize("kind", [Lot, Pool, Design, Fit])
def test_every_result_has_a_picture_of_its_own(kind):
    assert picture.dispatch(kind) is not picture.dispatch(object)


def test_other_objects_have_no_picture():
    with pytest.raises(TypeError, match="found no picture of str, expected a result"):
        picture("fit")
