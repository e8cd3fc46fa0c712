"""Lock of a folder on an object store, by conditional creation of objects.

Each holder creates the object `.lock-N` with the next number, on the condition that it does not
exist (If-None-Match); of several writers the store lets one through. The holder counts in it while
it lives. After a kill the count stands still, and the next command takes the next number. No clock
is compared with another.
"""

import json
import os
import platform
import threading
import time
from collections.abc import Callable
from typing import Any

from gyrostat.core.errors import InputError

BEAT = 2.0
"""Time between two counts of the holder, s."""
LEASE = 4
"""Number of times `BEAT` without a new count after which the holder has ended."""
NAME = ".lock-"


class RemoteLock:
    """Lock of a folder on an object store, held until `release`.

    Args:
        files: File system of fsspec.
        root: Path of the folder in it.
        url: Name of the folder in messages.
        say: Called with a message if it must be found out whether a holder lives.

    Raises:
        InputError: Another process holds it.
        Exception: Whatever the store raises if it cannot be written.
    """

    def __init__(self, files: Any, root: str, url: str, say: Callable[[str], None]):
        self._files, self._root, self._url = files, root, url
        self._count, self._ended = 0, threading.Event()
        self.is_lost = False
        numbers = self._numbers()
        if numbers:
            self._wait_for_end_of(numbers[-1], say)
        self._number = (numbers[-1] if numbers else 0) + 1
        try:
            files.pipe_file(self._path(self._number), self._content(), mode="create")
        except FileExistsError:
            raise self._refusal() from None
        if not self._is_conditional():
            files.rm_file(self._path(self._number))
            raise InputError(
                f"{url}: found a store that replaces an object which was to be created only if it "
                "does not exist, expected one that knows this condition: two campaigns could "
                "write to the same folder"
            )
        if self._numbers()[-1] != self._number:  # this process was slow, and others were not
            files.rm_file(self._path(self._number))
            raise self._refusal()
        for number in numbers:
            self._remove(number)
        self._thread = threading.Thread(target=self._beat, daemon=True)
        self._thread.start()

    def release(self) -> None:
        """Release the lock."""
        self._ended.set()
        self._thread.join()
        if not self.is_lost:
            content = self._content(released=True)
            self._files.pipe_file(self._path(self._number), content)

    def _path(self, number: int) -> str:
        return f"{self._root}/{NAME}{number:06d}"

    def _numbers(self) -> list[int]:
        """Numbers of the objects, growing."""
        self._files.invalidate_cache()
        names = (path.rpartition("/")[2] for path in self._files.find(self._root, maxdepth=1))
        found = (name.removeprefix(NAME) for name in names if name.startswith(NAME))
        return sorted(int(number) for number in found if number.isdecimal())

    def _content(self, *, released: bool = False) -> bytes:
        self._count += 1
        holder = f"process {os.getpid()} of {platform.node()}"
        content = {"holder": holder, "count": self._count, "released": released}
        return json.dumps(content).encode()

    def _is_conditional(self) -> bool:
        """Whether the store refuses to create the object of the lock, which exists, again."""
        try:
            self._files.pipe_file(self._path(self._number), self._content(), mode="create")
        except FileExistsError:
            return True
        return False

    def _read(self, number: int) -> dict[str, Any] | None:
        try:
            return json.loads(self._files.cat_file(self._path(number)))
        except FileNotFoundError:
            return None

    def _wait_for_end_of(self, number: int, say: Callable[[str], None]) -> None:
        """Return when the holder has released the lock or ended."""
        content = self._read(number)
        if content is None or content["released"]:
            return
        say(
            f"{self._url}: found a lock of {content['holder']}: waiting {LEASE * BEAT:g} s whether "
            "it lives"
        )
        for _ in range(2 * LEASE):
            time.sleep(0.5 * BEAT)
            now = self._read(number)
            if now is None or now["released"]:
                return
            if now["count"] != content["count"]:
                raise self._refusal()

    def _beat(self) -> None:
        while not self._ended.wait(BEAT):
            try:
                self.is_lost = self._numbers()[-1] != self._number
                if self.is_lost:
                    return
                self._files.pipe_file(self._path(self._number), self._content())
            except Exception:  # a store that does not answer now may do so later
                continue

    def _remove(self, number: int) -> None:
        try:
            self._files.rm_file(self._path(number))
        except FileNotFoundError:
            return

    def _refusal(self) -> InputError:
        return InputError(f"{self._url}: found another campaign running here, expected none")
