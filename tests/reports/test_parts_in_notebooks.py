"""Parts of results in a notebook: their fields with uncertainty, meaning and unit."""

import dataclasses
import importlib
import inspect
from html import unescape

import numpy as np
import pytest
from matplotlib.figure import Figure

import gyrostat as gs
from gyrostat.campaigns.summary import Estimate as RunsEstimate
from gyrostat.core.field_table import field_table, meanings_of
from gyrostat.core.jax64 import jax
from gyrostat.core.text import measured
from gyrostat.core.units import RPM
from gyrostat.estimation import FrictionTrack
from gyrostat.identification.gyro.parameters import PARAMETERS, Estimate
from gyrostat.identification.judge.acceptance_lines import Acceptance
from gyrostat.identification.result.stored_fit import StoredFit
from gyrostat.identification.uncertainty.posterior import Marginal, Posterior
from gyrostat.microvibration.estimates import Estimate as HarmonicEstimate
from gyrostat.monitoring.rehearsal import REGRESSED, Expected, Rehearsal
from gyrostat.search.budget_result import Line
from gyrostat.telemetry import Record
from gyrostat.wheel.model_file import WheelModel

ROOMS = ("failures", "identification", "microvibration", "monitoring", "papers", "telemetry")
INPUTS = {"Problem", "Paper", "Part", "Row", "Run", "Drawing", "Reproduction", "WheelMonitor"}
INPUTS |= {"Samples", "Windows", "KnownWheels", "Telemetry", "Waterfall", "Window"}
INPUTS |= {"FrequencyResponse", "ModalModel", "MountedWheel"}
"""Classes that are questions, data of many rows, or pages of their own."""


def test_every_public_class_of_results_has_a_table_in_a_notebook():
    lacking, found = [], 0
    for room in ROOMS:
        module = importlib.import_module(f"gyrostat.{room}")
        for name in module.__all__:
            kind = getattr(module, name)
            if inspect.isclass(kind) and dataclasses.is_dataclass(kind) and name not in INPUTS:
                found += 1
                lacking += [] if hasattr(kind, "_repr_html_") else [f"{room}.{name}"]
    assert found > 15
    assert lacking == []


def test_parts_of_a_spacecraft_have_their_values_with_units():
    law = gs.Stribeck(viscous=1e-6, coulomb=1e-3, static=2e-3, stribeck_speed=0.4)
    html = unescape(gs.Wheel(inertia=1.5e-3, motor_constant=0.02, friction=law)._repr_html_())
    assert "<td>0.0015</td><td>Inertia of rotor and flywheel about the spin axis, kg·m²." in html
    assert "<td>Stribeck</td>" in html
    assert "<th>viscous</th><td>1e-06</td><td>N·m·s/rad</td>" in unescape(law._repr_html_())
    traced = []

    @jax.jit
    def compiled(value):
        traced.append(field_table(gs.ViscousCoulomb(viscous=value, coulomb=value)))
        return value

    compiled(1.0)
    assert "float64 of shape ()" in traced[0]


@dataclasses.dataclass
class Part:
    """A part.

    Attributes:
        value: Torque, with a long
            line, N·m.
        sigma: Its standard deviation, N·m.
        many: Speeds, (N,), rad/s.
        few: <b>.
        none: Nothing.

    Further text: no field.
    """

    value: float = 2e-5
    sigma: float = 1e-6
    many: object = dataclasses.field(default_factory=lambda: np.linspace(0.0, 1.0, 1000))
    few: object = dataclasses.field(default_factory=lambda: {"a": 1.0, "b": np.ones(2)})
    none: object = None


def test_a_table_has_sigma_meaning_and_the_range_of_long_arrays():
    assert meanings_of(Part)["value"] == "Torque, with a long line, N·m."
    assert set(meanings_of(Part)) == {"value", "sigma", "many", "few", "none"}
    html = field_table(Part())
    assert f"<td>{measured(2e-5, 1e-6)}</td>" in html
    assert "<td>0 to 1, shape (1000,)</td>" in html
    assert "<td>a: 1, b: [1., 1.]</td><td>&lt;b&gt;.</td>" in html
    assert "<td>none</td>" in html


