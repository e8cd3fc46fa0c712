"""Description of a campaign, stored as campaign.json with a digest of its content."""

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.files import read_regular

FORMAT = 2
LABELS = {"digest": "scenario", "seed": "seed", "search": "search", "runs": "number of runs"}
"""Attributes that identify a campaign in its folder, and their names in messages."""


class DamagedError(InputError):
    """Damaged campaign.json: its content differs from what was written."""


@dataclass(frozen=True)
class Campaign:
    """Description of a campaign, identical in all its processes.

    Attributes:
        scenario: Text of the scenario.
        digest: Digest of the scenario.
        seed: Seed of the draws.
        runs: Number of runs.
        block: Number of runs in a block.
        engine: Fingerprint of the engine, see `gyrostat.runs.fingerprint`.
        search: Options of a search, whose runs are not independent; None for a campaign. `runs` is
            the largest number of its runs.
    """

    scenario: str
    digest: str
    seed: int
    runs: int
    block: int
    engine: Mapping[str, str]
    search: Mapping[str, Any] | None = None

    @cached_property
    def identity(self) -> str:
        """SHA-256 digest of all attributes; it identifies the campaign."""
        content = json.dumps({"format": FORMAT, **self._content()}, sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()

    @property
    def by(self) -> str:
        """Name of the campaign in the manifest of its folder; see `gyrostat.core.outputs`."""
        return f"campaign {self.identity}"

    def text(self) -> str:
        """Content of campaign.json."""
        content = {"format": FORMAT, **self._content(), "sha256": self.identity}
        return json.dumps(content, ensure_ascii=False, indent=1) + "\n"

    def _content(self) -> dict[str, Any]:
        """Attributes by name; a campaign has none of a search."""
        content = asdict(self)
        if self.search is None:
            del content["search"]
        return content

    def numbers(self, block: int) -> range:
        """Indices of the runs of a block."""
        return range(block * self.block, min((block + 1) * self.block, self.runs))

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return -(-self.runs // self.block)


def read_campaign(file: Path) -> Campaign | None:
    """Read campaign.json.

    Args:
        file: Path of campaign.json.

    Returns:
        The campaign; None if there is no such file.

    Raises:
        DamagedError: The content differs from what was written.
        InputError: Another version of gyrostat wrote it, or it cannot be read.
    """
    if not os.path.lexists(file):
        return None
    data = read_regular(file)
    number: Any = None
    try:
        content: Any = None if data is None else json.loads(data)
        number = content.pop("format")
        del content["sha256"]
        campaign = Campaign(**content)
        if (
            campaign.text().encode() == data
            and hashlib.sha256(campaign.scenario.encode()).hexdigest() == campaign.digest
        ):
            return campaign
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        pass  # refused below
    if isinstance(number, int) and number != FORMAT:
        raise InputError(
            f"{file}: found format {number} of another gyrostat, expected {FORMAT}: run the "
            "campaign again in another folder, or use the version that wrote it"
        )
    raise DamagedError(
        f"{file}: found damaged content (its digest differs), expected the content that gyrostat "
        "campaign wrote: repeat the command that started the campaign to repair it"
    )


def refuse_different(known: Campaign, asked: Campaign, folder: Path) -> None:
    """Validate that the campaign of a folder is the requested one; raises `InputError`."""
    for name, label in LABELS.items():
        expected, found = getattr(asked, name), getattr(known, name)
        if expected != found:
            raise InputError(
                f"{folder}: found a campaign with another {label}, {found}, expected "
                f"{expected}: give another folder"
            )
