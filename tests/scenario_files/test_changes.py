"""Changes of a scenario from Python, and definitions that are extracted from a script."""

import sys
from collections import namedtuple
from dataclasses import replace
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.user_errors import UserPartError
from gyrostat.scenario import Scenario
from gyrostat.scenario_files.python.script_source import extracted


def test_values_and_attributes_are_replaced(scenario):
    changes = {
        "controller.turn_gain": 0.3,
        "wheel.a.speed": "100 rpm",
        "environment.external_torque": ["2 µN·m", 0.0, 1e-6],
        "run.duration": "40 s",
        "event.turn.time": "7 s",
    }
    made = scenario.replace(name="other", command_delay=1, **changes)
    assert made.name == "other"
    assert (made.command_delay, made.count) == (1, 160)
    assert made.values["wheel.a.speed"] == pytest.approx(100.0 * 2.0 * np.pi / 60.0, rel=1e-15)
    torque = [made.values[f"environment.external_torque.{axis}"] for axis in "xyz"]
    assert torque == [2e-6, 0.0, 1e-6]
    assert [event.name for event in made.events] == ["turn", "loss", "worn"]
    assert scenario.replace() == scenario
    assert Scenario.from_text(made.text()) == made


def test_a_component_has_its_defaults(scenario):
    plain = replace(scenario, dispersions=())
    made = plain.replace(controller="wheel_array", **{"controller.rate_gain": 0.3})
    assert made.values["controller.rate_gain"] == 0.3
    assert made.values["controller.momentum_gain"] == 1e-3
    assert made.controller == "wheel_array"
    assert list(made.values) == sorted(made.values)


def test_required_keys_of_a_component_can_be_given_with_it(scenario):
    plain = replace(scenario, dispersions=())
    made = plain.replace(environment="orbit", **{"environment.altitude": 500e3})
    assert made.values["environment.altitude"] == 500e3
    assert made.values["environment.inclination"] == 0.0


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"controller.turn_gian": 1.0}, "an unknown key (did you mean controller.turn_gain?)"),
        ({"controler": "lqr"}, "key controler: found an unknown key (did you mean controller?)"),
        ({"controller": "lqq"}, "key controller: found 'lqq', expected one of detumbling"),
        ({"controller": 3}, "found int of builtins, which is no local file, expected an object"),
        ({"controller": Scenario}, "found a class of gyrostat, expected a class of yours"),
        ({"sensors": 3}, "found int as sensors, expected one of star_tracker"),
        ({"sensors": "star_tracker_gyro"}, "key sensors.attitude_sigma: found none"),
        ({"estimator": "kalman"}, "found the estimator kalman, expected none for the sensors"),
        ({"controller.turn_gain": -1.0}, "key controller.turn_gain: found -1.0, expected above 0"),
        ({"controller.turn_gain": "a"}, "key controller.turn_gain: found 'a', expected a finite"),
        ({"environment.external_torque": [1.0]}, "found [1.0], expected 3 values"),
        ({"run.duration": 0.3}, "a whole multiple of the control period, 0.25 s"),
        ({"run.duration": 10.0}, "expected a time before the end of the run, 10 s"),
        (
            {"metrics.after": 30.0},
            "metrics.after: found 30 s, expected a time before the end",
        ),
        ({"wheels": ("a",)}, "key wheels: found an unknown key"),
        ({"compensator": "none", "dispersions": 3}, "found 3 as dispersions"),
    ],
)
def test_wrong_changes_give_one_line(scenario, changes, expected):
    with pytest.raises(InputError) as caught:
        scenario.replace(**changes)
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


def test_dispersions_of_a_replaced_component_must_be_replaced_too(scenario):
    first = replace(scenario.dispersions[0], keys=("controller.turn_gain",), parameters=((0.1,),))
    plain = replace(scenario, dispersions=(first,))
    with pytest.raises(InputError, match=r"found a dispersion of controller\.turn_gain"):
        plain.replace(controller="lqr")


@pytest.fixture
def notebook(monkeypatch):
    """Executes cells as a notebook does, in a module `__main__`."""
    module = ModuleType("__main__")
    monkeypatch.setitem(sys.modules, "__main__", module)
    module.In = [""]

    def run(*cells):
        for cell in cells:
            module.In.append(cell)
            exec(cell, vars(module))
        return SimpleNamespace(**vars(module))

    return run


def text_of(made):
    name, text, *_ = extracted("controller P", made)
    assert name == f"notebook_{made.__name__}.py"
    found: dict = {}
    exec(text, found)
    return text, found


def test_only_what_a_class_uses_is_extracted(notebook):
    cells = notebook(
        "import math\nimport numpy as np\nfrom typing import NamedTuple\nunused = open",
        "class Command(NamedTuple):\n    torque: 'Any'\n    x: float = 1.0",
        "K = np.array([1.0, 1.0]) / 3.0\nlimits = {'a': (1, [2.5, -math.inf])}\nq = object()",
        "def inner(x):\n    q = 2.0 * x\n    return q * SHARE + math.pi",
        "def law(x): return inner(x) * K[0]\nSHARE = 0.5",
        "class P:\n    gain: float = 1.0\n    def __call__(self, x):\n"
        "        return Command(law(x) + limits['a'][0])",
        "SHARE = 0.1\nK = K / 3.0",
    )
    text, found = text_of(cells.P)
    assert "unused" not in text
    assert "object" not in text
    assert found["K"].tobytes() == cells.K.tobytes()
    assert found["limits"] == cells.limits
    # the latest values, not those of the cell
    assert found["P"]()(0.7) == cells.P()(0.7)


def test_the_latest_definition_is_extracted(notebook):
    cells = notebook("def f(): return 1", "class P:\n    x = f", "def f(): return 2")
    assert text_of(cells.P)[1]["P"].x() == 2


def test_named_tuples_and_functions_made_by_a_call_are_extracted(notebook):
    cells = notebook(
        "from collections import namedtuple\nCommand = namedtuple('Command', 'torque')",
        "from functools import partial\ntwice = lambda x: 2 * x\nlaw = partial(twice, 0.5)",
        "class P:\n    made = Command(law())",
    )
    assert text_of(cells.P)[1]["P"].made == namedtuple("Command", "torque")(1.0)


@pytest.mark.parametrize(
    ("cell", "expected"),
    [
        ("for table in [object()]:\n    pass", "found table, a object of the script, expected num"),
        ("for table in [{1: object()}]:\n    pass", "found table, a dict of the script"),
    ],
)
def test_what_cannot_be_extracted_is_refused(notebook, cell, expected):
    cells = notebook(cell, "class P:\n    def __call__(self):\n        return table")
    with pytest.raises(UserPartError) as caught:
        extracted("controller P", cells.P)
    assert expected in str(caught.value)


def test_a_class_inside_a_function_is_refused(scenario):
    class Inside:
        """Its variables cannot be found again."""

    for given in (Inside(), lambda time: time):
        with pytest.raises(InputError, match="found a lambda, or a definition inside another, exp"):
            scenario.replace(controller=given)


def test_an_object_of_an_earlier_definition_is_refused(notebook, scenario):
    """The text of the present definition may differ."""
    cells = notebook("class P:\n    pass", "old = P()\nclass P:\n    x = 1")
    with pytest.raises(InputError, match="found an earlier definition of P, expected an object of"):
        scenario.replace(controller=cells.old)
