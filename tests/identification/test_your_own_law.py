"""A user's friction law in identification: as ours, with its text beside the results."""

import json
import shutil

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.core.errors import InputError
from gyrostat.core.units import RPM
from gyrostat.identification import identify
from gyrostat.identification.experiment.known_wheel import KnownWheel
from gyrostat.telemetry import Record
from gyrostat.wheel import read_model, write_model
from gyrostat.wheel.friction import Friction, parameter
from gyrostat.wheel.friction_laws import friction_law

COPY = '''
from gyrostat.wheel.friction import Friction, parameter
from shape import bell


class Copy(Friction):
    """F(w) = b w + sgn(w) [c + (T_s - c) exp(-w^2 / w_s^2)]."""

    held_by_default = ("range",)
    vanishing_at = {"static": "coulomb"}
    viscous: float = parameter("viscous")
    coulomb: float = parameter("torque")
    static: float = parameter("torque")
    range: float = parameter("rad/s", start=0.418879)

    def torque(self, speed, direction):
        excess = (self.static - self.coulomb) * bell(speed / self.range)
        return self.viscous * speed + direction * (self.coulomb + excess)
'''
SHAPE = "import jax.numpy as jnp\n\n\ndef bell(x):\n    return jnp.exp(-(x**2))\n"
TRUTH = {"motor_constant": 0.0228, "viscous": 4e-6, "coulomb": 8e-4, "drag": 1e-7}
INERTIA, STEP = 1.5e-3, 0.2


