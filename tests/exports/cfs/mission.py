"""A mission of the core Flight System: built once, with the applications of a test."""

import contextlib
import ctypes
import fcntl
import hashlib
import os
import shutil
import signal
import subprocess
import tarfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
TARBALL = Path("shared", "peers", "cfs", "cfs.tar.xz")
LONGEST_BUILD, LONGEST_FLIGHT = 900.0, 120.0  # s, on a machine with other work
TARGETS = """\
SET(MISSION_NAME "SampleMission")
SET(SPACECRAFT_ID 0x42)
SET(MISSION_GLOBAL_APPLIST {names})
SET(MISSION_CPUNAMES cpu1)
SET(cpu1_PROCESSORID 1)
SET(cpu1_FILELIST cfe_es_startup.scr)
"""
# A user other than root gets queues as deep as the system allows; so does root in this test.
QUEUES = ("osal/src/bsp/generic-linux/src/bsp_start.c", "if (geteuid() != 0)", "if (1)")


def missing() -> str:
    """What the build of the flight system needs and this machine lacks; "" if nothing."""
    if tarball() is None:
        return f"found no {TARBALL} in or above the repository"
    tools = [name for name in ("cmake", "make", "cc") if shutil.which(name) is None]
    if tools:
        return f"found no {', '.join(tools)}"
    check = ["cc", "-E", "-include", "libelf.h", "-x", "c", os.devnull]
    if subprocess.run(check, capture_output=True).returncode:
        return "found no libelf.h (libelf-dev)"
    return ""


def tarball() -> Path | None:
    """Sources of the flight system."""
    paths = (parent / TARBALL for parent in (ROOT, *ROOT.parents))
    return next((path for path in paths if path.is_file()), None)


class Mission:
    """Sources and build of the flight system in a folder that later tests use again."""

    def __init__(self, cache: Path):
        sources = tarball()
        assert sources is not None
        digest = hashlib.sha256(sources.read_bytes()).hexdigest()[:12]
        cache.mkdir(parents=True, exist_ok=True)
        self.root = cache / f"cfs-{digest}"
        self._lock = cache / "cfs.lock"
        if not self.root.is_dir():
            scratch = cache / f"cfs-{os.getpid()}"
            with tarfile.open(sources) as archive:
                archive.extractall(scratch, filter="data")
            name, old, new = QUEUES
            text = (scratch / name).read_text(encoding="utf-8")
            assert text.count(old) == 1
            (scratch / name).write_text(text.replace(old, new), encoding="utf-8")
            with contextlib.suppress(OSError):  # another process was faster
                scratch.rename(self.root)

    @contextlib.contextmanager
    def alone(self):
        """Only one process builds at a time."""
        with self._lock.open("w") as handle:
            fcntl.flock(handle, fcntl.LOCK_EX)
            yield

    def build(self, apps: dict[str, dict[str, str]], startup: str, target: Path) -> str:
        """Build applications and copy the mission to a folder.

        Args:
            apps: Name of the application -> name of its file -> text.
            startup: Text of the startup script.
            target: Folder in which the mission can run.

        Returns:
            Output of the build.
        """
        with self.alone():
            changed = _write(self.root / "apps", apps)
            defs = self.root / "sample_defs"
            changed |= _replace(defs / "targets.cmake", TARGETS.format(names=" ".join(apps)))
            _replace(defs / "cpu1_cfe_es_startup.scr", startup)
            output = ""
            if changed or not (self.root / "build" / ".prep").exists():
                output += self._make("SIMULATION=native", "prep")
            output += self._make("-j2") + self._make("install")
            shutil.copytree(self.root / "build" / "exe" / "cpu1", target)
        return output

    def _make(self, *words: str) -> str:
        done = subprocess.run(
            ["make", *words], cwd=self.root, capture_output=True, text=True, timeout=LONGEST_BUILD
        )
        output = done.stdout + done.stderr
        assert done.returncode == 0, output[-4000:]
        return output


def _write(folder: Path, apps: dict[str, dict[str, str]]) -> bool:
    """Write applications; returns whether their build has to be prepared anew."""
    folder.mkdir(exist_ok=True)
    prepared = False
    for old in folder.iterdir():
        if old.name not in apps:
            shutil.rmtree(old)
    for app, texts in apps.items():
        for old in (folder / app).rglob("*"):
            if old.is_file() and old.relative_to(folder / app).as_posix() not in texts:
                old.unlink()
        for name, text in texts.items():
            prepared |= _replace(folder / app / name, text) and name == "CMakeLists.txt"
    return prepared


def _replace(path: Path, text: str) -> bool:
    """Write a file if its text is another one, so that `make` builds only what has changed."""
    if path.is_file() and path.read_text(encoding="utf-8") == text:
        return False
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return True


def include_folders(root: Path) -> list[Path]:
    """Folders of the headers that an application includes."""
    build, target = root / "build", root / "build" / "native" / "default_cpu1"
    modules = [path / "fsw" / "inc" for path in (root / "cfe" / "modules").iterdir()]
    osal, psp = root / "osal" / "src" / "os" / "inc", root / "psp" / "fsw"
    folders = [build / "inc", target / "inc", *modules, osal, target / "osal" / "inc"]
    folders += [psp / "inc", target / "psp" / "inc", psp / "modules" / "iodriver" / "inc"]
    return [path for path in folders if path.is_dir()]


def run(command: list[str]) -> subprocess.CompletedProcess[str]:
    """Run a command; its output is that of the C language."""
    environment = {**os.environ, "LC_ALL": "C"}
    return subprocess.run(command, capture_output=True, text=True, env=environment)


@contextlib.contextmanager
def shared_memory(folder: Path):
    """Keys of shared memory that no other mission has; its segments are removed afterwards.

    The flight system takes them from the inodes of three files, and leaves the segments behind.
    """
    files = [folder / f".{area}keyfile" for area in ("cds", "reset", "reserved")]
    spares = []
    for path in files:
        path.write_bytes(b"")
        while _segment(path) >= 0:  # of another mission, or left behind by one
            spares.append(path.rename(folder / f"spare{len(spares)}"))  # another inode
            path.write_bytes(b"")
    try:
        yield
    finally:
        for path in files:
            if (segment := _segment(path)) >= 0:
                ctypes.CDLL(None).shmctl(segment, 0, None)


def _segment(path: Path) -> int:
    """Segment of shared memory with the key of a file; -1 if there is none."""
    about = path.stat()
    key = ord("R") << 24 | (about.st_dev & 0xFF) << 16 | (about.st_ino & 0xFFFF)  # as ftok
    return ctypes.CDLL(None).shmget(key, 0, 0)


def fly(folder: Path, names: list[str]) -> str:
    """Run the mission until the flights with these applications are done; returns its output."""
    with (folder / "output.txt").open("w") as output, shared_memory(folder):
        core = subprocess.Popen(["./core-cpu1"], cwd=folder, stdout=output, stderr=output)
        try:
            end = time.monotonic() + LONGEST_FLIGHT
            while not all((folder / f"{name}.done").exists() for name in names):
                failed = [p.read_text() for p in folder.glob("*.failed")]
                assert not failed, failed
                assert core.poll() is None, "the flight system has ended"
                assert time.monotonic() < end, "the flight takes too long"
                time.sleep(0.02)
        finally:
            core.send_signal(signal.SIGTERM)
            try:
                core.wait(10.0)
            except subprocess.TimeoutExpired:
                core.kill()
                core.wait()
    return (folder / "output.txt").read_text(errors="replace")