def test_estimates_have_their_uncertainty_and_unit():
    gyro = Estimate("angle_walk", 1e-5, 9e-6, 1.1e-5)
    assert PARAMETERS["angle_walk"].sheet_unit in unescape(gyro._repr_html_())
    assert "95 %" in gyro._repr_html_()
    assert hasattr(HarmonicEstimate, "_repr_html_")
    names, units = ("coulomb", "viscous"), ("N·m", "N·m·s/rad")
    covariance = np.diag([1e-10, 1e-16])
    values = np.array([1e-3, 2e-6])
    fit = StoredFit("a.json", "stribeck", names, units, values, covariance, {}, 1e-3, "7", None, 21)
    html = unescape(fit._repr_html_())
    assert all(text in html for text in (measured(1e-3, 1e-5), measured(2e-6, 1e-8), *units))
    assert "serial" not in html
    share = Line("noise", RunsEstimate(2.0, 1.0, 3.0), RunsEstimate(0.5, 0.4, 0.6))
    assert "<th>share</th><td>0.5 (0.4 to 0.6)</td>" in share._repr_html_()
    assert hasattr(Acceptance, "_repr_html_")


def test_a_posterior_is_drawn_in_the_unit_of_the_pages():
    draws = 1e-3 + 1e-5 * np.random.default_rng(0).standard_normal(4000)
    quantiles = np.quantile(draws, (0.025, 0.16, 0.5, 0.84, 0.975))
    sigma = float(draws.std())
    marginal = Marginal("coulomb", draws.mean(), sigma, quantiles, 1.0, 3900.0, draws, "N·m")
    posterior = Posterior((marginal,), 4, 0.3, (), ())
    axes = posterior.plot().axes[0]
    assert axes.get_xlabel() == "coulomb (mN·m)"
    line = axes.lines[0]
    peak = line.get_xdata()[np.argmax(line.get_ydata())]
    assert peak == pytest.approx(1e3 * draws.mean(), abs=2e-3)
    row = str(posterior).splitlines()[-1]
    assert measured(draws.mean(), sigma) in row
    assert row.endswith("N·m")


def test_a_record_and_a_track_are_drawn_with_their_values():
    time = np.arange(0.0, 50.0)
    speed = 10.0 * np.sin(time)
    speed[7] = np.nan
    record = Record("r", time, np.full(50, 0.1), speed, np.isfinite(speed), torque=1e-3 * time)
    upper, _, torque = record.plot().axes
    np.testing.assert_array_equal(upper.lines[0].get_ydata(), speed / RPM)
    assert torque.get_ylabel() == "torque (mN·m)"
    assert str(record).startswith("r: 50 samples over 49 s, 1 without a speed\n  speed: ")
    sigma = np.full(50, 0.02)
    track = FrictionTrack(time, speed, np.full(50, 1.1), sigma, np.ones(50), 1)
    assert measured(1.1, 0.02) in str(track)
    scale = track.plot().axes[0]
    assert scale.get_ylim()[0] < 1.0 < 1.12 < scale.get_ylim()[1]


def test_a_rehearsal_and_a_wheel_model_are_text_and_picture():
    shares = dict.fromkeys(REGRESSED, 0.01)
    faults = {
        "wear": Expected(1.3, 8, 6, 21.0, 4, 2),
        "stiction": Expected(2.0, 8, 0, np.inf, 0, 0),
    }
    rehearsal = Rehearsal(12.0, 1, shares, shares, faults)
    assert "wear of 1.3: alarm in 6 of 8 wheels" in str(rehearsal)
    left, right = rehearsal.plot().axes
    assert [bar.get_width() for bar in left.patches] == [75.0, 0.0, 50.0, 0.0, 25.0, 0.0]
    assert [bar.get_width() for bar in right.patches] == [21.0, 0.0]
    friction = {"viscous": 2e-6, "coulomb": 1e-3, "static": 1.2e-3, "stribeck_speed": 0.4}
    model = WheelModel(gs.Stribeck, {"inertia": 1e-3, **friction}, {"coulomb": 1e-5})
    assert measured(1e-3, 1e-5) in str(model)
    figure = model.plot()
    assert isinstance(figure, Figure)
    x, y = figure.axes[0].lines[1].get_data()
    assert y[-1] == pytest.approx(1e3 * (1e-3 + 2e-6 * x[-1] * RPM))


def test_check_is_shown_as_the_lines_of_the_command_line():
    said = []
    checked = gs.check("examples/scenarios/zero_crossing.toml", say=said.append)
    assert str(checked).splitlines() == said
    assert said[0] in unescape(checked._repr_html_())
