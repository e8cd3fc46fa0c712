"""Parts of a user's own in the cells of a notebook: what runs is what is in memory.

    python benchmarks/soak_own_code.py                 some minutes of one core
    python benchmarks/soak_own_code.py --only cache    the cases whose names contain this

Every case of `own_code_cases.py` is executed in a kernel of IPython. In a case of the first table,
something changes after the part was defined: what a process that has only the scenario computes
must be what the object in memory computes, or the object is refused in one line. In the second
table nothing of the part changes: its digest stays. In the third, nothing is unusual, and the part
runs. All parts that run then fly together, in a campaign of one worker and of two; one run is
replayed in a process of its own after notebook and modules are gone, and the controller is exported
and checked as C. Exit code 1 if a part computes something else without a word, a digest is wrong,
an exception has another form, or less than 38 of the 40 honest parts run.
"""

import argparse
import json
import math
import os
import pickle
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from own_code_cases import CHANGES, HONEST, LAW, UNCHANGED, UNDO

HERE = Path(__file__).resolve().parent
EXAMPLES = HERE.parent / "examples" / "scenarios"
SECTION = "environment.torque"
MARK = "answer of the case: "
GROUP = 10
"""Number of parts that one scenario takes."""
LEAST = 38
"""Least number of honest parts that run."""
SCENARIO = """
[run]
duration = "5 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[controller]
kind = "three_axis"
[[dispersion]]
key = "wheel.*.coulomb"
distribution = "log_normal"
sigma = "20 %"
"""
HEAD = f"""
import sys
sys.path.insert(0, {str(HERE)!r})
import contextlib, dataclasses, enum, functools, importlib, math, typing
import equinox as eqx
import numpy as np
import gyrostat as gs
from gyrostat.control import PseudoInverse
from gyrostat.core.jax64 import jax, jnp
import soak_own_code as soak
from soak_own_code import write
saved = math.tau, np.pi, np.cos, jnp.cos
"""
TOGETHER = """
class Command(typing.NamedTuple):
    torque: typing.Any
    {fields}

class Together(eqx.Module):
    kp: float = 0.004
    kd: float = 0.03
    spacecraft: typing.Any = None
    def start(self, period): return jnp.zeros(())
    def __call__(self, memory, y):
        values = [jnp.asarray(each(None, None, 0.0)[0]) for each in ({parts},)]
        error = 2.0 * y.attitude[1:] * jnp.sign(y.attitude[0])
        wheels = self.spacecraft.wheels
        torque = PseudoInverse()(
            wheels.axes, wheels.torque_limit, jnp.ones(wheels.count, bool),
            self.kp * error + self.kd * y.rate,
        )
        share = sum(jnp.tanh(value) for value in values)
        return memory + share, Command(torque * (1.0 + 1e-3 * share), *values)
"""


def write(path, text):
    """Write a file of the user, for cells."""
    Path(path).parent.mkdir(exist_ok=True)
    Path(path).write_text(text)


def content(made):
    """Answer about an object: its number in memory, and what another process needs, or the line.

    Executed in the kernel.
    """
    from gyrostat.core.errors import InputError
    from gyrostat.scenario_files.python.objects import user_object

    answer = {"live": float(made()(None, None, 0.0)[0])}
    try:
        kind, sources, values, _ = user_object(SECTION, made())
        answer["text"] = [kind, [(each.path, each.text) for each in sources], values]
    except InputError as error:
        answer["refused"] = str(error)
    except Exception as error:
        answer["failed"] = repr(error)
    print(f"\n{MARK}{json.dumps(answer)}", flush=True)


def take(parts):
    """Answer which of some objects a scenario refuses, with the lines; executed in the kernel.

    Args:
        parts: Name -> class.
    """
    import gyrostat as gs
    from gyrostat.core.errors import InputError

    scenario, names, refused = gs.read_scenario("mission.toml"), list(parts), {}
    while names:
        group = names[:GROUP]
        try:
            scenario.replace(environment={name: parts[name]() for name in group})
        except InputError as error:
            group = [name for name in group if f"{SECTION}.{name} " in str(error)] or group
            refused |= dict.fromkeys(group, str(error))
        names = [name for name in names if name not in group]
    print(f"\n{MARK}{json.dumps(refused)}", flush=True)


