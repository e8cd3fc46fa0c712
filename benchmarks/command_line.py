"""Whole-process times of commands: first with an empty cache, then again.

python benchmarks/command_line.py [--repeats 3] [--scenarios] [--papers]

Each time is also given as a ratio to the import of JAX by a process of its own in the same minute,
which removes most of the speed of the machine. The processor time is that of the process and its
children; other work on the machine changes it less. The package is compiled to byte code first, as
by its installation; without byte code each command takes a quarter of a second longer.
"""

import argparse
import compileall
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import gyrostat

EXAMPLES = Path(__file__).parents[1] / "examples"
COMMAND = str(Path(sys.executable).with_name("gyrostat"))
READY = (
    *("zero_crossing_model", "wheel_failure", "wheel_failure_found", "wheel_array", "carrara_kuga"),
    *("carvalho_fenili", "moreira_lopes_kuga", "endo_sekiguchi_nonaka"),
)
PAPERS = ("carrara-kuga", "carvalho-fenili", "endo-sekiguchi-nonaka", "moreira-lopes-kuga")
QUESTION = ("--momentum", "0.46,-0.04,0.82", "--target", "1,0,0,0")
RECOVERY = (
    *("--wheels", "180rpm,-210rpm,520rpm", "--rate", "1e-3,-2e-3,0"),
    *("--attitude", "0.9239,0,0,0.3827", "--target", "0.9239,0,0,0.3827"),
)
NOTEBOOK = "import gyrostat as gs; gs.simulate('zero_crossing_model.toml')"


def seconds(words, cache, folder):
    """Wall and processor time of one process with a given cache folder."""
    before, used = time.perf_counter(), processor_time()
    subprocess.run(
        list(map(str, words)),
        check=True,
        capture_output=True,
        cwd=folder,
        env={**os.environ, "GYROSTAT_CACHE": str(cache)},
    )
    return time.perf_counter() - before, processor_time() - used


def processor_time():
    """Processor time of all processes that this one has started and that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class Table:
    """Rows of times, printed as they are measured."""

    def __init__(self, folder, repeats):
        self.folder, self.repeats, self.count = folder, repeats, 0
        print("| command | median (s) | min (s) | max (s) | ratio | processor (s) | its ratio |")
        print("|---|---|---|---|---|---|---|")

    def row(self, name, make, cache, repeats=None):
        """Measure `make(k)`, the words of repetition k."""
        times, units = [], []
        for _ in range(repeats or self.repeats):
            self.count += 1
            units.append(seconds([sys.executable, "-c", "import jax"], cache, self.folder))
            times.append(seconds(make(self.count), cache, self.folder))
        (wall, used), (one, one_used) = (
            map(statistics.median, zip(*k, strict=True)) for k in (times, units)
        )
        ends = f"{min(times)[0]:.2f} | {max(times)[0]:.2f}"
        ratios = f"{wall / one:.1f} | {used:.2f} | {used / one_used:.1f}"
        print(f"| {name} | {wall:.2f} | {ends} | {ratios} |")
        sys.stdout.flush()


def variant(folder, count, old, new):
    """The scenario with another number."""
    text = (folder / "zero_crossing_model.toml").read_text()
    if old not in text:
        raise SystemExit(f"zero_crossing_model.toml: found no {old!r}")
    path = folder / f"variant_{count}.toml"
    path.write_text(text.replace(old, new, 1))
    return path


def main():
    """Print the table."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--repeats", type=int, default=3)
    arguments.add_argument("--scenarios", action="store_true", help="also eight campaigns")
    arguments.add_argument("--papers", action="store_true", help="also the reproductions")
    given = arguments.parse_args()
    compileall.compile_dir(Path(gyrostat.__file__).parent, quiet=1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for path in (EXAMPLES / "scenarios").glob("*.toml"):
            (folder / path.name).write_text(path.read_text())
        cache, table = folder / "cache", Table(folder, given.repeats)
        crossing = folder / "zero_crossing_model.toml"

        def simulate(k, path=crossing):
            return [COMMAND, "simulate", path, "--out", f"run{k}.nc"]

        def changed(k):
            return simulate(
                k, variant(folder, k, 'band = "20 rpm"', f'band = "{20 + 0.1 * k} rpm"')
            )

        def campaign(k, runs=1000, path=crossing):
            return [COMMAND, "campaign", path, "--runs", runs, "--seed", k, "--out", f"campaign{k}"]

        table.row("`--help`", lambda k: [COMMAND, "--help"], cache)
        table.row("`simulate`, first", simulate, folder / "first", 1)
        table.row("`simulate`, empty cache", simulate, cache, 1)
        table.row("`simulate`, again", simulate, cache)
        table.row("`simulate`, another number", changed, cache)
        table.row("`campaign --runs 1000`, first", campaign, folder / "second", 1)
        table.row("`campaign --runs 1000`, another seed", campaign, cache)
        table.row("`campaign --runs 10000`, again", lambda k: campaign(k, 10_000), cache, 1)
        done = next(folder.glob("campaign*"))
        table.row("`replay DIR N`", lambda k: [COMMAND, "replay", done, k], cache)
        table.row("`report DIR`", lambda k: [COMMAND, "report", done], cache)
        record = EXAMPLES / "wheel_profile2.csv"
        identify = [COMMAND, "identify", record, "--inertia", "1.5e-3", "--out", "fit"]
        table.row("`identify`, first", lambda k: identify, folder / "third", 1)
        table.row("`identify`, empty cache", lambda k: identify, cache, 1)
        table.row("`identify`, again", lambda k: identify, cache)
        three = [EXAMPLES / "three_wheels.toml", "--failed"]
        feasible = [COMMAND, "feasible", *three, "x=180rpm", *QUESTION, "--out", "feasible"]
        table.row("`feasible`", lambda k: feasible, cache)
        recover = [COMMAND, "recover", *three, "x=rundown:60s", *RECOVERY, "--out", "recover"]
        table.row("`recover`, first", lambda k: recover, cache, 1)
        table.row("`recover`, again", lambda k: recover, cache)
        export = [COMMAND, "export", "fit/model.toml", "--to", "c", "--what", "compensator"]
        export += ["--period", "100ms", "--gains", "0.0571,0.00234,0.3126", "--table-inertia"]
        export += ["0.495", "--speed-sigma", "5rpm", "--out", "flight"]
        table.row("`export --to c`", lambda k: export, cache)
        table.row("a notebook's `gs.simulate`", lambda k: [sys.executable, "-c", NOTEBOOK], cache)
        for ready in READY if given.scenarios else ():
            path = folder / f"{ready}.toml"
            own = folder / f"cache_{ready}"
            table.row(f"`campaign --runs 128`, {ready}", lambda k: campaign(k, 128, path), own, 1)  # noqa: B023
        for paper in PAPERS if given.papers else ():
            quick = [COMMAND, "reproduce", paper, "--quick", "--out", f"quick_{paper}"]
            table.row(f"`reproduce {paper} --quick`, again", lambda k: quick, cache, 2)  # noqa: B023


if __name__ == "__main__":
    main()
