"""Rules for parameters and units, declared at the field."""

from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest

from gyrostat.core.checked import (
    Checked,
    declared_units,
    finite,
    from_start,
    limit,
    positive,
    positive_share,
    share,
    signed,
    size,
    three,
)
from gyrostat.core.delay_line import empty_line, is_delay, pushed
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.validation import check_period


class Motor(Checked):
    constant: Annotated[Any, positive("motor constant", "N·m/A")] = 1.0
    most: Annotated[Any, limit("motor limit", "A"), "A"] = None

    def check_own(self):
        if np.any(np.asarray(self.constant) == 13.0):
            raise InputError("motor constant: found 13, expected another")

    def check_own_period(self, period):
        if period > self.constant:
            raise InputError(f"control period: found {period:g} s")


class Drive(Checked):
    motor: Any
    spares: tuple = ()
    own: Any = None


class Unfit:
    """A user's own part, which knows nothing of rules."""

    def check(self):
        raise InputError("own part: found unfit")


@pytest.mark.parametrize(
    ("rule", "fits", "refused", "message"),
    [
        (positive("gain", "1/s"), [1e-9, 5.0], 0.0, "gain: found 0, expected a finite value above"),
        (size("noise", "rad"), [0.0, 2.0], -1.0, "noise: found -1, expected a finite value of 0"),
        (signed("bias", "rad"), [-3.0, 0.0], np.inf, "bias: found inf"),
        (limit("rate limit", "rad/s"), [np.inf, 1.0], 0.0, "found 0, expected above 0 rad/s"),
        (
            finite("torque", "N·m"),
            [-1.0],
            np.nan,
            "torque: found nan, expected a finite value, N·m",
        ),
        (from_start("failure time"), [0.0, np.inf], -1.0, "found -1 s, expected 0 s .the start."),
        (share("part"), [0.0, 1.0], 1.1, "part: found 1.1, expected 0 to 1"),
        (positive_share("part"), [1.0], 0.0, r"part: found 0, expected in \(0, 1\]"),
        (is_delay, [0, 3], -1, "command delay: found -1, expected 0 periods or more"),
    ],
)
def test_a_rule_refuses_one_of_many_values_and_nan(rule, fits, refused, message):
    rule.test(np.array(fits))
    with pytest.raises(InputError, match=message):
        rule.test(np.array([*fits, refused]))
    with pytest.raises(InputError):
        rule.test(np.nan)


def test_three_values_are_three():
    three("momentum").test(np.zeros((7, 3)))
    for wrong in (np.zeros(2), 1.0, [0.0, np.nan, 0.0]):
        with pytest.raises(InputError, match="momentum: found"):
            three("momentum").test(wrong)


@pytest.mark.parametrize(
    ("part", "message"),
    [
        (Motor(0.0), "motor constant: found 0"),
        (Motor(np.array([1.0, -2.0])), "motor constant: found -2"),
        (Motor(1.0, 0.0), "motor limit: found 0"),
        (Motor(13.0), "found 13"),
        (Drive(Motor(-1.0)), "motor constant: found -1"),
        (Drive(Motor(), (Motor(), Motor(-3.0))), "motor constant: found -3"),
        (Drive(Motor(), (), Unfit()), "own part: found unfit"),
    ],
)
def test_a_part_refuses_what_a_field_a_part_or_itself_refuses(part, message):
    with pytest.raises(InputError, match=message):
        part.check()


def test_what_fits_is_accepted_and_none_is_not_tested():
    Drive(Motor(np.array([1.0, 2.0]), None), (Motor(3.0, 1.0),), object()).check()


def test_parts_refuse_a_control_period():
    drive = Drive(Motor(2.0), (Motor(1.0),))
    check_period(1.0, drive)
    with pytest.raises(InputError, match=r"found 1\.5 s"):
        drive.check_period(1.5)


def test_a_rule_says_in_a_signature_what_it_wants():
    assert repr(positive("gain", "1/s")) == "above 0 1/s"


def test_units_stand_at_the_field_or_in_a_table():
    class Sample(NamedTuple):
        rate: Annotated[Any, "rad/s"]
        number: Any

    class Own(NamedTuple):
        rate: Any
        UNITS = {"rate": "deg/s"}  # noqa: RUF012

    assert declared_units(Sample) == {"rate": "rad/s"}
    assert declared_units(Own) == {"rate": "deg/s"}
    assert declared_units(float) == {}


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_a_delay_line_gives_each_value_a_delay_later(delay):
    line, found = empty_line({"a": jnp.zeros(2), "b": jnp.zeros(())}, delay), []
    for k in range(1, 6):
        line, arrived = pushed(line, {"a": jnp.full(2, float(k)), "b": 10.0 * k})
        found.append((float(arrived["a"][1]), float(arrived["b"])))
    assert found == [(max(k - delay, 0), 10.0 * max(k - delay, 0)) for k in range(1, 6)]
