"""Hostile input for every verb, option and file: extreme numbers, texts, devices, broken files.

Each command must end in time with exit code 0, 1 or 2 and without a traceback. With 2 the last line
on stderr is the one that begins with "error:", no line is longer than 1 kB, and no file is left.
Files that are written with 0 or 1 are whole: JSON without NaN.

    python benchmarks/soak_input.py                  150 s of processor time, seed 0
    python benchmarks/soak_input.py --seed 7 --count 50
    python benchmarks/soak_input.py --case 123       one case, its output shown
"""

import argparse
import json
import multiprocessing
import os
import random
import shutil
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

EXAMPLES = Path(__file__).parents[1] / "examples"
LIMIT, WAIT = 60.0, 600.0
"""Seconds of processor time for a command, where the longest with sound input needs 40 to compile;
and seconds in which one that waits for something must end, however busy the machine is."""

NUMBERS = [
    *("0", "-0.0", "-1", "1", "nan", "inf", "-inf", "1e308", "-1e308", "1e-308", "1e-320", "1e999"),
    *("1e-300", "1e300", "1e29", "-1e29", "1e-29", "1e12", "1e-12", "1e6", "9223372036854775808"),
    *("-9223372036854775809", "18446744073709551616", "9" * 400, "0." + "0" * 400 + "1"),
]
TEXTS = [
    *("", " ", "-", "--", ",", ",,,,", "=", ":", "a=", "=1", "a=b=c", "1 kg", "1 rpm"),
    *("5 %", "0x10"),
    *("1_000", "٣", "½", "é☃𝄞", "a\nb", "\x1b[31mred", "\x00", "\ud800", "$\\frac$", "[red]x[/]"),
    *("{x}", "%s%n", "../..", "~", "/", "/dev/zero", "x" * 100_000, "1," * 50_000, "None", "true"),
]
FILES = [
    *("ABSENT", "FOLDER", "PIPE", "/dev/zero", "/dev/null", "EMPTY", "BINARY", "LONG", "DEEP"),
    *("HUGE", "LATIN", "NUL", "", "x" * 5000),
]

MODEL = """
[wheel]
inertia = 1.5e-3
motor_constant = 0.0228
[friction]
model = "stribeck"
viscous = 4.83e-6
coulomb = 0.8795e-3
static = 0.9055e-3
stribeck_speed = 0.418879
"""
CRAFT = """
[body]
name = "cube"
inertia = [12.0, 11.0, 10.0]
[[wheel]]
name = "x"
axis = [1.0, 0.0, 0.0]
inertia = 0.015
torque_limit = 0.1
momentum_limit = 3.0
[[wheel]]
name = "y"
axis = [0.0, 1.0, 0.0]
inertia = 0.015
torque_limit = 0.1
momentum_limit = 3.0
[[wheel]]
name = "z"
axis = [0.0, 0.0, 1.0]
inertia = 0.015
torque_limit = 0.1
momentum_limit = 3.0
"""
SHEET = """
name = "one"
[coulomb]
maximum = "1 mN·m"
source = "a"
[[loss_torque]]
speed = "200 rpm"
maximum = "1 mN·m"
source = "b"
"""
STORED = """
{"model": "viscous-coulomb", "converged": true, "parameters": {
  "coulomb": {"value": 1e-3, "sigma": 1e-5, "unit": "N·m"},
  "viscous": {"value": 5e-6, "sigma": 2e-7, "unit": "N·m·s/rad"}},
 "correlation": {"names": ["coulomb", "viscous"], "matrix": [[1.0, 0.1], [0.1, 1.0]]},
 "tolerances": {"inertia": {"sigma": 0.01, "errors": {"coulomb": 1e-6, "viscous": 5e-9}}},
 "metadata": [{"serial": "RW-7", "date": "2026-01-01"}]}
"""
SCENARIO = """
name = "small"
[run]
duration = "2 s"
control_period = "0.25 s"
[spacecraft]
file = "craft.toml"
[start]
wheel_speed = ["30 rpm", "-200 rpm", "200 rpm"]
[controller]
kind = "three_axis"
turn_gain = 0.4
[sensors]
attitude_sigma = "0.003 deg"
[metrics]
after = "0 s"
[[dispersion]]
key = "wheel.*.inertia"
distribution = "normal"
sigma = "3 %"
"""