class Drag(Friction):
    """F(w) = b w + sgn(w) (c + d w²)."""

    viscous: float = parameter("viscous")
    coulomb: float = parameter("torque")
    drag: float = parameter("N·m·s²/rad²")

    def torque(self, speed, direction):
        return self.viscous * speed + direction * (self.coulomb + self.drag * speed**2)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with the file of a law and a module that it imports."""
    made = tmp_path_factory.mktemp("laws")
    (made / "mine.py").write_text(COPY)
    (made / "shape.py").write_text(SHAPE)
    return made


@pytest.fixture(scope="module")
def saved(folder, record):
    """Folder with the results of an identification by the law of the file."""
    out = folder / "out"
    law = f"{folder / 'mine.py'}:Copy"
    gs.identify(record(), out, inertia=INERTIA, model=law, hold={"range": "4 rpm"})
    return out


def test_copy_of_a_law_under_another_name_gives_the_same_fit(saved, record):
    ours = identify(record(), inertia=INERTIA, hold={"stribeck_speed": 4 * RPM}).to_dict()
    copy = json.loads((saved / "fit.json").read_text())
    assert copy["model"] == "Copy"
    assert copy["parameters"].keys() == ours["parameters"].keys()
    for name, row in ours["parameters"].items():
        for key in ("value", "sigma", "sigma_noise", "significance"):
            assert copy["parameters"][name][key] == pytest.approx(row[key], rel=1e-9), (name, key)
        assert copy["parameters"][name]["unit"] == row["unit"]
        assert copy["parameters"][name]["observable"] == row["observable"]
    renamed = [warning.replace("Copy", "stribeck") for warning in copy["warnings"]]
    assert renamed == ours["warnings"]
    assert copy["diagnosis"] == ours["diagnosis"]


def test_text_of_a_law_travels_with_model_and_fit(saved, folder, tmp_path):
    assert (saved / "mine.py").read_text() == COPY
    assert (saved / "shape.py").read_text() == SHAPE
    moved = shutil.copytree(saved, tmp_path / "moved")
    model = read_model(moved / "model.toml")
    assert model.friction.__name__ == "Copy"
    assert model.values["range"] == pytest.approx(4 * RPM)
    known = KnownWheel.read(moved / "fit.json")
    assert known.model is model.friction
    again = tmp_path / "again"
    again.mkdir()
    write_model(again / "model.toml", model)
    assert read_model(again / "model.toml").values == model.values


@pytest.mark.parametrize("name", ["model.toml", "fit.json"])
def test_edited_or_missing_text_is_noticed_in_one_line(saved, tmp_path, name):
    read = {"model.toml": read_model, "fit.json": KnownWheel.read}[name]
    moved = shutil.copytree(saved, tmp_path / "moved")
    (moved / "shape.py").write_text(SHAPE.replace("x**2", "x**4"))
    with pytest.raises(InputError, match=r"shape.py: found a text that was edited since .*\Z"):
        read(moved / name)
    (moved / "shape.py").unlink()
    with pytest.raises(InputError, match=r"found no file .*shape.py, expected the text of mine.py"):
        read(moved / name)


def test_model_with_wrong_numbers_or_law_is_refused_with_its_key(saved, tmp_path):
    moved = shutil.copytree(saved, tmp_path / "moved")
    text = (moved / "model.toml").read_text()
    for old, new, message in (
        ("mine.py:Copy", "mine.py:bell", "key friction.model mine.py:bell: found"),
        ("mine.py:Copy", "mine.py:Nope", "mine.py: found no Nope, expected one of Copy"),
        ("range = ", "scale = ", "key friction.scale: found an unknown key"),
        ('"mine.py:Copy"', '"stribeck"', "key sources: found it, expected none"),
    ):
        (moved / "model.toml").write_text(text.replace(old, new))
        with pytest.raises(InputError, match=message):
            read_model(moved / "model.toml")


def test_saved_law_is_refused_where_a_file_of_the_user_is_in_the_way(folder, record, tmp_path):
    (tmp_path / "shape.py").write_text("kept = 1\n")
    law = f"{folder / 'mine.py'}:Copy"
    with pytest.raises(InputError, match=r"shape.py: found a file that gyrostat identify did not"):
        gs.identify(record(), tmp_path, inertia=INERTIA, model=law)
    assert [path.name for path in tmp_path.iterdir()] == ["shape.py"]


@pytest.fixture(scope="module")
def exact():
    """Currents and speeds of a wheel with drag, by small Runge-Kutta steps without the package."""
    inner, (k, b, c, d) = 100, TRUTH.values()
    current = np.repeat([0.2, -0.2, 0.12, -0.15, 0.2, -0.1], 200)
    speed, speeds, length = 0.0, [], STEP / inner
    for torque in k * current:
        speeds.append(speed)
        for _ in range(inner):
            sense = np.sign(speed) or np.sign(torque)
            middle = (torque - b * speed - sense * (c + d * speed**2)) / INERTIA
            middle = speed + 0.5 * length * middle
            after = speed + length * (torque - b * middle - sense * (c + d * middle**2)) / INERTIA
            if after * sense < 0.0:  # exactly to zero, then in the other direction
                left = 1.0 - speed / (speed - after)
                after = left * length * (torque + sense * c) / INERTIA
            speed = after
    return current, np.array(speeds)


def test_new_law_is_recovered_within_its_sigmas_from_independent_records(exact):
    current, speed = exact
    time, every = STEP * np.arange(len(speed)), np.ones(len(speed), dtype=bool)
    errors = []
    for seed in range(4):
        noise = np.random.default_rng(seed).normal(0.0, 0.3, len(speed))
        record = Record(f"drag-{seed}", time, current, speed + noise, every)
        fit = identify(record, inertia=INERTIA, model=Drag, speed_sigma=0.3)
        assert fit.converged
        assert not fit.impossible
        assert fit.observability["drag"].observable
        errors += [(fit.parameters[n] - v) / fit.sigma[n] for n, v in TRUTH.items()]
    assert np.max(np.abs(errors)) < 4.0
    assert 0.2 < np.sqrt(np.mean(np.square(errors))) < 1.6


def test_start_values_that_are_no_friction_are_refused_once(record):
    class Reversed(Drag):
        def torque(self, speed, direction):
            return self.viscous * speed - direction * self.coulomb

    with pytest.raises(InputError, match=r"Reversed at the start values: found .* at zero speed"):
        identify(record(), inertia=INERTIA, model=Reversed)
    with pytest.raises(InputError, match="start of drag: found -1, expected 0 N·m·s²/rad² or more"):
        identify(record(), inertia=INERTIA, model=Drag, start={"drag": -1.0})


def test_law_of_a_function_works_but_its_text_cannot_be_saved(record, tmp_path):
    class Inner(Drag):
        pass

    with pytest.raises(InputError, match=r"Inner: found a lambda, or a definition inside another"):
        gs.identify(record(), tmp_path / "out", inertia=INERTIA, model=Inner)
    assert not (tmp_path / "out").exists()
    assert friction_law(Inner) is Inner
