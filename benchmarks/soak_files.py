"""Damage to the folder of a finished campaign: is each repaired or refused, and none passed over?

python benchmarks/soak_files.py [--flips 2000] [--others 500] [--workers 2] [--seed 1]

Single bits are flipped; files are truncated, extended, deleted, swapped, and replaced by those of
another campaign, by links and by folders; foreign files are added. After each damage `gyrostat
campaign`, `report` and `replay` are asked, each on a damaged copy of its own. An answer counts as

repaired    exit 0, and every file is byte for byte that of the same command on an undamaged copy,
            but for what a message names: histories and pages that were set aside, damaged blocks
refused     exit 2 and one line that says why
silent      exit 0 with anything else
traceback   everything else

The exit code is 1 if an answer was silent or a traceback. All commands run in one process for each
worker, so that the scenario is traced once; statistics, figures and histories are made once for
each set of numbers.
"""

import argparse
import contextlib
import hashlib
import io
import json
import multiprocessing
import os
import pickle
import random
import shutil
import sys
import tempfile
import traceback
from collections import Counter
from concurrent.futures import Executor, Future
from pathlib import Path

EXAMPLES = Path(__file__).parents[1] / "examples" / "scenarios"
RUNS, BLOCK, KEPT, REPLAYED = 20, 8, 2, 5
DISPERSION = """
[[dispersion]]
key = "wheel.a.coulomb"
distribution = "log_normal"
sigma = "20 %"
"""
OUTCOMES = ("repaired", "refused", "silent", "traceback")
UNUSED = ".lock"
"""Holds nothing: only its lock counts."""


class Here(Executor):
    """Executor that works at once, in this process."""

    def submit(self, fn, /, *args, **kwargs):
        """Do the work."""
        future = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except BaseException as error:
            future.set_exception(error)
        return future


def verb(*words):
    """Run the command line in this process: exit code, stderr; None for a traceback."""
    from gyrostat.cli import main

    said, code = io.StringIO(), 0
    before, sys.argv = sys.argv, ["gyrostat", *map(str, words)]
    try:
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
            main()
    except SystemExit as stop:
        code = stop.code or 0
    except BaseException:
        return None, said.getvalue() + traceback.format_exc()
    finally:
        sys.argv = before
    return code, said.getvalue()


def once(function, key):
    """Memo of a function by a key of its arguments."""
    known = {}

    def called(*arguments, **options):
        name = key(*arguments, **options)
        if name not in known:
            known[name] = function(*arguments, **options)
        return known[name]

    return called


def work_once(put=setattr):
    """Keep each figure, and each history as a file: the same numbers come a thousand times."""
    import numpy as np

    from gyrostat.reports import campaign, campaign_run, metric_statistics
    from gyrostat.simulation.labelled import Labelled

    def of_table(scenario, columns, names):
        parts = (
            f"{name}{values.dtype}".encode() + bytes(values) for name, values in columns.items()
        )
        return hashlib.sha256(b"".join(parts)).digest(), tuple(names)

    def of_history(scenario, row, history):
        names = ("time", "error", "rate", "wheel_speed", "torque")
        parts = (np.asarray(history[name]).tobytes() for name in names)
        return hashlib.sha256(b"".join(parts)).digest()

    def written(history, path):
        parts = (values.tobytes() for _, values in sorted(history.arrays().items()))
        key = hashlib.sha256(b"".join(parts) + str(history).encode()).digest()
        if key not in histories:
            genuine_write(history, path)
            histories[key] = path.read_bytes()
        path.write_bytes(histories[key])

    def of_numbers(*given):
        return hashlib.sha256(pickle.dumps(given)).digest()

    def of_columns(*given):
        return of_numbers(*([bytes(values) for values in columns] for columns in given))

    histories, genuine_write = {}, Labelled.write
    put(os, "fsync", lambda handle: None)  # no power is cut here
    put(Labelled, "write", written)
    for name in ("histograms", "scatter_plots"):
        put(campaign, name, once(getattr(campaign, name), of_table))
    put(metric_statistics, "drivers_of", once(metric_statistics.drivers_of, of_columns))
    put(metric_statistics, "find_effects", once(metric_statistics.find_effects, of_numbers))
    put(campaign_run, "run_charts", once(campaign_run.run_charts, of_history))


def fly_here(opener, put=setattr):
    """Let the commands fly through this executor in place of new processes."""
    from gyrostat.campaigns import jobs

    for kind in ("processes", "threads"):
        put(jobs, kind, lambda workers: opener)


