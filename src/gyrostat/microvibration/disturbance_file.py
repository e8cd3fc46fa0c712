"""File of the loads of a wheel, `disturbance.toml`, and of wheels on a structure."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.text import plain
from gyrostat.core.toml_file import (
    described,
    direction,
    name_text,
    number,
    quantity,
    quoted,
    read_toml,
    refuse_unknown,
    three,
)
from gyrostat.core.types import Vector
from gyrostat.core.unit_table import RPM
from gyrostat.microvibration.model import KINDS, TWO_PI, Harmonic, Mode, Noise, WheelDisturbance
from gyrostat.microvibration.sight import MountedWheel
from gyrostat.microvibration.transfer_file import Transfer, read_transfer

ACROSS = ("force", "torque")
"""Kinds of load with a backward part."""
KEYS = (
    *("disturbance", "transfer", "exposure", "limit", "speeds", "detail", "wheel"),
    *("damping", "nodes", "sight_node"),
)
_FILE = "wheels on a structure"


def disturbance_text(disturbance: WheelDisturbance) -> str:
    """Text of disturbance.toml."""
    lines = ["# Loads of a wheel: amplitudes over the squared speed (rad/s), kg·m and kg·m²."]
    lines.append(f"name = {quoted(disturbance.name)}")
    for each in disturbance.harmonics:
        lines += ["", "[[harmonic]]", f"number = {each.number:.9g}"]
        for word in ("forward", "backward"):
            values = getattr(each, word)
            if values:
                pairs = ", ".join(f"{kind} = {value:.6g}" for kind, value in values.items())
                lines.append(f"{word} = {{ {pairs} }}")
    for kind, mode in disturbance.modes.items():
        lines += ["", f"[mode.{kind}]", f'frequency = "{mode.frequency / TWO_PI:.9g} Hz"']
        lines.append(f"damping = {mode.damping:.6g}")
        if mode.inertia_ratio:
            lines.append(f"inertia_ratio = {mode.inertia_ratio:.6g}")
    for kind, noise in disturbance.noise.items():
        lines += ["", f"[noise.{kind}]  # one-sided density at the reference speed, 1/Hz"]
        lines += [f"density = {noise.density:.6g}", f"exponent = {noise.exponent:.6g}"]
        lines.append(f'reference = "{noise.reference / RPM:.9g} rpm"')
    return "\n".join(lines) + "\n"


def read_disturbance(path: Path) -> WheelDisturbance:
    """Read disturbance.toml.

    Raises:
        InputError: The file cannot be read or used.
    """
    content = read_toml(path, "loads of a wheel")
    refuse_unknown(path, "", content, ("name", "harmonic", "mode", "noise"))
    name = name_text(path, "name", content.get("name", path.stem))
    harmonics = [
        _harmonic(path, f"harmonic[{k}]", each)
        for k, each in enumerate(_tables(path, "harmonic", content.get("harmonic", [])))
    ]
    modes, noise = {}, {}
    for kind, each in _by_kind(path, "mode", content.get("mode", {}), tuple(KINDS)).items():
        place = f"mode.{kind}"
        names = ("frequency", "damping", "inertia_ratio")
        refuse_unknown(path, f"{place}.", each, names)
        frequency = quantity(
            path, f"{place}.frequency", each.get("frequency"), "frequency", positive=True
        )
        damping = number(path, f"{place}.damping", each.get("damping"), positive=True)
        ratio = number(path, f"{place}.inertia_ratio", each.get("inertia_ratio", 0), positive=False)
        if ratio != 0.0 and (kind != "torque" or ratio < 0.0):
            raise InputError(f"{path}: key {place}.inertia_ratio: found {ratio:g}, expected none")
        modes[kind] = Mode(TWO_PI * frequency, damping, ratio)
    for kind, each in _by_kind(path, "noise", content.get("noise", {}), tuple(KINDS)).items():
        place = f"noise.{kind}"
        refuse_unknown(path, f"{place}.", each, ("density", "exponent", "reference"))
        density = number(path, f"{place}.density", each.get("density"), positive=True)
        exponent = number(path, f"{place}.exponent", each.get("exponent"), positive=False)
        reference = quantity(
            path, f"{place}.reference", each.get("reference"), "speed", positive=True
        )
        noise[kind] = Noise(density, exponent, reference)
    return WheelDisturbance(name, tuple(harmonics), modes, noise)


def _tables(path: Path, key: str, value: Any) -> list[dict[str, Any]]:
    if not isinstance(value, list) or not all(isinstance(each, dict) for each in value):
        raise InputError(f"{path}: key {key}: found {described(value)}, expected tables [[{key}]]")
    return value


def _by_kind(path: Path, key: str, value: Any, kinds: tuple[str, ...]) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise InputError(f"{path}: key {key}: found {described(value)}, expected a table")
    refuse_unknown(path, f"{key}.", value, kinds)
    return value


def _harmonic(path: Path, place: str, table: dict[str, Any]) -> Harmonic:
    refuse_unknown(path, f"{place}.", table, ("number", "forward", "backward"))
    multiple = number(path, f"{place}.number", table.get("number"), positive=True)
    parts = []
    for word, kinds in (("forward", tuple(KINDS)), ("backward", ACROSS)):
        values = _by_kind(path, f"{place}.{word}", table.get(word, {}), kinds)
        parts.append(
            {
                kind: number(path, f"{place}.{word}.{kind}", value, positive=True)
                for kind, value in values.items()
            }
        )
    return Harmonic(multiple, *parts)


@dataclass(frozen=True, eq=False)
class Structure:
    """Wheels on a structure, their transfer to the line of sight, and the exposure.

    Attributes:
        wheels: Wheels.
        transfer: Transfer to the line of sight.
        exposure: Duration of an exposure, s.
        limit: Largest rms of smear and jitter, rad; None for none.
        speeds: Lowest and highest wheel speed, rad/s.
        detail: Spatial frequency of the MTF, cycles/rad; None for no MTF.
    """

    wheels: list[MountedWheel]
    transfer: Transfer
    exposure: float
    limit: float | None
    speeds: tuple[float, float]
    detail: float | None


def read_structure(path: Path) -> Structure:
    """Read wheels on a structure.

    Raises:
        InputError: The file, or one that it names, cannot be read or used.
    """
    content = read_toml(path, _FILE)
    refuse_unknown(path, "", content, KEYS)
    damping = content.get("damping")
    if damping is not None:
        damping = number(path, "damping", damping, positive=True)
    nodes = content.get("nodes", [])
    whole = [*(nodes if isinstance(nodes, list) else [None]), content.get("sight_node", 0)]
    if any(not isinstance(node, int) or isinstance(node, bool) for node in whole):
        raise InputError(f"{path}: key nodes: found {nodes!r}, expected whole numbers")
    transfer = read_transfer(
        _beside(path, "transfer", content.get("transfer")),
        damping=damping,
        nodes=tuple(nodes),
        sight_node=content.get("sight_node"),
    )
    exposure = quantity(path, "exposure", content.get("exposure"), "time", positive=True)
    limit, detail = content.get("limit"), content.get("detail")
    if limit is not None:
        limit = quantity(path, "limit", limit, "angle", positive=True)
    if detail is not None:
        detail = number(path, "detail", detail, positive=True)
    ends = content.get("speeds")
    if not isinstance(ends, list) or len(ends) != 2:
        raise InputError(f"{path}: key speeds: found {described(ends)}, expected two speeds")
    low, high = (
        quantity(path, f"speeds[{k}]", each, "speed", positive=True) for k, each in enumerate(ends)
    )
    if low >= high:
        raise InputError(
            f"{path}: key speeds: found {plain(low / RPM)} to {plain(high / RPM)} rpm, expected "
            "the lower one first"
        )
    wheels = _wheels(path, content)
    if transfer.wheels not in (1, len(wheels)):
        raise InputError(
            f"{path}: key wheel: found {len(wheels)} wheels, expected the {transfer.wheels} of the "
            "transfer"
        )
    return Structure(wheels, transfer, exposure, limit, (low, high), detail)


def _wheels(path: Path, content: dict[str, Any]) -> list[MountedWheel]:
    tables = _tables(path, "wheel", content.get("wheel", []))
    if not tables:
        raise InputError(f"{path}: key wheel: found none, expected [[wheel]] with axis")
    read: dict[Path, WheelDisturbance] = {}
    wheels = []
    for k, table in enumerate(tables):
        place = f"wheel[{k}]"
        refuse_unknown(path, f"{place}.", table, ("name", "axis", "position", "disturbance"))
        file = _beside(path, "disturbance", table.get("disturbance", content.get("disturbance")))
        if file not in read:
            read[file] = read_disturbance(file)
        axis: Vector = direction(path, f"{place}.axis", table.get("axis"))
        position = three(path, f"{place}.position", table.get("position", [0, 0, 0]), "length")
        name = name_text(path, f"{place}.name", table.get("name", f"wheel {k + 1}"))
        wheels.append(MountedWheel(name, read[file], axis / np.linalg.norm(axis), position))
    return wheels


def _beside(path: Path, key: str, value: Any) -> Path:
    """File that a key names, relative to the file of the key."""
    if not isinstance(value, str):
        raise InputError(f"{path}: key {key}: found {described(value)}, expected a file name")
    return path.parent / value
