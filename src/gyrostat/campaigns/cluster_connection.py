"""Connection to a Dask scheduler: calls in a chosen worker, results, and the list of workers."""

import contextlib
import pickle
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

FETCH = 60.0
"""Longest time for the transfer of a result, s."""

Result = tuple[Any, Exception | None]
"""Result of a call, and its error."""


class _Call:
    """Call of a function, made when it is unpickled.

    Dask sees bytes only. It ends a worker that cannot unpickle a function, such as one without
    this package, and unpickles in the scheduler too.
    """

    def __init__(self, function: Callable[..., Any], arguments: tuple[Any, ...]):
        self._arguments = function, *arguments

    def __reduce__(self) -> tuple[Callable[..., bytes], tuple[Any, ...]]:
        return _pickled, self._arguments


def _pickled(function: Callable[..., Any], *arguments: Any) -> bytes:
    """Result of a function as bytes: Dask sends each array in a message of its own."""
    import cloudpickle  # pyright: ignore[reportMissingImports]

    return cloudpickle.dumps(function(*arguments))  # of classes of `__main__` too


class Connection:
    """Connection to a Dask scheduler. No method waits: a scheduler that is lost does not answer.

    Args:
        client: Client of Dask.
        address: Address of the scheduler.
    """

    def __init__(self, client: Any, address: str):
        self.address = address
        self._client = client
        self._is_asking = False
        self._fetching = ThreadPoolExecutor(4, thread_name_prefix="gyrostat-results")

    @property
    def is_closed(self) -> bool:
        """Whether the scheduler was given up."""
        return self._client.status in ("closed", "closing")

    @property
    def is_broken(self) -> bool:
        """Whether the connection has ended; Dask may try to restore it."""
        return self._client.status != "running"

    def close(self) -> None:
        """Close the connection."""
        self._fetching.shutdown(wait=False, cancel_futures=True)
        with contextlib.suppress(OSError, TimeoutError):
            self._client.close(timeout=5)

    def send(self, address: str, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a function in a worker; returns a future of Dask."""
        import cloudpickle  # pyright: ignore[reportMissingImports]

        content = cloudpickle.dumps(_Call(function, arguments))
        options = {"workers": [address], "allow_other_workers": False, "pure": False}
        return self._client.submit(pickle.loads, content, **options)

    def when_done(self, call: Any, take: Callable[[Result], None]) -> None:
        """Fetch a result in a thread: it does not come if its worker is lost meanwhile.

        Args:
            call: Future of Dask.
            take: Called with the result.
        """

        def fetch() -> None:
            try:
                result: Result = pickle.loads(call.result(timeout=FETCH)), None
            except Exception as error:
                result = None, error
            take(result)

        def begin(_: Any) -> None:
            with contextlib.suppress(RuntimeError):  # closed
                self._fetching.submit(fetch)

        call.add_done_callback(begin)

    def cancel(self, calls: Iterable[Any]) -> None:
        """Cancel calls whose results are not needed."""
        calls = [*calls]

        def cancel() -> None:
            with contextlib.suppress(Exception):
                self._client.cancel(calls)

        if calls:
            threading.Thread(target=cancel, daemon=True).start()

    def ask_for_workers(self, take: Callable[[dict[str, int]], None]) -> None:
        """Ask the scheduler for its workers, unless an answer is awaited.

        Args:
            take: Called with address -> number of threads.
        """

        def ask() -> None:
            with contextlib.suppress(Exception):
                take(dict(self._client.nthreads()))
            self._is_asking = False

        if not self._is_asking:
            self._is_asking = True
            threading.Thread(target=ask, daemon=True).start()


def is_lost(error: Exception) -> bool:
    """Whether an error of a job means that its worker, or its result, was lost."""
    names = ("KilledWorker", "FutureCancelledError", "CancelledError", "TimeoutError")
    return type(error).__name__ in names or isinstance(error, OSError)
