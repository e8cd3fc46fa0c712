"""Attacks on the cache of compiled programs: damage, planted libraries, foreign folders, kills.

Each attack is followed by a fresh process that uses the cache. It must compute the same number,
end with exit code 0 and never execute what was planted: a library that leaves a mark when loaded,
with a digest that fits where the attacker could compute it.

    python benchmarks/soak_cache.py                  about two minutes of one core
    python benchmarks/soak_cache.py --count 5        of each attack; the default is 20
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from gyrostat.codegen.simd.compiler import compiled, compiler, required
from gyrostat.core.cache import Cache, private_cache

STRANGER = 12345
NUMBER = 42
MODULE = '#include "lanes.h"\nint found(void) {{ return LANES * 0 + {}; }}\n'
LANES = f"""
from gyrostat.codegen.simd.compiler import library
print(library({MODULE.format(NUMBER)!r}).found())
"""
JAX = """
import sys
from gyrostat.core.jax_cache import keep_programs
keep_programs(lambda text: print(text, file=sys.stderr))
from gyrostat.core.jax64 import jax, jnp
print(int(jax.jit(lambda x: jnp.linalg.inv(x) @ x * 42.0 + 1e-6)(jnp.eye(3))[0, 0]))
"""


class Attacked:
    """A cache and the marks of what should not have happened."""

    def __init__(self, root, seed):
        self.root, self.source, self.tally = root, random.Random(seed), Counter()
        self.bad = []
        self.mark = root / "executed"
        self.home = root / "cache"
        self.planted = self._plant()

    def _plant(self):
        """A library that leaves a mark when it is loaded, and gives another number."""
        text = self.root / "planted.c"
        text.write_text(
            "#include <stdio.h>\n__attribute__((constructor)) static void run(void)\n"
            f'{{ FILE *mark = fopen("{self.mark}", "w"); if (mark) fclose(mark); }}\n'
            "int found(void) { return 666; }\n"
        )
        made = self.root / "planted.so"
        subprocess.run([*required(), "-shared", "-fPIC", "-o", made, text], check=True)
        return made.read_bytes()

    def fresh(self):
        """A whole cache, filled by this process."""
        shutil.rmtree(self.home, ignore_errors=True)
        os.environ["GYROSTAT_CACHE"] = str(self.home)
        cache = private_cache()
        compiled(MODULE.format(NUMBER))
        return cache, next(cache.path.glob("lanes-*"))

    def use(self, attack, code=LANES, said=False, home=None):
        """Use the cache in a new process; said: whether it must say that it uses another folder."""
        environment = {
            **os.environ,
            "GYROSTAT_CACHE": str(home or self.home),
            "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
            "JAX_PLATFORMS": "cpu",
        }
        done = subprocess.run(
            [sys.executable, "-c", code], env=environment, capture_output=True, text=True
        )
        found = []
        if done.returncode != 0:
            found.append(f"exit code {done.returncode}: {done.stderr[-300:]}")
        elif done.stdout.split() != [str(NUMBER)]:
            found.append(f"found {done.stdout!r}")
        if self.mark.exists():
            self.mark.unlink()
            found.append("EXECUTED what was planted")
        if ("cache of compiled programs" in done.stderr) != said or "Traceback" in done.stderr:
            found.append(f"said {done.stderr!r}")
        self._count(attack, found)

    def _count(self, attack, found):
        self.tally[attack] += 1
        for fault in found:
            self.bad.append(f"{attack}: {fault}")
            print(self.bad[-1], flush=True)


def damage(attacked, count):
    """Flip bits of the library's entry, and truncate it."""
    _, entry = attacked.fresh()
    whole = entry.read_bytes()
    for _ in range(count):
        entry.write_bytes(_flipped(whole, attacked.source))
        attacked.use("flipped library")
        entry.write_bytes(whole[: attacked.source.randrange(len(whole))])
        attacked.use("truncated library")
        if entry.read_bytes() != whole:
            attacked._count("damaged entry is made again", ["it was not"])


def _flipped(whole, source):
    flipped = bytearray(whole)
    flipped[source.randrange(len(whole))] ^= 1 << source.randrange(8)
    return bytes(flipped)