def fly(made, parts, count):
    """Fly all parts together, in the kernel; see the first lines of this file."""
    import gyrostat as gs
    from gyrostat.core.errors import InputError

    answer = {"live": [float(each(None, None, 0.0)[0]) for each in parts]}
    try:
        tables = [
            gs.campaign("mission.toml", 4, name, seed=1, workers=k, controller=made(), block=2)
            for k, name in ((1, "one"), (2, "two"))
        ]
        answer["workers"] = bool(tables[0].drop_attrs().identical(tables[1].drop_attrs()))
        run = gs.simulate("mission.toml", seed=1, controller=made())
        answer["simulated"] = recorded(run, count)
        changed = gs.read_scenario("mission.toml").replace(controller=made())
        gs.export(changed, "flight", to="c")
    except InputError as error:
        answer["refused"] = str(error)
    print(f"\n{MARK}{json.dumps(answer)}", flush=True)


def recorded(run, count):
    """Values of the parts that a run recorded, which are constant."""
    found = []
    for k in range(count):
        values = run[f"c{k}"].values
        found.append(float(values[0]) if (values == values[0]).all() else math.nan)
    return found


def loaded(texts):
    """Number of each part in a process that has only the scenario; executed in a fresh one."""
    from gyrostat.core.user_modules import Source
    from gyrostat.scenario.user.parts import user_part

    found = []
    for kind, sources, values in texts:
        part = user_part(SECTION, kind, tuple(Source(*each) for each in sources))
        found.append(float(part.build(values)(None, None, 0.0)[0]))
    return found


