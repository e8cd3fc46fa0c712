"""Defaults that are written twice, for scenario files and for Python, agree."""

import dataclasses
from typing import get_type_hints

import numpy as np
import pytest

from gyrostat.scenario.kinds.registry import KINDS, PARTS

OTHERS = {
    # in a scenario they follow from the command delay and the sensors, which the class cannot know
    ("WheelArrayControl", "turn_gain"),
    ("WheelArrayControl", "rate_gain"),
    # None in Python: without an estimate of the external torque
    ("AttitudeRegulator", "torque_time"),
    ("MomentumRecovery", "torque_time"),
}
"""Class and field whose default differs on purpose."""


def pairs():
    """Kind, the class that it makes, and each field of that class which is a key of the kind."""
    for section, kinds in {**KINDS, **PARTS}.items():
        for name, kind in kinds.items():
            for method in ("make", "controller"):
                made = get_type_hints(getattr(kind, method, pairs)).get("return")
                if dataclasses.is_dataclass(made):
                    keys = kind.keys()
                    for field in dataclasses.fields(made):
                        if field.name in keys and field.default is not dataclasses.MISSING:
                            yield pytest.param(
                                made, field, keys[field.name], id=f"{section} {name} {field.name}"
                            )


def test_there_are_many():
    assert len(list(pairs())) > 40


@pytest.mark.parametrize(("made", "field", "key"), list(pairs()))
def test_a_kind_has_the_defaults_of_the_class_that_it_makes(made, field, key):
    if (made.__name__, field.name) in OTHERS:
        assert field.default is None or field.default != key.default
    else:
        np.testing.assert_array_equal(np.asarray(field.default, float), key.default)
