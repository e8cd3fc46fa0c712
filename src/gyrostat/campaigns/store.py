"""Folder of a campaign: manifest, blocks of runs, table of all runs, histories.

campaign.json                    scenario, seed, engine; with a digest of its content
blocks/000012.<digest>.parquet   one block; digest of campaign, block number and content
runs.parquet                     table of all runs, written after the last block
report.html, report.json         report
runs/run_004711.nc, .html        kept histories, pages of replayed runs
.gyrostat.json                   digests of the last three kinds of files: `gyrostat.core.outputs`

The digests detect damage; they do not protect against deliberate changes.
"""

import contextlib
import os
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from gyrostat.campaigns.blocks import name_of, number_of, packed, scalar_columns, table_at
from gyrostat.campaigns.description import Campaign, DamagedError, read_campaign, refuse_different
from gyrostat.campaigns.run_table import RunTable
from gyrostat.core.errors import InputError
from gyrostat.core.files import (
    UNFINISHED,
    lock,
    read_regular,
    set_aside,
    unwritable,
    whole_file,
    write_whole,
)
from gyrostat.core.outputs import Manifest, check_outputs, new_files

if TYPE_CHECKING:
    import pyarrow as pa
    import pyarrow.parquet as pq

    from gyrostat.core.types import Vector
    from gyrostat.simulation.labelled import Labelled

GROUP, GROUP_RUNS = 64, 65_536
"""Largest numbers of blocks and of runs in a row group of the table, which is in memory at once."""
TABLE = "runs.parquet"
REPORT = ("report.html", "report.json")
_RESULT = re.compile(r"runs\.parquet|report\.(?:html|json)|runs/run_(\d{6,})\.(nc|html)")


