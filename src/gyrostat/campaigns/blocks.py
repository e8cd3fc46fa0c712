"""A block of runs as a Parquet file whose name holds the digest of what it belongs to.

000012.<SHA-256 digest of campaign, number and content>.parquet
"""

import hashlib
import io
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

from gyrostat.campaigns.description import Campaign

if TYPE_CHECKING:
    from gyrostat.core.types import Vector

_NAME = re.compile(r"(\d{6,})\.[0-9a-f]{64}\.parquet")


def packed(campaign: Campaign, number: int, columns: Mapping[str, "Vector"]) -> tuple[str, bytes]:
    """Name and content of a block.

    Args:
        campaign: of the block.
        number: of the block.
        columns: name -> (runs,).
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    runs = campaign.numbers(number)
    told = {
        "campaign": campaign.identity,
        "seed": str(campaign.seed),
        "runs": f"{runs.start} to {runs.stop - 1}",
    }
    buffer = io.BytesIO()
    pq.write_table(pa.table(dict(columns)).replace_schema_metadata(told), buffer)
    content = buffer.getvalue()
    return name_of(campaign, number, content), content


def name_of(campaign: Campaign, number: int, content: bytes) -> str:
    """Name of the block of a campaign that has this number and content."""
    digest = hashlib.sha256(f"{campaign.identity} {number} ".encode() + content).hexdigest()
    return f"{number:06d}.{digest}.parquet"


def number_of(name: str) -> int | None:
    """Number of a block by its name; None where no block is called so."""
    match = _NAME.fullmatch(name)
    return None if match is None else int(match[1])