def plant(attacked, count):
    """Put other files in the entry's place."""

    def replaced(entry, content):
        entry.unlink()
        entry.write_bytes(content)

    def other(entry):
        compiled(MODULE.format(7))
        swapped = next(path for path in entry.parent.glob("lanes-*") if path != entry)
        replaced(entry, swapped.read_bytes())

    def linked(entry):
        target = attacked.root / "planted.so"
        entry.unlink()
        entry.symlink_to(target)

    ways = {
        "planted library": lambda entry: replaced(entry, attacked.planted),
        "planted under an old name": lambda entry: (
            replaced(entry, b""),
            [
                (entry.parent / f"{entry.name[:length]}.so").write_bytes(attacked.planted)
                for length in (6 + 32, None)
            ],
        ),
        "entry of another module": other,
        "link to a planted library": linked,
        "pipe": lambda entry: (entry.unlink(), os.mkfifo(entry)),
        "folder": lambda entry: (entry.unlink(), entry.mkdir()),
        "file that others may write": lambda entry: (
            Cache(entry.parent).write(entry.name, attacked.planted),
            entry.chmod(0o666),
        ),
    }
    for _ in range(max(1, count // 10)):
        for name, way in ways.items():
            _, entry = attacked.fresh()
            way(entry)
            attacked.use(name)


def strange(attacked, count):
    """Folders of others and that others may write, with planted entries whose digests fit."""
    for _ in range(max(1, count // 10)):
        for name, mode in (("others", 0o777), ("the group", 0o770)):
            for which in ("folder", "parent"):
                home = attacked.root / "outer" / "cache"
                _planted_cache(attacked, home)
                (home if which == "folder" else home.parent).chmod(mode)
                attacked.use(f"{which} that {name} may write", said=True, home=home)
        if os.geteuid() != 0:
            continue
        for which in ("folder", "parent", "entries"):
            home = attacked.root / "outer" / "cache"
            _planted_cache(attacked, home)
            owned = {"folder": [home], "parent": [home.parent], "entries": home.glob("lanes-*")}
            for path in owned[which]:
                os.chown(path, STRANGER, STRANGER)
            attacked.use(f"{which} of a stranger", said=which != "entries", home=home)
        link = attacked.root / "link"
        _planted_cache(attacked, home)
        os.chown(home, STRANGER, STRANGER)
        link.unlink(missing_ok=True)
        link.symlink_to(home)
        attacked.use("link to a stranger's folder", said=True, home=link)


def _planted_cache(attacked, home):
    shutil.rmtree(attacked.root / "outer", ignore_errors=True)
    cache, entry = attacked.fresh()
    home.parent.mkdir(mode=0o700)
    shutil.move(cache.path, home)
    Cache(home).write(entry.name, attacked.planted)


def kill(attacked, count):
    """Kill a process while it compiles, at times all over the compilation."""
    for k in range(max(1, count // 4)):
        shutil.rmtree(attacked.home, ignore_errors=True)
        environment = {**os.environ, "GYROSTAT_CACHE": str(attacked.home)}
        process = subprocess.Popen(
            [sys.executable, "-c", LANES], env=environment, stdout=subprocess.DEVNULL
        )
        begun = time.monotonic()
        while not list(attacked.home.glob("making-*")) and process.poll() is None:
            time.sleep(0.001)
        time.sleep(k * 0.4 / count * min(4.0, max(1.0, time.monotonic() - begun)))
        process.send_signal(signal.SIGKILL)
        process.wait()
        found = [] if _ended(attacked.home) else ["a compiler lives on"]
        attacked._count("killed while compiling", found)
        attacked.use("after a kill")
        left = [path.name for path in attacked.home.iterdir() if path.name.startswith("making-")]
        attacked._count("nothing is left after a kill", left)


def _ended(folder, seconds=10.0):
    """Whether no process has a file of the folder among its arguments or as its working folder."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if not any(_works_in(process, folder) for process in Path("/proc").glob("[0-9]*")):
            return True
        time.sleep(0.02)
    return False


def _works_in(process, folder):
    try:
        return os.readlink(process / "cwd").startswith(str(folder))
    except OSError:
        return False


def jax_programs(attacked, count):
    """Flip bits of JAX's programs, truncate and swap them, all entries at a time."""
    shutil.rmtree(attacked.home, ignore_errors=True)
    attacked.use("JAX, empty cache", JAX)
    whole = {path: path.read_bytes() for path in attacked.home.glob("jax-*")}
    if not whole:
        attacked._count("JAX, entries", ["found none"])
    names, source = list(whole), attacked.source
    for k in range(max(3, count // 5)):
        for n, (path, content) in enumerate(whole.items()):
            damaged = (
                _flipped(content, source),
                content[: source.randrange(len(content))],
                whole[names[n - 1]],
            )
            path.write_bytes(damaged[k % 3])
        attacked.use(f"JAX, {('flipped', 'truncated', 'swapped')[k % 3]} programs", JAX)
        if set(attacked.home.glob("jax-*")) != set(whole):
            attacked._count("JAX, entries are made again", ["they were not"])


def main():
    """Run every attack, print how many of each, and fail if one succeeded."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=20, help="of each attack")
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    if compiler() is None:
        print("no C compiler: nothing to attack")
        return
    begun = time.monotonic()
    with tempfile.TemporaryDirectory() as root:
        attacked = Attacked(Path(root).resolve(), asked.seed)
        for attack in (damage, plant, strange, kill, jax_programs):
            attack(attacked, asked.count)
    if os.geteuid() != 0:
        print("not root: folders of other users are left out")
    for attack, number in attacked.tally.items():
        print(f"{number:5} {attack}")
    print(
        f"{sum(attacked.tally.values())} attacks in {time.monotonic() - begun:.0f} s: "
        f"{len(attacked.bad)} succeeded"
    )
    sys.exit(bool(attacked.bad))


if __name__ == "__main__":
    main()
