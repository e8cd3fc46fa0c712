"""Read and write model.toml: one wheel with its friction.

[wheel]
inertia = 0.0015          # kg·m²
motor_constant = 0.0228   # N·m/A

[friction]
model = "stribeck"
viscous = 4.83e-06        # N·m·s/rad
...

[sigma]                   # standard deviations of identified parameters, optional
motor_constant = 1.8e-05

[correlation]             # of their errors, optional
names = ["motor_constant", "viscous"]
matrix = [[1.0, 0.2], [0.2, 1.0]]

[validity]                # only if the values are not possible for a wheel
impossible = "viscous is negative (-3e-06): no wheel has this"

[origin]                  # free text on the source of the values, optional
method = "batch"

The friction law can be a class of a Python file beside this one, `model = "mine.py:MyLaw"`:

[sources]                 # SHA-256 digests of the file and its local imports, optional
"mine.py" = "0f3a..."

Data files that it reads are `data = ["table.csv"]` in [friction], with digests in [sources].
"""

import hashlib
import json
import os
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gyrostat.core.errors import InputError, placed
from gyrostat.core.files import write_whole
from gyrostat.core.pictured import PicturedText
from gyrostat.core.toml_file import number, quoted, read_toml, refuse_unknown
from gyrostat.core.types import Matrix
from gyrostat.core.units import si_unit
from gyrostat.core.user_modules import Source, is_user_kind
from gyrostat.wheel.friction import Friction
from gyrostat.wheel.friction.base import check_concrete
from gyrostat.wheel.friction_laws import Law, digest, law_texts, read_law, static, write_texts
from gyrostat.wheel.wheel import Wheel

_SECTIONS = ("wheel", "friction", "sources", "sigma", "correlation", "validity", "origin")
KNOWN_BEFOREHAND = "known_beforehand"
"""Key of [origin]: parameters whose values do not come from the records, with commas between."""
_WHEEL = {"inertia": "inertia", "motor_constant": "motor_constant"}


@dataclass(frozen=True)
class WheelModel(PicturedText):
    """Content of a model file.

    Attributes:
        friction: Class of the friction model.
        values: Parameter name -> value in SI units; the inertia may be missing.
        sigma: Parameter name -> standard deviation in SI units, of identified parameters.
        origin: Source of the values, as text.
        correlation: Names of identified parameters and the correlation matrix of their errors, (n,
            n); None if unknown.
        impossible: Reason why these values are not valid; empty if they are.
    """

    friction: Law
    values: Mapping[str, float]
    sigma: Mapping[str, float] = field(default_factory=dict)
    origin: Mapping[str, str] = field(default_factory=dict)
    impossible: str = ""
    correlation: tuple[tuple[str, ...], Matrix] | None = None

    def dimensions(self) -> dict[str, str]:
        """Physical dimensions of all parameters, as keys of `gyrostat.core.units.SI_UNIT`."""
        return {**_WHEEL, **self.friction.dimensions()}

    def covariance(self) -> tuple[tuple[str, ...], Matrix]:
        """Names of the identified parameters and the covariance of their errors, (n, n), SI.

        Without a correlation, the errors are taken as independent.
        """
        names = tuple(self.sigma)
        sigma = np.array([self.sigma[n] for n in names])
        correlation = np.eye(len(names))
        if self.correlation is not None:
            matrix_names, matrix = self.correlation
            rows = [k for k, n in enumerate(names) if n in matrix_names]
            columns = [matrix_names.index(names[k]) for k in rows]
            correlation[np.ix_(rows, rows)] = matrix[np.ix_(columns, columns)]
        return names, correlation * np.outer(sigma, sigma)

    def static_friction(self) -> type[Friction]:
        """Class of the friction model; raises `InputError` if it is that of bristles."""
        return static(self.friction, "model")

    def wheel(self) -> Wheel:
        """Wheel with the parameters of the file.

        Raises:
            InputError: A parameter of the wheel is missing, such as the inertia after an
                identification by a method that does not need it; or the friction is none. It is
                not validated if the values are marked as impossible.
        """
        missing = [name for name in self.dimensions() if name not in self.values]
        if missing:
            raise InputError(f"wheel model: found no {missing[0]}, expected its value")
        self.check_friction()
        return Wheel(
            inertia=self.values["inertia"],
            motor_constant=self.values["motor_constant"],
            friction=self.friction.of(**self._friction_values()),
        )

    def digest(self) -> str | None:
        """SHA-256 digest of friction law and values; it identifies the wheel.

        Standard deviations, the origin and the comments of a file have no effect. None if the law
        is a class that was not loaded from a file by gyrostat.
        """
        law = law_texts(self.friction)
        if law is None and not self.friction.__module__.startswith("gyrostat."):
            return None
        name, sources = law or (self.friction.name, ())
        values = {key: float(value).hex() for key, value in self.values.items()}
        content = [name, {source.path: digest(source) for source in sources}, values]
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    def check_friction(self) -> None:
        """Validate the friction, unless the values are marked as impossible.

        Raises:
            InputError: A parameter has the wrong sign, or the friction drives the wheel.
        """
        if not self.impossible:
            values = self._friction_values()
            # an estimate may be negative by chance, which its identification does not refuse
            near = {n: 0.0 for n, v in values.items() if -2.0 * self.sigma.get(n, 0.0) <= v < 0.0}
            check_concrete(self.friction.of(**{**values, **near}))

    def _friction_values(self) -> dict[str, float]:
        return {name: self.values[name] for name in self.friction.dimensions()}


