"""A new part to export is one class in one file: its options, its design and its module."""

import pytest

from gyrostat import export
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.exports.target import STEPS, flight_module
from gyrostat.verbs import part_kinds
from gyrostat.verbs.exported_part import ExportedPart
from gyrostat.verbs.required_options import missing_of_part
from gyrostat.wheel import WheelModel
from gyrostat.wheel.friction import ViscousCoulomb

VALUES = {"inertia": 1.5e-3, "motor_constant": 0.0228, "viscous": 4.8e-6, "coulomb": 8.8e-4}
MODEL = WheelModel(ViscousCoulomb, VALUES)


def current(motor_constant, torque):
    """Motor current for a torque."""
    return torque / motor_constant


class Divider(ExportedPart):
    """Current for a torque."""

    name = "divider"
    needs = ("--scale-drift",)

    @classmethod
    def design(cls, wheel, period, given):
        return given.number("--scale-drift") * wheel.motor_constant

    @classmethod
    def module(cls, part, period, limits, on_bad):
        return flight_module(
            "divider",
            {"motor_constant": jnp.asarray(part)},
            {},
            [],
            [("step", current, ("current",))],
            title="Current for a torque",
            period=period,
            constants={},
            inputs={"torque": jnp.linspace(-1.0, 1.0, STEPS)},
        )


@pytest.fixture(autouse=True)
def known(monkeypatch, tmp_path):
    monkeypatch.setenv("GYROSTAT_CACHE", str(tmp_path / "cache"))
    monkeypatch.setitem(part_kinds.PARTS, "divider", Divider)


def test_it_is_designed_and_written(tmp_path):
    given = {"to": "c", "what": "divider", "period": "100ms", "scale_drift": 2.0}
    written = export(MODEL, tmp_path / "out", **given)
    assert {"divider.h", "divider.c", "divider_test.c"} <= {path.name for path in written}
    assert "0.0456" in (tmp_path / "out" / "divider.c").read_text()  # twice the motor constant


def test_its_options_are_asked_for_and_others_refused(tmp_path):
    assert missing_of_part("divider", {"period": "1s"}, is_designed=True) == ["--scale-drift"]
    given = {"to": "c", "what": "divider", "period": "100ms", "scale_drift": 2.0}
    with pytest.raises(InputError, match="what divider: found gains, expected these with"):
        export(MODEL, tmp_path / "out", **given, gains="1,2,3")
    with pytest.raises(InputError, match="on_bad"):
        export(MODEL, tmp_path / "out", **given, on_bad="zero")
