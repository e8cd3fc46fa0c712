"""Follow four routes of data through the code: python docs/follow_routes.py.

Each route is one command. A profiler records every call between functions of gyrostat. A crossing
is a distinct pair of caller and called function in different rooms (or files). The first crossing
into a room enters it; every other crossing into that room is a return. Calls repeated in a loop
count once, and what modules do while they are imported does not count. Each route runs in a process
of its own with an empty cache of compiled programs.

The script prints a Markdown table. It uses the command line alone, so that it also measures older
versions: PYTHONPATH=CHECKOUT/src python docs/follow_routes.py.
"""

import os
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from types import FrameType

import gyrostat
from gyrostat.cli import main as run

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples"
SOURCE = f"{Path(gyrostat.__file__).parent}/"
ROUTES = {
    "a record through identify": (
        f"identify {EXAMPLES}/wheel_profile2.csv --inertia 1.5e-3 --speed-sigma 5rpm --out {{out}}"
    ),
    "a scenario through a campaign": (
        f"campaign {EXAMPLES}/scenarios/zero_crossing_model.toml --runs 8 --seed 1 --workers 1 "
        "--out {out}"
    ),
    "a wheel through simulate": (
        f"simulate {EXAMPLES}/scenarios/zero_crossing_model.toml --out {{out}}/run.nc"
    ),
    "a compensator through export": (
        f"export {EXAMPLES}/scenarios/table_wheel.toml --to c --what compensator --period 100ms "
        "--gains 0.0571,0.00234,0.3126 --table-inertia 0.495 --speed-sigma 5rpm --out {out}"
    ),
}
Function = tuple[str, str]
"""File relative to the package, and qualified name."""


class Route:
    """Calls between functions of gyrostat, each pair once, in the order of the first call."""

    def __init__(self):
        self.calls: dict[tuple[Function, Function], None] = {}

    def __call__(self, frame: FrameType, event: str, argument: object) -> None:
        """Record a call; the caller is the innermost function of gyrostat that is active."""
        if event != "call" or (called := _function(frame)) is None:
            return
        outer = _outer(frame)
        if outer is None or (call := (_function(outer), called)) in self.calls:
            return
        while outer is not None:
            if outer.f_code.co_name == "<module>":  # called by an import
                return
            outer = _outer(outer)
        self.calls[call] = None

    def entered(self, place) -> tuple[list[str], int]:
        """Places entered, in order, and returns; `place` gives the place of a file."""
        order: dict[str, None] = {}
        returns = 0
        for (outer, _), (inner, _) in self.calls:
            source, target = place(outer), place(inner)
            order.setdefault(source)
            if source == target:
                continue
            returns += target in order
            order.setdefault(target)
        return list(order), returns


def room(file: str) -> str:
    """Room of a file: its folder in the package, or a module of its own."""
    return file.split("/")[0].removesuffix(".py")


def _function(frame: FrameType) -> Function | None:
    code = frame.f_code
    if not code.co_filename.startswith(SOURCE):
        return None
    return code.co_filename.removeprefix(SOURCE), code.co_qualname


def _outer(frame: FrameType) -> FrameType | None:
    """The innermost frame of gyrostat that encloses a frame."""
    outer = frame.f_back
    while outer is not None and _function(outer) is None:
        outer = outer.f_back
    return outer


def follow(command: str) -> Route:
    """Run a command with its calls recorded, in this thread and in threads that it starts.

    Raises:
        SystemExit: The command fails.
    """
    route = Route()
    with tempfile.TemporaryDirectory() as folder:
        os.environ["GYROSTAT_CACHE"] = f"{folder}/cache"
        sys.argv = ["gyrostat", *command.format(out=f"{folder}/out").split()]
        threading.setprofile(route)
        sys.setprofile(route)
        try:
            run()
        finally:
            sys.setprofile(None)
            threading.setprofile(None)
    return route


def main() -> None:
    """Print the row of the named route, or a table of all routes."""
    if len(sys.argv) == 1:
        print("| route | rooms | returns | files | returns between files | order of the rooms |")
        print("|---|---|---|---|---|---|", flush=True)
        for name in ROUTES:
            subprocess.run([sys.executable, __file__, name], check=True, stderr=subprocess.DEVNULL)
        return
    name = sys.argv[1]
    route = follow(ROUTES[name])
    rooms, returns = route.entered(room)
    files, between = route.entered(str)
    print(f"| {name} | {len(rooms)} | {returns} | {len(files)} | {between} | {', '.join(rooms)} |")


if __name__ == "__main__":
    main()
