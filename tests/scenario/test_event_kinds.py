"""Kinds of events: one class in one file is all that a new one needs."""

from dataclasses import dataclass
from pkgutil import iter_modules
from typing import Annotated

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.core.arrays import Scalar
from gyrostat.core.errors import InputError
from gyrostat.scenario.event_kind import DETECTED, EventKind, FrictionChange, WheelFailure
from gyrostat.scenario.kinds import event as folder
from gyrostat.scenario.kinds import events
from gyrostat.scenario.kinds.events import EVENTS, kind_of
from gyrostat.scenario.scenario import Event
from gyrostat.scenario.schema import positive
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario_files.scenario_file import read_scenario


@dataclass(frozen=True, eq=False)
class Weakened(WheelFailure):
    """The motor of `wheel` gives its torque divided by `ratio`."""

    name = "weakened"
    loses_wheel = True
    ratio: Annotated[Scalar, positive("1", None, "Ratio.")]
    detected_after: Annotated[Scalar, DETECTED]

    def effect(self):
        return {"torque_share": 1.0 / self.ratio}


@dataclass(frozen=True, eq=False)
class Worn(FrictionChange):
    """The friction torques of `wheel` are multiplied by `ratio`."""

    name = "worn"
    ratio: Annotated[Scalar, positive("1", None, "Ratio.")]

    def after(self, parameter, dimension, before, values):
        return before * (self.ratio if dimension == "torque" else 1.0)


@pytest.fixture
def read(short, monkeypatch):
    """Reads the short scenario with events of these lines."""
    for kind in (Weakened, Worn):
        monkeypatch.setitem(events.EVENTS, kind.name, kind)

    def with_events(*lines):
        rows = (f'[[event]]\nname = "e{k}"\ntime = 1.0\n{row}\n' for k, row in enumerate(lines))
        return read_scenario(short('kind = "three_axis"', "".join(rows)))

    return with_events


def test_every_file_of_the_folder_is_a_kind():
    files = {file.name for file in iter_modules(folder.__path__)}
    assert files == {*EVENTS}
    assert all(kind.__module__ == f"{folder.__name__}.{name}" for name, kind in EVENTS.items())
    assert all(kind.__doc__ and kind.affects for kind in EVENTS.values())


def test_a_new_failure_does_what_a_shipped_one_does(read):
    own = read('kind = "weakened"\nwheel = "b"\nratio = 4.0')
    shipped = read('kind = "degraded"\nwheel = "b"\ntorque_share = 0.25')
    # the controller is notified of the first one alone, so that there is one design more
    assert [event.name for event in structure_of(own).turning_points] == ["e0"]
    assert structure_of(shipped).turning_points == ()
    assert own.values["event.e0.detected_after"] == 1.0
    found, expected = (gs.simulate(each) for each in (own, shipped))
    before = found.time.values <= 1.0
    np.testing.assert_array_equal(found.wheel_speed[before], expected.wheel_speed[before])


def test_a_new_change_of_friction_does_what_a_shipped_one_does(read):
    own = read('kind = "worn"\nwheel = "b"\nratio = 4.0')
    values = own.values
    shipped = read(
        f'kind = "friction_step"\nwheel = "b"\ncoulomb = {4.0 * values["wheel.b.coulomb"]!r}'
    )
    found, expected = (gs.simulate(each) for each in (own, shipped))
    np.testing.assert_allclose(found.wheel_speed, expected.wheel_speed, rtol=1e-12, atol=1e-12)


def test_a_wheel_can_have_a_failure_and_a_change_of_friction(read):
    failing, worn = 'kind = "weakened"\nwheel = "b"\nratio = 4.0', 'kind = "worn"\nwheel = "b"\n'
    assert len(read(failing, f"{worn}ratio = 2.0").events) == 2
    for twice in ((failing, failing), (f"{worn}ratio = 2.0", f"{worn}ratio = 3.0")):
        with pytest.raises(InputError, match="one failure and one friction step per wheel"):
            read(*twice)


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        ('kind = "weakened"\nwheel = "b"', "ratio: found none, expected above 0"),
        ('kind = "weakened"\nwheel = "z"\nratio = 2.0', "found no wheel 'z'"),
        ('kind = "weakening"', "found 'weakening', expected one of degraded, drag, friction_step"),
        ('kind = "friction_step"\nwheel = "b"', "factor: found none, expected one, or values of "),
    ],
)
def test_events_that_cannot_be_are_one_line(read, row, expected):
    with pytest.raises(InputError) as caught:
        read(row)
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_event_of_a_user_changes_the_plant_alone():
    kind = kind_of(Event("e", "mine.py:Change"))
    assert kind is EventKind
    assert not any((kind.changes_target, kind.loses_wheel, kind.stops_rotor))
