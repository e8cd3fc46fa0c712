"""Flight code that was made before is not traced again."""

from pathlib import Path

import pytest

import gyrostat.exports
from gyrostat import export
from gyrostat.control import AttitudePID, CurrentMode
from gyrostat.core import cache_entries, stored_function
from gyrostat.verbs import exported_parts, exports
from gyrostat.wheel import WheelModel
from gyrostat.wheel.friction import Stribeck, ViscousCoulomb

GIVEN = {"to": "c", "what": "controller", "period": "100ms", "gains": "0.0571,0.00234,0.3126"}
VALUES = {"inertia": 1.5e-3, "motor_constant": 0.0228, "viscous": 4.8e-6, "coulomb": 8.8e-4}
MODEL = WheelModel(ViscousCoulomb, VALUES)


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("GYROSTAT_CACHE", str(tmp_path / "cache"))
    stored_function._machine.cache_clear()
    yield tmp_path / "cache"
    stored_function._machine.cache_clear()


@pytest.fixture
def made(monkeypatch):
    """Origins of the texts that were made; they are made in no time here."""
    origins = []

    def files(target, precision, origin, search):
        origins.append(origin)
        return {"text": f"{target.title} {len(origins)}"}

    monkeypatch.setattr(gyrostat.exports, "files", files)
    monkeypatch.setattr(exports, "complete", lambda *_, **__: {})
    return origins


def written(folder):
    files = (path for path in Path(folder).rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def test_the_same_bytes_are_written_without_tracing(tmp_path, monkeypatch):
    export(MODEL, tmp_path / "one", **GIVEN)

    def no_target(*_):
        raise AssertionError("expected no tracing")

    monkeypatch.setattr(exported_parts, "flight_target", no_target)
    monkeypatch.setattr(gyrostat.exports, "files", no_target)
    export(MODEL, tmp_path / "other", **GIVEN)
    assert written(tmp_path / "one") == written(tmp_path / "other")
    assert "controller.c" in written(tmp_path / "one")


CHANGES = [
    {"model": WheelModel(ViscousCoulomb, {**VALUES, "coulomb": 8.8e-4 * (1.0 + 2.0**-52)})},
    {
        "model": WheelModel(
            Stribeck, {**VALUES, "coulomb": 8.8e-4, "static": 9e-4, "stribeck_speed": 0.4}
        )
    },
    {"gains": "0.0571,0.00234,0.3127"},
    {"period": "101ms"},
    {"current_limit": "1A"},
    {"precision": "float"},
    {"on_bad": "zero"},
    {"range_": {"attitude": (-1.0, 1.0)}},
    {"rate_limit": {"attitude": 1.0}},
    {"command": "gyrostat export again"},
    {"what": "estimator", "gains": None, "speed_sigma": "5rpm", "scale_drift": "0.01"},
]


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: next(iter(change)))
def test_another_model_or_option_is_made_anew(change, made, tmp_path):
    given = {"model": MODEL, **GIVEN}
    for each in (given, given | change, given, given | change):
        export(out=tmp_path / "out", force=True, **each)
    assert len(made) == 2


def test_other_code_another_setting_or_another_compiler_is_made_anew(made, tmp_path, monkeypatch):
    export(MODEL, tmp_path / "out", **GIVEN)
    with monkeypatch.context() as changed:
        changed.setattr(stored_function, "source_digest", lambda: "other")
        stored_function._machine.cache_clear()
        export(MODEL, tmp_path / "out", **GIVEN)
    stored_function._machine.cache_clear()
    monkeypatch.setattr("gyrostat.codegen.simd.compiler_version", lambda: "other")
    export(MODEL, tmp_path / "out", **GIVEN)
    assert len(made) == 3


def test_a_damaged_entry_is_made_anew(made, tmp_path, cache):
    export(MODEL, tmp_path / "out", **GIVEN)
    (entry,) = (e for e in cache_entries.entries(cache) if e.path.name.startswith("texts-"))
    assert entry.kind == "exported code"
    content = bytearray(entry.path.read_bytes())
    content[-3] ^= 1
    entry.path.write_bytes(content)
    export(MODEL, tmp_path / "out", **GIVEN)
    assert len(made) == 2


class OwnFriction(ViscousCoulomb):
    """Friction model of a user."""


@pytest.mark.parametrize("model", [CurrentMode(AttitudePID(0.06, 0.002, 0.3), 0.02), OwnFriction])
def test_own_parts_are_always_traced(model, made, tmp_path):
    given = GIVEN | {"gains": None}
    if model is OwnFriction:
        model, given = WheelModel(OwnFriction, VALUES), GIVEN
    for _ in range(2):
        export(model, tmp_path / "out", **given)
    assert len(made) == 2
