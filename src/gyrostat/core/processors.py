"""Number of processor cores."""

import os


def usable_cores() -> int:
    """Number of cores that this process may use; only Linux tells it apart from all cores."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