def write_model(
    path: str | os.PathLike[str],
    model: WheelModel,
    law: tuple[str, tuple[Source, ...]] | None = None,
) -> None:
    """Write a model file; numbers can be read back without loss.

    The texts of a friction law that is not of this package are written beside it.

    Args:
        path: Path of the file.
        model: Its content.
        law: Kind of the friction law, "FILE.py:CLASS", and its texts; None if the law is of this
            package, or was loaded from a file by gyrostat.

    Raises:
        InputError: The file cannot be written, or there is no text of the friction law.
    """
    dimensions, path = model.dimensions(), Path(path)
    law = law or law_texts(model.friction)
    if law is None and not model.friction.__module__.startswith("gyrostat."):
        raise InputError(
            f"{path}: found the law {model.friction.__name__} without its text, expected one of a "
            "file: load it by FILE.py:CLASS, or write the files of an identification (out=DIR)"
        )
    name, sources = law or (model.friction.name, ())
    write_texts(path.parent, sources)

    def lines(names: Collection[str], values: Mapping[str, float]) -> list[str]:
        return [
            f"{name} = {float(values[name])!r}  # {si_unit(dimensions[name])}"
            for name in names
            if name in values
        ]

    text = ["# A wheel identified by gyrostat, SI units", "", "[wheel]"]
    text += lines(_WHEEL, model.values)
    text += ["", "[friction]", f"model = {quoted(name)}"]
    data = [source.path for source in sources if not source.is_module]
    text += [f"data = [{', '.join(map(quoted, data))}]"] if data else []
    text += lines(model.friction.dimensions(), model.values)
    if sources:
        text += ["", "[sources]  # SHA-256 digests of the friction law"]
        text += [f"{quoted(source.path)} = {quoted(digest(source))}" for source in sources]
    if model.sigma:
        text += ["", "[sigma]  # standard deviations", *lines(dimensions, model.sigma)]
    if model.correlation is not None:
        matrix_names, matrix = model.correlation
        text += ["", "[correlation]  # of their errors", f"names = {json.dumps(matrix_names)}"]
        text += ["matrix = [", *(f"  {row}," for row in matrix.tolist()), "]"]
    if model.impossible:
        text += ["", "[validity]", f"impossible = {quoted(model.impossible)}"]
    if model.origin:
        text += ["", "[origin]"]
        text += [f"{name} = {quoted(value)}" for name, value in model.origin.items()]
    write_whole(path, "\n".join(text) + "\n")


