"""Whether flight C is the same from other interpreters and on other processors.

    python benchmarks/same_c.py [--python PATH]... [--quick]

Exports parts of a wheel with gains that are given as numbers, and the controllers of scenarios, of
which some have designed gains, in fresh processes with empty caches: twice by this interpreter,
once by each other one, and once with the instructions and the linear algebra of an old processor
(`XLA_FLAGS=--xla_cpu_max_isa=SSE4_2`, `OPENBLAS_CORETYPE=Prescott`). An interpreter needs the
packages of constraints.txt, with the same version of JAX. Prints for each process how many headers
and sources are the same byte by byte, and the largest difference of the numbers in others, relative
to the number. Exits with 1 if given gains give other C, or if numbers differ by more than 1e-12.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve()
EXAMPLES = HERE.parents[1] / "examples" / "scenarios"
LAW = {"gains": (0.0571, 0.00234, 0.3126)}
FILTER = {"table_inertia": 0.495, "speed_sigma": 0.5, "delay": 1}
PARTS = {
    "compensated-wheel": {**LAW, **FILTER},
    "compensator": {**LAW, **FILTER},
    "controller": LAW,
    "estimator": {"speed_sigma": 0.5, "scale_drift": 1e-3},
    "wheel": {},
}
"""Part -> options of its design; all gains are numbers."""
SCENARIOS = {"own_controller": True, "wheel_failure_found": False, "nadir_and_slew": False}
"""Scenario -> whether all its gains are numbers."""
OLD_PROCESSOR = {"XLA_FLAGS": "--xla_cpu_max_isa=SSE4_2", "OPENBLAS_CORETYPE": "Prescott"}
TOLERANCE = 1e-12
"""Largest relative difference of a designed constant."""
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?f?(?![\w.])")


def export_all(folder, names):
    """Export parts and scenarios to folders of their names."""
    import gyrostat

    for name in names:
        if name in PARTS:
            options = {"what": name, "period": 0.1, **PARTS[name]}
            gyrostat.export(EXAMPLES / "table_wheel.toml", folder / name, to="c", **options)
        else:
            gyrostat.export(EXAMPLES / f"{name}.toml", folder / name, to="c")


def export_elsewhere(python, folder, names, **environment):
    """Export in a fresh process with an empty cache; its versions of Python and JAX.

    Args:
        python: Interpreter.
        folder: Existing folder.
        names: Parts and scenarios.
        environment: Further environment variables.
    """
    source = str(HERE.parents[1] / "src")
    others = {"GYROSTAT_CACHE": str(folder / "cache"), "PYTHONPATH": source, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [python, HERE, "--export", folder, *names],
        env={**os.environ, "JAX_PLATFORMS": "cpu", **others, **environment},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def difference(one, other):
    """Largest relative difference of the numbers in two texts; None if other text differs."""
    if NUMBER.sub("", one) != NUMBER.sub("", other):
        return None
    pairs = zip(NUMBER.findall(one), NUMBER.findall(other), strict=True)
    pairs = [(float(a.rstrip("f")), float(b.rstrip("f"))) for a, b in pairs if a != b]
    return max((abs(a - b) / max(abs(a), abs(b)) for a, b in pairs), default=0.0)


def differences(one, other, names):
    """Name -> largest difference of headers and sources in two folders, see `difference`."""
    results = {}
    for name in names:
        # not the test program, which contains results of Python
        paths = [path for path in (one / name).glob("*.[hc]") if not path.stem.endswith("_test")]
        every = [
            difference(path.read_text("utf-8"), (other / name / path.name).read_text("utf-8"))
            for path in paths
        ]
        results[name] = None if None in every else max(every)
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", action="append", default=[], metavar="PATH")
    parser.add_argument("--quick", action="store_true", help="the parts of a wheel alone")
    parser.add_argument("--export", nargs="+", metavar="NAME", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.export:
        import jax

        folder, *names = options.export
        export_all(Path(folder), names)
        print(f"Python {sys.version.split()[0]}, JAX {jax.__version__}")
        return 0
    names = [*PARTS] if options.quick else [*PARTS, *SCENARIOS]
    processes = [("this interpreter", sys.executable, {"PYTHONHASHSEED": "1"})]
    processes += [("the same again", sys.executable, {"PYTHONHASHSEED": "2"})]
    processes += [("another interpreter", python, {}) for python in options.python]
    processes += [("old processor", sys.executable, OLD_PROCESSOR)]
    wrong = False
    with tempfile.TemporaryDirectory() as scratch:
        first = Path(scratch) / "0"
        for number, (title, python, environment) in enumerate(processes):
            folder = Path(scratch) / str(number)
            folder.mkdir()
            versions = export_elsewhere(python, folder, names, **environment)
            found = differences(first, folder, names)
            given = {name for name in names if SCENARIOS.get(name, True)}
            wrong |= any(d is None or d > TOLERANCE for d in found.values())
            wrong |= any(found[name] != 0.0 for name in given)
            others = {name: d for name, d in found.items() if d != 0.0}
            text = ", ".join(
                f"{name}: {'other code' if d is None else f'{d:.1e}'}" for name, d in others.items()
            )
            print(
                f"{title}, {versions}: {len(names) - len(others)} of {len(names)} the same; {text}"
            )
    return int(wrong)


if __name__ == "__main__":
    sys.exit(main())