# verb -> weight, what stands without an option, options of the base command, other options
RECORD, TOML, FIT = "record.csv", "model.toml", "fit.json"
VERBS = {
    "identify": (
        20,
        (RECORD,),
        {"--out": "out", "--inertia": "1.5e-3", "--speed-sigma": "0.5"},
        {
            "--model": "stribeck",
            "--method": "steady",
            "--hold": "coulomb=1e-3",
            "--free": "stribeck_speed",
            "--prior": "static=1e-3:1e-4",
            "--start": "coulomb=1e-3",
            "--loss": "huber",
            "--current-hold": "linear",
            "--held-out": RECORD,
            "--columns": "time=time_s",
            "--units": "speed=rpm",
        },
    ),
    "validate": (
        10,
        (TOML, RECORD),
        {"--out": "out"},
        {"--hold": "current_bias=0.001", "--current-hold": "linear", "--units": "speed=rpm"}
        | {"--sheet": "sheet.toml"},
    ),
    "compare": (
        10,
        (FIT, FIT),
        {"--out": "out"},
        {"--wheels": "different", "--dates": "2026-01-01,2026-04-01"},
    ),
    "bench": (
        20,
        (TOML,),
        {"--out": "out/r.csv", "--duration": "20"},
        {
            "--profile": "sines",
            "--rate": "10",
            "--low": "0.05",
            "--high": "0.2",
            "--period": "5",
            "--initial-speed": "3",
            "--speed-sigma": "0.5",
            "--speed-quantum": "0.1",
            "--jitter": "0.1",
            "--dropouts": "0.1",
            "--seed": "3",
        },
    ),
    "holdable": (
        12,
        ("craft.toml",),
        {"--momentum": "0,0,1.5", "--out": "out", "--target": "1,0,0,0"},
        {"--failed": "x=0.3", "--euler": "0,0,0", "--boresight": "x", "--towards": "0,0,1"},
    ),
    "recover": (
        2,
        ("craft.toml",),
        {
            "--failed": "x=seized",
            "--wheels": "0,0.1,0.2",
            "--out": "out",
            "--attitude": "1,0,0,0",
            "--target": "1,0,0,0",
            "--duration": "20",
        },
        {"--rate": "0,0,0", "--period": "0.5", "--euler": "0,0,0", "--attitude-euler": "0,0,0"},
    ),
    "export": (
        12,
        (TOML,),
        {
            "--out": "out",
            "--to": "c",
            "--what": "compensator",
            "--period": "0.1",
            "--gains": "0.05,0.002,0.3",
            "--table-inertia": "0.5",
            "--speed-sigma": "0.1",
        },
        {"--current-limit": "0.2", "--delay": "1", "--scale-drift": "1e-3", "--precision": "float"},
    ),
    "simulate": (
        3,
        ("scenario.toml",),
        {"--out": "out/run.nc", "--engine": "jax"},
        {"--seed": "1", "--device": "gpu"},
    ),
    "campaign": (
        4,
        ("scenario.toml",),
        # refused, unless the mutation says another number: the base command starts no worker
        {"--runs": "0", "--out": "out", "--engine": "jax"},
        {"--seed": "1", "--workers": "1", "--block": "1", "--keep": "0", "--worst": "1"}
        | {"--worst-by": "error_mean", "--scheduler": "tcp://127.0.0.1:1", "--device": "tpu"},
    ),
    "replay": (3, (".", "0"), {}, {}),
    "report": (3, (".",), {}, {}),
    "reproduce": (2, ("no-such-paper",), {"--out": "out"}, {}),
}
SLOW = ("simulate", "recover", "campaign", "identify")
"""Verbs that trace programs anew for other input; the tests leave them out."""


def cases(seed, verbs=tuple(VERBS)):
    """Endless commands as (number, verb, words, files); files: name -> hostile content or None."""
    number = 0
    while True:
        source = random.Random(f"{seed}/{number}")
        verb = source.choices(verbs, [VERBS[v][0] for v in verbs])[0]
        _, given, base, more = VERBS[verb]
        given, options = list(given), dict(base)
        for name in source.sample(sorted(more), min(len(more), source.choice((0, 0, 1, 2)))):
            options[name] = more[name]
        texts = {}
        for _ in range(source.choice((1, 1, 1, 2))):
            _mutate(source, given, options, more, texts)
        words = [*given, *(f"{name}={value}" for name, value in options.items())]
        yield number, verb, words, texts
        number += 1


def _mutate(source, given, options, more, texts):
    """Make one thing hostile: an option, a file's place, or a file's content."""
    kind = source.random()
    if kind < 0.55 and (options or more):
        name = source.choice(sorted({*options, *more}))
        value = options.get(name) or more[name]
        options[name] = _spoiled(source, value)
    elif kind < 0.7:
        given[source.randrange(len(given))] = source.choice(FILES)
    else:
        content = {RECORD: record(), TOML: MODEL, "craft.toml": CRAFT, "scenario.toml": SCENARIO}
        content |= {FIT: STORED}
        named = [name for name in content if name in given]
        if "scenario.toml" in named:
            named.append("craft.toml")
        if named:
            name = source.choice(named)
            texts[name] = _spoiled_file(source, texts.get(name) or content[name], name)


