"""The safe mode of this package: from tumbling to science, and back when a wheel is lost."""

from itertools import groupby

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.core.errors import InputError
from gyrostat.scenario_files.scenario_file import read_scenario

MODES = ("detumble", "search_x", "search_y", "safe", "science", "science_three")


@pytest.fixture(scope="module")
def flown():
    return gs.simulate("safe_mode", engine="native")


def test_modes_follow_each_other(flown):
    numbers = [int(number) for number in np.asarray(flown["mode"])]
    stays = [(MODES[number], len([*stay])) for number, stay in groupby(numbers)]
    names = [name for name, _ in stays]
    assert names[:2] == ["detumble", "search_x"]
    science = names.index("science")
    assert names[science - 1] == "safe"
    assert names[science + 1] == "safe"
    assert names[-1] == "science_three"


def test_each_mode_does_what_it_is_for(flown):
    time, mode = np.asarray(flown["time"]), np.asarray(flown["mode"])
    momentum = np.linalg.norm(np.asarray(flown["momentum"]), axis=1)
    begin = np.flatnonzero(np.diff(mode, prepend=-1))
    start = {MODES[int(mode[k])]: k for k in begin[::-1]}  # the first stay
    # rods reduce the momentum below the limit of the transition, up to the noise of its measurement
    assert momentum[0] > 0.02
    assert momentum[start["search_x"]] == pytest.approx(0.02, rel=0.02)
    # the panel axis is at the Sun at the end of a stay in the safe mode
    error = np.degrees(np.asarray(flown["error"]))
    assert error[start["science"] - 1] < 5.0
    # the wheel is lost in science, which is noticed within seconds
    back = next(k for k in begin if k > start["science"])
    assert MODES[int(mode[back])] == "safe"
    assert 0.0 < time[back] - 4000.0 < 60.0
    assert error[-1] < 0.5
    assert flown.attrs["mode.science.error_rms"] < np.radians(0.5)


def test_a_name_that_is_no_scenario_is_one_line():
    with pytest.raises(InputError, match=r"safe_mod: found no such file .*package: safe_mode"):
        read_scenario("safe_mod")


def test_a_file_of_the_user_goes_before_a_scenario_of_the_package(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "safe_mode").write_text("name = 3")
    with pytest.raises(InputError, match=r"^safe_mode: key spacecraft.file: found None"):
        read_scenario("safe_mode")