class Store:
    """Folder of a campaign.

    Args:
        folder: Path of the folder; it need not exist.
        say: Called with a message about each damaged file.
    """

    def __init__(self, folder: Path, say: Callable[[str], None] = lambda text: None):
        self.folder = folder
        self.table = folder / TABLE
        self.say = say
        self._description = folder / "campaign.json"
        self._blocks = folder / "blocks"

    @contextlib.contextmanager
    def locked(self) -> Iterator[None]:
        """Lock the folder; the lock is released at the latest when the process ends.

        Raises:
            InputError: Another campaign runs in the folder, or it cannot be written.
        """
        try:
            for part in (self._blocks, self.folder / "runs"):
                if part.is_symlink():
                    raise InputError(f"{part}: found a symbolic link, expected a folder")
                part.mkdir(parents=True, exist_ok=True)
            flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW
            handle = os.open(self.folder / ".lock", flags, 0o666)
        except OSError as error:
            raise unwritable(self.folder, error) from None
        try:
            lock(handle, f"{self.folder}: found another campaign running here, expected none")
            # remove unfinished files of a killed process
            for folder in (self.folder, self._blocks):
                for file in folder.glob(f"{UNFINISHED}*.*"):
                    if file.is_file():
                        file.unlink()
            yield
        finally:
            os.close(handle)

    def read(self) -> Campaign | None:
        """Campaign stored in the folder, or None; see `read_campaign`."""
        return read_campaign(self._description)

    def known(self) -> Campaign:
        """Campaign of the folder, which must exist.

        Raises:
            InputError: There is none, or campaign.json is damaged.
        """
        campaign = self.read()
        if campaign is not None:
            return campaign
        raise InputError(f"{self.folder}: found no campaign.json, expected a campaign's folder")

    def begin(self, campaign: Campaign, *, force: bool = False) -> Campaign:
        """Start a new campaign, or resume the campaign of the folder, which must be the same.

        A damaged or missing campaign.json is written again if blocks or results in the folder
        belong to the campaign.

        Args:
            campaign: Requested campaign.
            force: Whether to start in a folder with files that have the names of results.

        Returns:
            The campaign of the folder; its engine and block size are used.

        Raises:
            InputError: The folder has another campaign or files of unknown origin.
        """
        damage: DamagedError | None = None
        try:
            existing = self.read()
        except DamagedError as error:
            existing, damage = None, error
        if existing is None:
            self._restore(campaign, damage, force)
            return campaign
        refuse_different(existing, campaign, self.folder)
        return existing

    def _restore(self, campaign: Campaign, damage: DamagedError | None, force: bool) -> None:
        listed = Manifest(self.folder).entries.values()
        is_its = any(entry.by == campaign.by for entry in listed) or self.blocks(campaign)[0]
        if is_its:
            self.say(f"{self._description}: found no valid file: it is written again")
        elif damage is not None:
            raise damage
        elif os.path.lexists(self.table) or any(self._blocks.iterdir()):
            raise InputError(
                f"{self.folder}: found results without their campaign.json, expected none: give "
                "another folder, or repeat the command that started that campaign"
            )
        else:
            check_outputs(self.folder, REPORT, by=campaign.by, force=force)
        if damage is not None:
            set_aside(self._description)
        write_whole(self._description, campaign.text())

    def check(self, campaign: Campaign) -> set[int]:
        """Rename result files that are damaged or not from this campaign.

        Returns:
            Indices of runs whose kept histories are damaged.
        """
        manifest, damaged = Manifest(self.folder), set()
        for path in sorted((*self.folder.iterdir(), *(self.folder / "runs").iterdir())):
            name = path.relative_to(self.folder).as_posix()
            match = _RESULT.fullmatch(name)
            fault = match and manifest.fault(name, campaign.by)
            if match is None or fault is None:
                continue
            self.say(f"{path}: found {fault}: it is kept as {set_aside(path).name}")
            entry = manifest.entries.get(name)
            if match[2] == "nc" and entry is not None and entry.by == campaign.by:
                damaged.add(int(match[1]))
        return damaged

    def mend(self, campaign: Campaign) -> None:
        """Check the folder of a finished campaign and repair a damaged table.

        Raises:
            InputError: Table and blocks are damaged.
        """
        self.check(campaign)
        if campaign.search is not None:
            self.read_table()  # only the search itself knows its blocks
            return
        intact, damaged = self.blocks(campaign)
        for number in sorted({*damaged, *range(campaign.blocks)} - set(intact)):
            state = "damaged or of another campaign" if number in damaged else "missing"
            self.say(f"block {number} is {state}: gyrostat campaign simulates it again")
        self.merge(campaign)

    @contextlib.contextmanager
    def results(self, campaign: Campaign) -> Iterator[Path]:
        """Provide a scratch folder for results; see `gyrostat.core.outputs.new_files`.

        Raises:
            InputError: The results cannot be written.
        """
        with new_files(self.folder, by=campaign.by, aside=self.say) as scratch:
            (scratch / "runs").mkdir()
            yield scratch

    def write_block(self, campaign: Campaign, number: int, columns: Mapping[str, "Vector"]) -> None:
        """Write a block.

        Raises:
            InputError: The block cannot be written.
        """
        name, content = packed(campaign, number, columns)
        with whole_file(self._blocks / name) as unfinished:
            unfinished.write_bytes(content)

    def blocks(self, campaign: Campaign) -> tuple[dict[int, Path], dict[int, list[Path]]]:
        """Intact blocks of the campaign by number, and damaged files for other block numbers."""
        intact: dict[int, Path] = {}
        damaged: dict[int, list[Path]] = {}
        for path in sorted(self._blocks.iterdir()):
            number = number_of(path.name)
            if number is None:
                continue
            content = read_regular(path)
            if content is not None and path.name == name_of(campaign, number, content):
                intact[number] = path
            else:
                damaged.setdefault(number, []).append(path)
        return intact, {number: files for number, files in damaged.items() if number not in intact}

    def merge(self, campaign: Campaign, count: int | None = None) -> None:
        """Write the table of all runs, of `count` blocks, in order, unless it exists and is intact.

        Raises:
            InputError: A block is missing, or the table cannot be written.
        """
        import pyarrow as pa
        import pyarrow.parquet as pq

        if Manifest(self.folder).is_own(TABLE, campaign.by):
            return
        intact, _ = self.blocks(campaign)
        numbers = range(count or campaign.blocks)
        if len(intact) < len(numbers):
            raise InputError(
                f"{self.folder}: found {len(intact)} of {len(numbers)} blocks intact and no "
                f"intact {TABLE}, expected all blocks: run gyrostat campaign again to repair it"
            )
        with self.results(campaign) as scratch:
            metadata = {"scenario": campaign.digest, "seed": str(campaign.seed)}
            schema = pq.read_schema(intact[0]).with_metadata(metadata)
            size = max(1, min(GROUP, GROUP_RUNS // campaign.block))
            with pq.ParquetWriter(scratch / TABLE, schema) as writer:
                for first in range(0, len(numbers), size):
                    group = [table_at(intact[k]) for k in numbers[first : first + size]]
                    table = pa.concat_tables(group).combine_chunks()
                    writer.write_table(table.replace_schema_metadata(metadata))
        pa.default_memory_pool().release_unused()

    def read_table(self) -> "pa.Table":
        """Read the columns with one number for each run; see `open_table`."""
        with self.open_table() as file:
            return file.read(scalar_columns(file))

    def columns(self) -> RunTable:
        """Columns of the table with one number for each run, read one by one; see `open_table`."""
        self._require_table()
        return RunTable(self.table)

    def open_table(self) -> "pq.ParquetFile":
        """Open the table of all runs.

        Raises:
            InputError: There is no table, or it is damaged.
        """
        import pyarrow.parquet as pq

        self._require_table()
        return pq.ParquetFile(self.table)

    def _require_table(self) -> None:
        if not Manifest(self.folder).is_own(TABLE, self.known().by):
            what = "found no such file or a damaged one, expected the table of a finished campaign"
            raise InputError(f"{self.table}: {what}")

    def history(self, run: int) -> Path:
        """Path of the history of a run."""
        return self.folder / "runs" / f"run_{run:06d}.nc"

    def histories(self, campaign: Campaign) -> set[int]:
        """Indices of the runs whose histories exist and are intact."""
        manifest = Manifest(self.folder)
        matches = map(_RESULT.fullmatch, manifest.entries)
        return {
            int(match[1])
            for match in matches
            if match and match[2] == "nc" and manifest.is_own(match[0], campaign.by)
        }

    def write_history(self, campaign: Campaign, run: int, history: "Labelled") -> Path:
        """Write the history of a run.

        Raises:
            InputError: The history cannot be written.
        """
        path = self.history(run)
        with self.results(campaign) as scratch:
            history.write(scratch / "runs" / path.name)
        return path
