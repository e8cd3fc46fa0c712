"""Blocks of runs as Parquet files, with a digest in the file name.

000012.<SHA-256 digest of campaign, block number and content>.parquet
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
    """File name and content of a block.

    Args:
        campaign: Campaign of the block.
        number: Number of the block.
        columns: Columns of the table, name -> (runs,).
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
    """File name of a block of a campaign with this number and content."""
    digest = hashlib.sha256(f"{campaign.identity} {number} ".encode() + content).hexdigest()
    return f"{number:06d}.{digest}.parquet"


def number_of(name: str) -> int | None:
    """Number of a block from its file name; None if it is not the name of a block."""
    match = _NAME.fullmatch(name)
    return None if match is None else int(match[1])
