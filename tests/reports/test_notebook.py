"""Results in a notebook and in a script: pictures to edit, texts, names to complete."""

import pickle
import re

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import gyrostat as gs
from gyrostat.campaigns import campaign_runs
from gyrostat.core.pictured_datasets import Run, Runs


@pytest.fixture(scope="module")
def runs(small):
    return campaign_runs(small.out)


@pytest.fixture(scope="module")
def run(small, scenario):
    """A run that the campaign has kept, as `replay` gives it."""
    from gyrostat.verbs.single_runs import _run_of

    number = min(small.store.histories(small.store.known()))
    with xr.open_dataset(small.store.history(number), engine="h5netcdf") as history:
        return _run_of(history.load(), scenario, **small.store.columns().row(number))


def test_a_run_is_drawn_with_its_numbers_and_events(run, scenario):
    figure = run.plot()
    assert isinstance(figure, Figure)
    titled = {axes.get_title("left"): axes for axes in figure.axes}
    speeds = titled["wheel speed (rpm)"].get_lines()
    assert [line.get_label() for line in speeds[: len(scenario.wheels)]] == [*scenario.wheels]
    drawn = speeds[1].get_ydata()
    measured = run.wheel_speed.values[:, 1] * 30.0 / np.pi
    ends = [(np.max(each), np.min(each)) for each in (drawn, measured)]
    np.testing.assert_allclose(*ends, rtol=1e-12)
    names = {text.get_text().strip() for text in titled["pointing error (deg)"].texts}
    assert {event.name for event in scenario.events} <= names
    # the user's own change of the figure is kept
    figure.axes[0].set_title("mine", loc="left")
    assert figure.axes[0].get_title("left") == "mine"


def test_a_part_of_a_run_can_be_drawn_and_xarray_stays(run):
    part = run.sel(time=slice(5.0, 20.0))
    assert isinstance(part, Run)
    low, high = part.plot().axes[0].get_xlim()
    assert 5.0 <= low < high <= 20.0
    assert isinstance(run.to_dataframe().index.names, list)
    assert callable(run.plot.scatter)
    with pytest.raises(gs.InputError, match="found no torque over time"):
        run.drop_vars("torque").plot()
    for other in (run[["error"]], run.isel(time=slice(0)), run.transpose(..., "time")):
        with pytest.raises(gs.InputError, match="found no "):
            other.plot()
    with pytest.raises(gs.InputError, match="plot: found the wheels "):
        run.isel(wheel=slice(None, None, -1)).plot()


def test_the_text_of_a_part_is_not_that_of_the_whole(run, runs):
    parts = [run.sel(time=slice(5.0, 20.0)), run.isel(time=3), run[["error"]], run.mean("time")]
    parts += [xr.concat([run, run], "run"), runs.isel(run=slice(3)), runs[["torque_rms"]]]
    for part in parts:
        assert str(part) == repr(part)
        assert "data:image/png" not in part._repr_html_()
    with pytest.raises(gs.InputError, match="found a part of a campaign"):
        runs.isel(run=slice(3)).plot()
    for copied in (pickle.loads(pickle.dumps(run)), run.copy(deep=True)):
        assert str(copied) == str(run) != repr(run)


def test_texts_are_those_of_the_command_line(run, runs, small):
    lines = str(run).splitlines()
    assert lines[0].startswith("small: complete, 30 s")
    assert re.fullmatch(r"  torque_peak: \S+ µN·m", next(x for x in lines if "torque_peak" in x))
    assert str(runs).splitlines()[0].startswith(f"{small.runs} runs of small: ")
    assert repr(runs).startswith("<xarray.Runs>")
    bare = Runs({"a": ("run", [1.0])})
    assert str(bare) == repr(bare)


def test_a_notebook_shows_text_picture_and_dataset(run, runs):
    for dataset in (run, runs):
        shown = dataset._repr_html_()
        assert shown.count('src="data:image/png;base64,') == 1
        assert "xr-wrap" in shown


def test_runs_are_drawn_with_the_counts_of_their_metrics(runs, small):
    figure = runs.plot()
    names = [axes.get_title("left") for axes in figure.axes if axes.get_visible()]
    assert names
    for axes, name in zip(figure.axes, names, strict=False):
        (bars,) = axes.patches
        assert np.sum(bars.get_data().values) == np.sum(np.isfinite(runs[name].values))


def test_answers_of_feasible_have_a_map_and_sentences():
    file = "examples/three_wheels.toml"
    question = {"momentum": [0.4, 0.1, 0.2], "failed": {"x": 0.3}}
    answer = gs.feasible(file, boresight="z", towards=[0, 0, 1], **question)
    (axes,) = answer.plot().axes
    cells = next(each for each in axes.collections if each.get_array() is not None)
    *_, holds = answer.sky.grid(180)
    np.testing.assert_array_equal(np.isfinite(cells.get_array()).reshape(holds.shape), holds)
    assert f"{100.0 * answer.sky.fraction:.1f} %" in axes.get_title()
    assert str(answer).splitlines()[0].startswith("the direction is")
    assert "question" not in answer.to_dict()
    assert len(gs.feasible(file, target=[1, 0, 0, 0], **question).plot().axes) == 3


def test_names_to_complete_are_those_for_users():
    shown = {name for name in dir(gs) if not name.startswith("__")}
    assert shown == set(gs.__all__) - {"__version__"}
    import gyrostat.control

    assert "lazy_names" not in dir(gyrostat.control)
    assert gs.control is gyrostat.control


def test_a_bar_is_shown_in_a_terminal_alone(capsys, monkeypatch):
    from gyrostat.verbs import progress

    def mine(done, total):
        del done, total

    monkeypatch.setattr("sys.stderr.isatty", lambda: False, raising=False)
    assert progress.shown(None) is None
    assert progress.shown(mine) is mine
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    update = progress.shown(None)
    for done in (0, 1, 2, 50, 100):  # those in between come too soon after the first
        update(done, 100)
    written = capsys.readouterr().err
    assert written.count("\r") == 2
    assert "100 of 100 runs" in written
    assert written.endswith("\n")