def _spoiled(source, value):
    """A value in place of another, or of a part of it."""
    if source.random() < 0.5:
        parts = []
        for sign in "=:,":
            parts = value.split(sign)
            if len(parts) > 1:
                k = source.randrange(len(parts))
                parts[k] = source.choice(NUMBERS)
                return sign.join(parts)
    return source.choice(NUMBERS + TEXTS)


def _spoiled_file(source, text, name):
    """A file with one value, line or byte changed."""
    lines = text.splitlines()
    k = source.randrange(len(lines))
    kind = source.random()
    if kind < 0.7:
        if name == RECORD:
            cells = lines[k].split(",")
            cells[source.randrange(len(cells))] = source.choice(NUMBERS + TEXTS[:30])
            lines[k] = ",".join(cells)
        else:
            lines = [line for line in lines if line]
            k = source.choice([k for k, line in enumerate(lines) if "=" in line])
            value = source.choice([*NUMBERS, "[]", "{}", "[[1.0]]", "true", "1979-05-27", "''"])
            if source.random() < 0.4:
                value = json.dumps(source.choice(TEXTS + [f"{n} rpm" for n in NUMBERS]))
            lines[k] = f"{lines[k].split('=')[0]}= {value}"
    elif kind < 0.8:
        del lines[k]
    elif kind < 0.9:
        inserted = ["[x]", "[[wheel]]", "x = 1", "", "\x01", '"' * 3, "[" * 9000]
        lines.insert(k, source.choice(inserted))
    else:
        lines = lines[:k]
    return "\n".join(lines) + "\n"


def record():
    """A small record: 12 s of a wheel that is driven one way and back."""
    rows, speed = ["time_s,current_A,speed_rpm"], 0.0
    for k in range(120):
        current = 0.12 if k % 60 < 30 else -0.12
        speed += 1.2 * (1.0 if current > 0.0 else -1.0)
        rows.append(f"{0.1 * k:.1f},{current},{speed * 9.55:.3f}")
    return "\n".join(rows)


def place_files(folder, texts):
    """Write the files that commands name, some of them hostile, into an empty folder."""
    own = {RECORD: record(), TOML: MODEL, "craft.toml": CRAFT, "scenario.toml": SCENARIO}
    own |= {FIT: STORED, "sheet.toml": SHEET, **texts}
    for name, text in own.items():
        (folder / name).write_text(text, encoding="utf-8", errors="replace")
    (folder / "FOLDER").mkdir()
    (folder / "EMPTY").touch()
    os.mkfifo(folder / "PIPE")
    (folder / "BINARY").write_bytes(random.Random(0).randbytes(3000))
    (folder / "LONG").write_text("x = " + "1" * 5000)
    (folder / "DEEP").write_text("x = " + "[" * 20_000)
    (folder / "LATIN").write_bytes(b'name = "\xe9"\n')
    (folder / "NUL").write_text('x = "\0"\n')
    with (folder / "HUGE").open("wb") as stream:
        stream.truncate(50 * 2**30)


def faults(words, code, stdout, stderr, folder):
    """What a command did that it must not; folder: where it ran."""
    found = []
    if code not in (0, 1, 2):
        found.append(f"exit code {code}")
    if "Traceback" in stderr or "Warning" in stderr:
        found.append("traceback or warning")
    lines = stderr.splitlines()
    if any(len(line.encode(errors="replace")) > 1024 for line in lines):
        found.append("a line of more than 1 kB")
    errors = [line for line in lines if line.startswith("error: ")]
    if len(errors) != (code == 2) or (code == 2 and not lines[-1].startswith("error: ")):
        found.append(f"{len(errors)} lines of error with code {code}")
    hidden = [path for path in folder.rglob("*") if path.name.startswith(".")]
    made = [path for path in hidden if code == 2 or path.name != ".gyrostat.json"]
    if (folder / "out").is_dir() and code == 2:
        made += [path for path in (folder / "out").rglob("*") if path.is_file()]
    if made:
        found.append(f"left {', '.join(path.name for path in made)}")
    for path in folder.rglob("*.json") if code != 2 else ():
        try:
            json.loads(path.read_text(), parse_constant=_refuse)
        except ValueError as error:
            found.append(f"{path.name}: {error}")
    return found


def _refuse(constant):
    raise ValueError(f"{constant} in JSON")