def in_fresh_process(function, *arguments):
    """Result of a function of this file in a process of its own, in the current folder."""
    code = (
        "import pickle, sys; import soak_own_code as soak; "
        "name, given = pickle.load(sys.stdin.buffer); found = getattr(soak, name)(*given); "
        "open('result.pickle', 'wb').write(pickle.dumps(found))"
    )
    path = os.pathsep.join([str(HERE), os.environ.get("PYTHONPATH", "")])
    subprocess.run(
        [sys.executable, "-c", code],
        input=pickle.dumps((function.__name__, arguments)),
        env={**os.environ, "PYTHONPATH": path},
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return pickle.loads(Path("result.pickle").read_bytes())


def replayed(count):
    """Values of the parts in a replayed run, which must have the numbers of the table."""
    import gyrostat as gs

    return recorded(gs.replay("two", 2), count)


class Notebook:
    """Kernel of IPython in the current folder."""

    def __init__(self):
        from jupyter_client.manager import start_new_kernel

        self.manager, self.client = start_new_kernel(kernel_name="python3")
        self.execute(HEAD)

    def execute(self, cell):
        """Answer that a cell prints, or None."""
        said = []

        def hear(message):
            content = message["content"]
            said.append(content.get("text", "\n".join(content.get("traceback", ()))))

        self.client.execute_interactive(
            cell, output_hook=hear, timeout=900, stop_on_error=False, allow_stdin=False
        )
        answers = [line for line in "".join(said).splitlines() if line.startswith(MARK)]
        if cell.startswith("soak.") and not answers:
            sys.exit("".join(said))
        return json.loads(answers[-1].removeprefix(MARK)) if answers else None

    def close(self):
        """End the kernel."""
        self.client.stop_channels()
        self.manager.shutdown_kernel(now=True)


def numbered(cell, number):
    """Cell of a case with its number in the names."""
    return re.sub(r"(?<=\w)@", str(number), cell)


def executed(notebook, number, cells, change=()):
    """Answers before and after the change of a case."""
    has_part = any("class P@" in cell for cell in cells)
    cells = [*cells, *([] if has_part else [LAW])]
    for cell in cells:
        notebook.execute(numbered(cell, number))
    before = notebook.execute(f"soak.content(P{number})") if change else None
    for cell in change:
        notebook.execute(numbered(cell, number))
    after = notebook.execute(f"soak.content(P{number})")
    notebook.execute(UNDO)
    return before, after


def judged(answers, numbers):
    """Verdict of each case: equal, refused, or what is wrong.

    Args:
        answers: (table, name) -> answers before and after.
        numbers: The same -> number in another process.
    """
    verdicts = {}
    for key, (before, after) in answers.items():
        if after is None or "failed" in after:
            verdict = f"FAILED {after and after['failed']}"
        elif "refused" in after:
            verdict = "refused" if "\n" not in after["refused"] else "FAILED several lines"
        elif numbers[key] != after["live"]:
            verdict = f"SILENT {after['live']} in memory, {numbers[key]} elsewhere"
        else:
            verdict = "equal"
        if verdict == "equal" and before is not None and "text" in before:
            same = before["text"] == after["text"]
            if key[0] == "unchanged" and not same:
                verdict = "FAILED another digest"
            if before["live"] != after["live"] and same:
                verdict = "FAILED the digest stays"
        verdicts[key] = verdict
    return verdicts


def together(notebook, answers, verdicts):
    """Whether the parts that run give the same numbers everywhere, flown together."""
    order = list(answers)
    flown = [k for k, key in enumerate(order) if verdicts[key] == "equal"]
    parts = [f"P{k}()" for k in flown]
    fields = "\n    ".join(f"c{k}: typing.Any" for k in range(len(flown)))
    notebook.execute(TOGETHER.format(fields=fields, parts=", ".join(parts)))
    answer = notebook.execute(f"soak.fly(Together, [{', '.join(parts)}], {len(flown)})")
    notebook.close()
    if answer is None or "refused" in answer:
        return len(flown), {"flown together": str(answer and answer["refused"])}
    for path in Path().glob("mod*.py"):
        path.unlink()
    for path in Path().glob("pack*"):
        shutil.rmtree(path)
    faults = {} if answer["workers"] else {"two workers": "another table"}
    again = in_fresh_process(replayed, len(flown))
    for name, values in (("simulated", answer["simulated"]), ("replayed", again)):
        wrong = [
            f"{order[k][1]} {one} in memory, {other}"
            for k, one, other in zip(flown, answer["live"], values, strict=True)
            if one != other
        ]
        if wrong:
            faults[name] = "; ".join(wrong)
    made = subprocess.run(["make", "-C", "flight", "test"], capture_output=True, text=True)
    if made.returncode:
        faults["export to C"] = (made.stdout + made.stderr)[-300:]
    return len(flown), faults


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="part of the names of cases")
    parser.add_argument("--verbose", action="store_true", help="print each refusal")
    options = parser.parse_args()
    try:
        import ipykernel  # noqa: F401
    except ImportError:
        sys.exit("found no ipykernel, expected the extra docs")
    begun = time.monotonic()
    cases = {("changed", name): case for name, case in CHANGES.items()}
    cases |= {("unchanged", name): case for name, case in UNCHANGED.items()}
    cases |= {("honest", name): (cells, ()) for name, cells in HONEST.items()}
    cases = {key: case for key, case in cases.items() if options.only in key[1]}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name in ("cubesat.toml", "cubesat_wheel.toml"):
            shutil.copy(EXAMPLES / name, name)
        Path("mission.toml").write_text(SCENARIO)
        notebook, answers = Notebook(), {}
        for number, (key, case) in enumerate(cases.items()):
            answers[key] = executed(notebook, number, *case)
        parts = [
            f"'c{k}': P{k}" for k, (_, a) in enumerate(answers.values()) if "text" in (a or ())
        ]
        taken = notebook.execute(f"soak.take({{{', '.join(parts)}}})")
        for name, line in taken.items():
            answers[list(answers)[int(name[1:])]][1]["refused"] = line
        runs = {k: a["text"] for k, (_, a) in answers.items() if a and "refused" not in a}
        found = in_fresh_process(loaded, list(runs.values()))
        verdicts = judged(answers, dict(zip(runs, found, strict=True)))
        flown, faults = together(notebook, answers, verdicts)
        os.chdir(HERE)
    for key, verdict in verdicts.items():
        if verdict not in ("equal", "refused") or (options.verbose and verdict == "refused"):
            print(*key, verdict, answers[key][1] and answers[key][1].get("refused", ""), sep=": ")
    print("\n| cases | of | equal | refused | wrong |\n|---|---|---|---|---|")
    bad = bool(faults)
    for table in ("changed", "unchanged", "honest"):
        tally = Counter(v for (each, _), v in verdicts.items() if each == table)
        total, (equal, refused) = tally.total(), (tally["equal"], tally["refused"])
        wrong = total - equal - refused
        print(f"| {table} | {total} | {equal} | {refused} | {wrong} |")
        least = {"changed": 0, "unchanged": total, "honest": total - len(HONEST) + LEAST}[table]
        bad |= wrong > 0 or equal < least
    print(f"\n{flown} parts flown together: {faults or 'equal everywhere'}")
    print(f"{time.monotonic() - begun:.0f} s")
    sys.exit(bad)


if __name__ == "__main__":
    main()
