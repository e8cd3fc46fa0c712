"""Wheels on a structure as text, which a scenario stores in place of the files."""

import json
from dataclasses import asdict
from typing import Any

import numpy as np

from gyrostat.microvibration.disturbance_file import Structure
from gyrostat.microvibration.model import Harmonic, Mode, Noise, WheelDisturbance
from gyrostat.microvibration.sight import MountedWheel
from gyrostat.microvibration.transfer import FrequencyResponse, ModalModel


def structure_text(structure: Structure) -> str:
    """Structure as JSON text; `structure_from` restores it exactly."""
    disturbances = list(
        {id(each.disturbance): each.disturbance for each in structure.wheels}.values()
    )
    wheels = [
        {
            "name": each.name,
            "disturbance": disturbances.index(each.disturbance),
            "axis": np.asarray(each.axis).tolist(),
            "position": np.asarray(each.position).tolist(),
        }
        for each in structure.wheels
    ]
    numbers = ("exposure", "limit", "speeds", "detail")
    content = {
        **{name: getattr(structure, name) for name in numbers},
        "wheels": wheels,
        "disturbances": [asdict(each) for each in disturbances],
        "transfer": {name: _listed(value) for name, value in vars(structure.transfer).items()},
    }
    return json.dumps(content, ensure_ascii=False, sort_keys=True)


def structure_from(text: str) -> Structure:
    """Structure from the result of `structure_text`."""
    content = json.loads(text)
    disturbances = [
        WheelDisturbance(
            each["name"],
            tuple(Harmonic(**harmonic) for harmonic in each["harmonics"]),
            {kind: Mode(**mode) for kind, mode in each["modes"].items()},
            {kind: Noise(**noise) for kind, noise in each["noise"].items()},
        )
        for each in content["disturbances"]
    ]
    wheels = [
        MountedWheel(
            each["name"],
            disturbances[each["disturbance"]],
            np.array(each["axis"]),
            np.array(each["position"]),
        )
        for each in content["wheels"]
    ]
    transfer = {name: np.array(value) for name, value in content["transfer"].items()}
    if "values" in transfer:
        response = np.ascontiguousarray(transfer["values"]).view(complex)[..., 0]
        kind: Any = FrequencyResponse(transfer["frequency"], response)
    else:
        kind = ModalModel(**transfer)
    low, high = content["speeds"]
    return Structure(
        wheels, kind, content["exposure"], content["limit"], (low, high), content["detail"]
    )


def _listed(value: Any) -> list[Any]:
    """Numbers of an array; of a complex one with an axis of real and imaginary parts."""
    array: Any = np.asarray(value)
    return (np.stack([array.real, array.imag], -1) if np.iscomplexobj(array) else array).tolist()
