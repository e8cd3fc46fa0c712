"""Whole-process times of commands, first run and with the compilation cache.

python benchmarks/command_line.py [--runs 5]
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

EXAMPLE = Path(__file__).parents[1] / "examples" / "wheel_profile2.csv"
COMMAND = str(Path(sys.executable).with_name("gyrostat"))


def seconds(words, cache):
    """Wall time of one process with a given cache folder."""
    before = time.perf_counter()
    subprocess.run(
        [COMMAND, *words],
        check=True,
        capture_output=True,
        env={**os.environ, "XDG_CACHE_HOME": str(cache)},
    )
    return time.perf_counter() - before


def main():
    """Print the table."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--runs", type=int, default=5)
    runs = arguments.parse_args().runs
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        identify = ["identify", str(EXAMPLE), "--inertia", "1.5e-3", "--out", str(out)]
        seconds(["--help"], folder)  # the interpreter writes its bytecode once
        first = [seconds(identify, Path(folder) / f"cache{k}") for k in range(runs)]
        warm = [seconds(identify, Path(folder) / "cache0") for _ in range(runs)]
        brief = [seconds(["--help"], folder) for _ in range(runs)]
        paper = ["reproduce", "carvalho-fenili", "--quick", "--out", str(out)]
        flown = [seconds(paper, Path(folder) / "cache0") for _ in range(2)]
    print("| command | median (s) | min (s) | max (s) |")
    print("|---|---|---|---|")
    for name, times in (
        ("identify, empty compilation cache", first),
        ("identify, warm compilation cache", warm),
        ("--help", brief),
        ("reproduce carvalho-fenili --quick, empty compilation cache", flown[:1]),
        ("reproduce carvalho-fenili --quick, warm compilation cache", flown[1:]),
    ):
        print(f"| {name} | {statistics.median(times):.2f} | {min(times):.2f} | {max(times):.2f} |")


if __name__ == "__main__":
    main()
