"""The folder of a campaign: what it is, a file for each block of runs, the table of all.

campaign.json               what is flown, how often, by what
blocks/000012.<digest>.parquet   one block; its name holds the checksum of its content
runs.parquet                every run, once all blocks are there
runs/run_004711.nc          histories that were kept
"""

import contextlib
import fcntl
import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.errors import InputError
from gyrostat.files import whole_file, write_whole

if TYPE_CHECKING:
    import pyarrow as pa

    from gyrostat._types import Vector

FORMAT = 1
GROUP = 64
"""Blocks in one row group of the table: what is in memory while it is written."""
_BLOCK = re.compile(r"(\d{6,})\.([0-9a-f]{64})\.parquet")
# what a killed process has not finished: names as `gyrostat.files.whole_file` gives them
_UNFINISHED = ("blocks/.????????.parquet", "runs/.????????.nc", ".????????.parquet")


@dataclass(frozen=True)
class Campaign:
    """What a campaign is; the same in every process that works at it.

    Attributes:
        scenario: text of the scenario.
        digest: of the scenario.
        seed: of the draws.
        runs: their number.
        block: runs in a block.
        engine: see `gyrostat.campaign.engine_record`.
    """

    scenario: str
    digest: str
    seed: int
    runs: int
    block: int
    engine: Mapping[str, str]

    def numbers(self, block: int) -> range:
        """The runs of a block."""
        return range(block * self.block, min((block + 1) * self.block, self.runs))

    @property
    def blocks(self) -> int:
        """Their number."""
        return -(-self.runs // self.block)


class Store:
    """A campaign's folder.

    Args:
        folder: that may not exist yet.
    """

    def __init__(self, folder: Path):
        self.folder = folder
        self.table = folder / "runs.parquet"
        self._manifest = folder / "campaign.json"
        self._blocks = folder / "blocks"

    @contextlib.contextmanager
    def locked(self) -> Iterator[None]:
        """Alone at work in the folder, until the process ends however it ends.

        Raises:
            InputError: another campaign runs in it, or it cannot be written.
        """
        try:
            self._blocks.mkdir(parents=True, exist_ok=True)
            handle = (self.folder / ".lock").open("w")
        except OSError as error:
            raise InputError(
                f"{self.folder}: found no way to write ({error.strerror}), expected a writable "
                "folder"
            ) from None
        with handle:
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise InputError(
                    f"{self.folder}: found another campaign at work here, expected none"
                ) from None
            for pattern in _UNFINISHED:
                for left in self.folder.glob(pattern):
                    left.unlink()
            yield

    def read(self) -> Campaign | None:
        """The campaign of the folder; None where there is none yet.

        Raises:
            InputError: there is a manifest that is none.
        """
        try:
            content = json.loads(self._manifest.read_text(encoding="utf-8"))
            if content.pop("format") != FORMAT:
                raise ValueError("another format")
            return Campaign(**content)
        except FileNotFoundError:
            return None
        except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
            raise InputError(
                f"{self._manifest}: found {type(error).__name__} ({error}), expected what "
                "gyrostat campaign has written"
            ) from None

    def begin(self, campaign: Campaign) -> Campaign:
        """Take a new campaign in, or the one that is there, which must be the same.

        Returns:
            The campaign of the folder, whose engine and size of blocks hold.

        Raises:
            InputError: another campaign is there.
        """
        known = self.read()
        if known is None:
            if self.table.exists() or any(self._blocks.iterdir()):
                raise InputError(
                    f"{self.folder}: found results without campaign.json, expected none: give "
                    "another folder"
                )
            content = {"format": FORMAT, **asdict(campaign)}
            write_whole(self._manifest, json.dumps(content, ensure_ascii=False, indent=1) + "\n")
            return campaign
        for name, label in (("digest", "scenario"), ("seed", "seed"), ("runs", "number of runs")):
            found, wanted = getattr(campaign, name), getattr(known, name)
            if found != wanted:
                raise InputError(
                    f"{self.folder}: found a campaign with another {label}, {wanted}, expected "
                    f"{found}: give another folder"
                )
        return known

    def write_block(self, number: int, columns: Mapping[str, "Vector"]) -> None:
        """Keep a block.

        Raises:
            InputError: it cannot be written.
        """
        import io

        import pyarrow as pa
        import pyarrow.parquet as pq

        buffer = io.BytesIO()
        pq.write_table(pa.table(dict(columns)), buffer)
        content = buffer.getvalue()
        name = f"{number:06d}.{hashlib.sha256(content).hexdigest()}.parquet"
        with whole_file(self._blocks / name) as unfinished:
            unfinished.write_bytes(content)

    def blocks(self) -> tuple[dict[int, Path], list[int]]:
        """The blocks that are whole, by number, and the numbers of those that were not.

        What is not whole is removed; files of another kind are left alone.
        """
        found: dict[int, Path] = {}
        broken: list[int] = []
        for path in sorted(self._blocks.iterdir()):
            match = _BLOCK.fullmatch(path.name)
            if match and hashlib.sha256(path.read_bytes()).hexdigest() == match[2]:
                found[int(match[1])] = path
            elif match:
                path.unlink()
                broken.append(int(match[1]))
        return found, broken

    def merge(self, campaign: Campaign) -> None:
        """Write the table of every run, in their order.

        Raises:
            InputError: it cannot be written.
        """
        import pyarrow as pa
        import pyarrow.parquet as pq

        found, _ = self.blocks()
        numbers = range(campaign.blocks)
        with whole_file(self.table) as unfinished:
            schema = pq.read_schema(found[0])
            with pq.ParquetWriter(unfinished, schema) as writer:
                for first in range(0, len(numbers), GROUP):
                    group = [pq.read_table(found[k]) for k in numbers[first : first + GROUP]]
                    writer.write_table(pa.concat_tables(group).combine_chunks())

    def read_table(self) -> "pa.Table":
        """Every run.

        Raises:
            InputError: there is no table, or it is none.
        """
        import pyarrow as pa
        import pyarrow.parquet as pq

        try:
            return pq.read_table(self.table)
        except (OSError, pa.ArrowInvalid) as error:
            found = "no such file" if isinstance(error, FileNotFoundError) else str(error)
            raise InputError(
                f"{self.table}: found {found}, expected the table of a finished campaign"
            ) from None

    def history(self, run: int) -> Path:
        """Where the history of a run is kept."""
        return self.folder / "runs" / f"run_{run:06d}.nc"

    def write_history(self, run: int, dataset: Any) -> Path:
        """Keep the history of a run.

        Raises:
            InputError: it cannot be written.
        """
        path = self.history(run)
        with whole_file(path) as unfinished:
            dataset.to_netcdf(unfinished, engine="h5netcdf")
        return path