def files_of(folder):
    """Name -> content of each file; a link or folder in its place is told by its kind."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.is_symlink():
            found[name] = b"link"
        elif path.is_file():
            found[name] = path.read_bytes()
    return found


class Attack:
    """Damages and what came of them.

    Args:
        pristine: folder of a finished campaign.
        other: folder of another finished campaign of as many runs.
        work: folder for the damaged copy.
        verbs: name -> words of the command on that copy.
    """

    def __init__(self, pristine, other, work, verbs):
        self.pristine, self.other, self.work, self.verbs = pristine, other, work, verbs
        self.files = sorted(files_of(pristine))
        self.counts = Counter()
        self.faults = []
        self._right = {}

    def _copy(self):
        shutil.rmtree(self.work, ignore_errors=True)
        shutil.copytree(self.pristine, self.work)

    def right(self, name, missing):
        """The files after a command on an undamaged copy from which some files were removed."""
        if (name, missing) not in self._right:
            self._copy()
            for file in missing:
                (self.work / file).unlink()
            code, said = verb(*self.verbs[name])
            assert code == 0, said
            self._right[name, missing] = files_of(self.work)
        return self._right[name, missing]

    def judge(self, name, code, said, before):
        """The outcome of a command on a damaged copy."""
        lines = said.splitlines()
        if code == 2 and lines and lines[-1].startswith("error: ") and said.count("error: ") == 1:
            return "refused"
        if code != 0:
            return "traceback"
        after = files_of(self.work)
        missing = frozenset(
            file for file in self.files if file not in after and file.startswith(("runs", "report"))
        )
        if any(file in before and f"{file}: found" not in said for file in missing):
            return "silent"
        right = self.right(name, missing)
        for file, content in right.items():
            if file == UNUSED or after.get(file) == content:
                continue
            if file == ".gyrostat.json" and self._lists_all(after):
                continue
            number = file.removeprefix("blocks/").split(".")[0]
            if file.startswith("blocks/") and f"block {int(number)} is" in said:
                continue
            return "silent"
        return "repaired"

    def _lists_all(self, after):
        listed = json.loads(after[".gyrostat.json"])["files"]
        results = [n for n in after if n.startswith(("runs", "report")) and ".changed" not in n]
        return all(
            [hashlib.sha256(after[name]).hexdigest()] == listed[name]["sha256"] for name in results
        )

    def try_one(self, kind, damage):
        """Damage a copy and ask each command."""
        for name in self.verbs:
            self._copy()
            file = damage(self.work)
            before = files_of(self.work)
            code, said = verb(*self.verbs[name])
            outcome = self.judge(name, code, said, before)
            what = "blocks/*" if file.startswith("blocks/0") else file
            self.counts[what, kind, outcome] += 1
            if outcome in ("silent", "traceback"):
                self.faults.append(f"{kind} of {file}, {name}: {outcome}, exit {code}\n{said}")

    def flip(self, choice):
        """A bit of a file."""
        file = choice.choice([name for name in self.files if name != UNUSED])
        place = choice.randrange(8 * (self.pristine / file).stat().st_size)

        def damage(folder):
            content = bytearray((folder / file).read_bytes())
            content[place // 8] ^= 1 << place % 8
            (folder / file).write_bytes(content)
            return file

        self.try_one("flipped bit", damage)

    def other_damage(self, choice):
        """Something coarser."""
        kind = choice.choice(sorted(OTHERS))
        state = choice.getrandbits(64)
        self.try_one(kind, lambda folder: OTHERS[kind](self, folder, random.Random(state)))

    def _truncate(self, folder, choice):
        file = choice.choice([name for name in self.files if name != UNUSED])
        size = (folder / file).stat().st_size
        os.truncate(
            folder / file, choice.choice([0, 1, size // 2, size - 1, choice.randrange(size)])
        )
        return file

    def _extend(self, folder, choice):
        file = choice.choice(self.files)
        with (folder / file).open("ab") as stream:
            stream.write(choice.randbytes(choice.choice([1, 4096])))
        return file

    def _delete(self, folder, choice):
        file = choice.choice([*self.files, "blocks", "runs"])
        path = folder / file
        shutil.rmtree(path) if path.is_dir() else path.unlink()
        return file

    def _swap(self, folder, choice):
        first, second = choice.sample([name for name in self.files if name != UNUSED], 2)
        content = (folder / first).read_bytes()
        (folder / second).replace(folder / first)
        (folder / second).write_bytes(content)
        return first

    def _exchange(self, folder, choice):
        """Files of another campaign, one or all but the description."""
        names = sorted(files_of(self.other))
        file = choice.choice([*names, "everything but campaign.json", "campaign.json"])
        if file in names:
            shutil.copy(self.other / file, folder / file)
            return file
        shutil.rmtree(folder)
        shutil.copytree(self.other, folder)
        shutil.copy(self.pristine / "campaign.json", folder)
        return file

    def _renumber(self, folder, choice):
        blocks = [name for name in self.files if name.startswith("blocks/")]
        first, second = choice.sample(blocks, 2)
        number = second.removeprefix("blocks/")[:6]
        (folder / second).unlink()
        (folder / first).rename(folder / "blocks" / (number + first.removeprefix("blocks/")[6:]))
        return first

    def _link(self, folder, choice):
        """A link to the same content elsewhere, to nothing, or of a folder."""
        file = choice.choice([*self.files, "blocks", "runs"])
        path = folder / file
        shutil.rmtree(path) if path.is_dir() else path.unlink()
        path.symlink_to(choice.choice([self.pristine / file, Path("nowhere"), Path("/dev/zero")]))
        return file

    def _folder(self, folder, choice):
        file = choice.choice(self.files)
        (folder / file).unlink()
        (folder / file).mkdir()
        if choice.random() < 0.5:
            (folder / file / "mine").write_text("mine")
        return file

    def _foreign(self, folder, choice):
        """A file that was not there."""
        names = (
            *("notes.txt", ".profile", "blocks/README", "blocks/000001.parquet", "runs/x.nc"),
            *("runs/run_000019.nc", "runs/run_000019.html", "runs/run_000099.nc"),
            *(f"blocks/000001.{'0' * 64}.parquet", f"blocks/000077.{'a' * 64}.parquet"),
            *("report.html.changed", "runs/run_000007.html", ".gyrostat-abcdefgh"),
        )
        file = choice.choice(names)
        (folder / file).write_bytes(choice.randbytes(choice.choice([0, 100])))
        return file


OTHERS = {
    "truncation": Attack._truncate,
    "appended bytes": Attack._extend,
    "deletion": Attack._delete,
    "swap": Attack._swap,
    "of another campaign": Attack._exchange,
    "renumbered block": Attack._renumber,
    "link": Attack._link,
    "folder in its place": Attack._folder,
    "foreign file": Attack._foreign,
}


def prepared(folder):
    """Fly two campaigns that differ by their seeds; the attack on the first."""
    fly_here(lambda: contextlib.nullcontext(Here()))
    work_once()
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, folder)
    text = (EXAMPLES / "zero_crossing_model.toml").read_text(encoding="utf-8")
    text = text.replace('"400 s"', '"40 s"').replace('after = "60 s"', 'after = "20 s"')
    text = text[: text.index("[[dispersion]]")] + DISPERSION
    (folder / "scenario.toml").write_text(text, encoding="utf-8")
    work = folder / "work"
    options = ("--block", BLOCK, "--keep", KEPT, "--worst", 1, "--out", work)
    for name, seed in (("other", 2), ("pristine", 1)):
        words = ("campaign", folder / "scenario.toml", "--runs", RUNS, "--seed", seed, *options)
        for command in (words, ("replay", work, REPLAYED), ("report", work)):
            code, said = verb(*command)
            assert code == 0, said
        work.rename(folder / name)
    verbs = {"campaign": words, "report": ("report", work), "replay": ("replay", work, REPLAYED)}
    return Attack(folder / "pristine", folder / "other", work, verbs)


def attacked(options):
    """Make some damages: the outcomes, and the faults in words."""
    flips, others, seed = options
    with tempfile.TemporaryDirectory() as name:
        attack, choice = prepared(Path(name)), random.Random(seed)
        for _ in range(flips):
            attack.flip(choice)
        for _ in range(others):
            attack.other_damage(choice)
    return attack.counts, attack.faults


def main():
    """Print the table."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--flips", type=int, default=2000)
    arguments.add_argument(
        "--others", type=int, default=500, help="damages that are no flipped bit"
    )
    arguments.add_argument("--workers", type=int, default=2)
    arguments.add_argument("--seed", type=int, default=1)
    options = arguments.parse_args()
    shares = [
        (
            len(range(k, options.flips, options.workers)),
            len(range(k, options.others, options.workers)),
            options.seed + k,
        )
        for k in range(options.workers)
    ]
    with multiprocessing.get_context("spawn").Pool(options.workers) as pool:
        done = pool.map(attacked, shares)
    counts = sum((found for found, _ in done), Counter())
    print(f"| file | damage | {' | '.join(OUTCOMES)} |")
    print("|---" * (2 + len(OUTCOMES)) + "|")
    for file, kind in sorted({key[:2] for key in counts}, key=lambda key: (key[1], key[0])):
        row = [str(counts[file, kind, outcome]) for outcome in OUTCOMES]
        print(f"| {file} | {kind} | {' | '.join(row)} |")
    total = Counter()
    for (_, _, outcome), count in counts.items():
        total[outcome] += count
    print(f"| all | all | {' | '.join(str(total[outcome]) for outcome in OUTCOMES)} |")
    for _, faults in done:
        for fault in faults[:5]:
            print(f"\n{fault}")
    sys.exit(1 if total["silent"] or total["traceback"] else 0)


if __name__ == "__main__":
    main()