def _serve(link, folder):
    """Run commands in this process, as they come."""
    os.environ["GYROSTAT_CACHE"] = str(folder / "cache")
    os.environ["XLA_FLAGS"] = (
        "--xla_cpu_multi_thread_eigen=false --xla_backend_optimization_level=1"
    )
    from gyrostat.cli import main

    streams = [(folder / name).open("w+b") for name in ("stdout", "stderr")]
    while True:
        place, words = link.recv()
        for number, stream in enumerate(streams, 1):
            stream.seek(0)
            stream.truncate()
            os.dup2(stream.fileno(), number)
        os.chdir(place)
        sys.argv = ["gyrostat", *words]
        code = 0
        try:
            main()
        except SystemExit as stop:
            code = stop.code or 0
        except BaseException:
            traceback.print_exc()
            code = -1
        sys.stdout.flush()
        sys.stderr.flush()
        told = [Path(s.name).read_bytes().decode(errors="replace") for s in streams]
        link.send((code, *told))


class Server:
    """A process that runs commands, and another one where it did not answer in time."""

    def __init__(self, folder):
        self.folder, self.process, self.used = folder, None, 0.0

    def ask(self, place, words):
        """Exit code, stdout and stderr; None where there was no answer in time."""
        if self.process is None:
            context = multiprocessing.get_context("spawn")
            self.link, other = context.Pipe()
            self.process = context.Process(target=_serve, args=(other, self.folder), daemon=False)
            self.process.start()
        self.link.send((str(place), words))
        before, start = self._processor_time(), time.monotonic()
        while not self.link.poll(0.2):
            used = self._processor_time() - before
            if used > LIMIT or time.monotonic() - start > WAIT:
                self.used += used
                self.end()
                return None
        try:
            self.used += self._processor_time() - before
            return self.link.recv()
        except EOFError:
            self.end()
            return -2, "", "the process died"

    def _processor_time(self):
        """Of the process, s."""
        with open(f"/proc/{self.process.pid}/stat") as file:
            fields = file.read().rpartition(")")[2].split()
        return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")

    def end(self):
        """End the process."""
        if self.process is not None:
            self.process.kill()
            self.process.join()
            self.process = None


def main():
    """Run cases until the time or the count is over."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", default="0")
    parser.add_argument("--seconds", type=float, default=150.0, help="of processor time")
    parser.add_argument("--count", type=int, default=10**9)
    parser.add_argument("--case", type=int, help="this one alone")
    parser.add_argument("--verb", choices=VERBS, help="this verb alone")
    asked = parser.parse_args()
    codes, bad, slowest = Counter(), [], (0.0, None)
    with tempfile.TemporaryDirectory() as root:
        folder = Path(root)
        server = Server(folder)
        verbs = (asked.verb,) if asked.verb else tuple(VERBS)
        for number, verb, words, texts in cases(asked.seed, verbs):
            if asked.case is not None and number != asked.case:
                continue
            if number >= asked.count or server.used > asked.seconds:
                break
            place = folder / "place"
            place.mkdir()
            place_files(place, texts)
            before = server.used
            answer = server.ask(place, [verb, *words])
            taken = server.used - before
            slowest = max(slowest, (taken, number), key=lambda entry: entry[0])
            found = ["no answer in time"] if answer is None else faults(words, *answer, place)
            codes[verb, "hang" if answer is None else answer[0]] += 1
            if found or asked.case is not None:
                shown = [word if len(word) < 80 else word[:77] + "..." for word in words]
                bad += found
                print(f"case {number}, {taken:.1f} s: {verb} {shown}: {found}", flush=True)
                for name, text in texts.items():
                    print(f"  {name} is changed: {_difference(name, text)}")
                if answer is not None:
                    print(*(f"  {line[:300]}" for line in answer[2].splitlines()[-12:]), sep="\n")
            shutil.rmtree(place)
            if asked.case is not None:
                break
        server.end()
    for verb in VERBS:
        told = {str(code): count for (v, code), count in codes.items() if v == verb}
        print(f"{verb:10} {sum(told.values()):5} commands, exit codes {dict(sorted(told.items()))}")
    print(
        f"{sum(codes.values())} commands with seed {asked.seed}, {server.used:.0f} s of processor "
        f"time, longest {slowest[0]:.1f} s (case {slowest[1]}): {len(bad)} faults"
    )
    sys.exit(bool(bad))


def _difference(name, text):
    """Lines that a changed file has and the sound one has not."""
    own = {RECORD: record(), TOML: MODEL, "craft.toml": CRAFT, "scenario.toml": SCENARIO}[name]
    return [line[:100] for line in text.splitlines() if line not in own.splitlines()][:4] or "less"


if __name__ == "__main__":
    main()