def read_model(path: str | os.PathLike[str], *, force: bool = False) -> WheelModel:
    """Read a model file.

    Args:
        path: Path of the file.
        force: Whether to accept a wheel that its identification marked as impossible.

    Raises:
        InputError: The file cannot be read or is not TOML; a key is unknown or missing; a value is
            not possible for a wheel; or the wheel is marked as impossible.
    """
    path = Path(path)
    table = read_toml(path, "a model file")
    refuse_unknown(path, "", table, _SECTIONS)
    for section in table:
        if not isinstance(table[section], dict):
            raise InputError(f"{path}: key {section}: found a value, expected a table")
    friction = dict(table.get("friction", {}))
    law_table = {"model": friction.pop("model", None)}
    if is_user_kind(str(law_table["model"])) and "data" in friction:
        law_table["data"] = friction.pop("data")
    model = read_law(path, "friction.model", law_table, table.get("sources"))
    dimensions = {**_WHEEL, **model.dimensions()}
    wheel, sigma = table.get("wheel", {}), table.get("sigma", {})
    refuse_unknown(path, "validity.", table.get("validity", {}), ("impossible",))
    impossible = str(table.get("validity", {}).get("impossible", ""))
    if impossible and not force:
        raise InputError(
            f"{path}: key validity.impossible: found a wheel that is not valid ({impossible}), "
            "expected a valid one; --force accepts it if it can be simulated"
        )
    refuse_unknown(path, "wheel.", wheel, _WHEEL)
    refuse_unknown(path, "friction.", friction, model.dimensions())
    refuse_unknown(path, "sigma.", sigma, dimensions)
    required = {
        "wheel.motor_constant": wheel,
        **{f"friction.{n}": friction for n in model.dimensions()},
    }
    for key, section in required.items():
        if key.split(".")[1] not in section:
            raise InputError(f"{path}: key {key}: found none, expected its value in SI units")
    # values marked as impossible keep their signs, so that a prediction can test the mark
    scales = {n for n, d in model.dimensions().items() if d in ("speed", "stiffness")}
    positive = set() if impossible else {*_WHEEL, *scales}
    values = {
        n: number(path, f"{section}.{n}", v, positive=n in positive)
        for section, entries in (("wheel", wheel), ("friction", friction))
        for n, v in entries.items()
    }
    if values["motor_constant"] == 0.0:
        raise InputError(f"{path}: key wheel.motor_constant: found 0, expected another value")
    wheel_model = WheelModel(
        friction=model,
        values=values,
        sigma={n: number(path, f"sigma.{n}", v, positive=False) for n, v in sigma.items()},
        origin={k: str(v) for k, v in table.get("origin", {}).items()},
        impossible=impossible,
        correlation=_correlation(path, table.get("correlation"), sigma),
    )
    with placed(f"{path}: key friction"):
        wheel_model.check_friction()
    return wheel_model


def _correlation(
    path: Path, table: Mapping[str, object] | None, sigma: Collection[str]
) -> tuple[tuple[str, ...], Matrix] | None:
    """Names and matrix of the table [correlation]; None without it."""
    if table is None:
        return None
    refuse_unknown(path, "correlation.", table, ("names", "matrix"))
    names, rows = table.get("names"), table.get("matrix")
    if not isinstance(names, list) or not set(map(str, names)) <= set(sigma):
        raise InputError(f"{path}: key correlation.names: expected names listed in [sigma]")
    try:
        matrix = np.array(rows, dtype=float)
    except (TypeError, ValueError):
        matrix = np.zeros(0)
    count = len(names)
    fits = matrix.shape == (count, count) and bool(np.all(np.abs(matrix) <= 1.0 + 1e-9))
    if not (fits and np.allclose(matrix, matrix.T) and np.allclose(np.diag(matrix), 1.0)):
        raise InputError(
            f"{path}: key correlation.matrix: expected {count} rows of {count} numbers from -1 to "
            "1, symmetric, with ones on the diagonal"
        )
    return tuple(map(str, names)), matrix
