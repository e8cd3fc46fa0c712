"""Workers of a Dask scheduler as an executor of the standard library.

Each job is given to one worker, and only to workers that have accepted the handshake. Dask would
give a job to any worker that is free, which is soon one that refuses all of them.
"""

import contextlib
import logging
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace

from gyrostat.campaigns.cluster_connection import Connection
from gyrostat.campaigns.cluster_pool import ClusterPool
from gyrostat.campaigns.handshake import Handshake, handshake
from gyrostat.core.errors import InputError
from gyrostat.core.extras import missing
from gyrostat.core.messages import silent


@dataclass(frozen=True)
class Cluster:
    """Opener of the workers of a Dask scheduler.

    Attributes:
        address: Address of the scheduler.
        say: Called with a message about each worker that is refused.
        asked: Handshake with each worker; None for that of JAX without a program.
    """

    address: str
    say: Callable[[str], None] = silent
    asked: Handshake | None = None

    def with_handshake(self, asked: Handshake) -> "Cluster":
        """The same workers, with another handshake."""
        return replace(self, asked=asked)

    @contextlib.contextmanager
    def __call__(self) -> Iterator[Executor]:
        """Connect to the scheduler.

        Raises:
            InputError: There is no scheduler at this address.
        """
        from distributed import Client  # pyright: ignore[reportMissingImports]

        with _quiet():
            try:
                client = Client(self.address, timeout=10, set_as_default=False)
            except (OSError, ValueError) as error:
                raise InputError(
                    f"--scheduler: found no answer from {self.address} ({error}), expected a Dask "
                    "scheduler"
                ) from None
            connection = Connection(client, self.address)
            pool = ClusterPool(connection, self.asked or handshake(), self.say)
            try:
                yield pool
            finally:
                pool.shutdown()
                connection.close()


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Without the messages of Dask: what is lost is reported once, by the pool."""
    names = [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]
    levels = {name: logging.getLogger(name).level for name in names}
    for name in names:
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)


def cluster(address: str, say: Callable[[str], None] = silent) -> Cluster:
    """Create an opener of the workers of a Dask scheduler.

    Args:
        address: Address of the scheduler, such as "tcp://10.0.0.1:8786".
        say: Called with a message about each worker that is refused.

    Raises:
        InputError: Dask is not installed.
    """
    try:
        import distributed  # noqa: F401 # pyright: ignore[reportMissingImports]
    except ImportError:
        raise missing("--scheduler", "dask and distributed", "cluster") from None
    return Cluster(address, say)
