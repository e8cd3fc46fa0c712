"""Source lines of operations."""

import linecache
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from gyrostat.codegen import source


def test_threads_may_look_up_lines_at_the_same_time():
    """The parser of CPython 3.11 fails where two threads are inside it."""
    files = [str(file) for file in sorted(Path(source.__file__).parent.rglob("*.py"))]
    list(map(linecache.getlines, files))
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        with ThreadPoolExecutor(4) as pool:
            found = list(pool.map(source._syntax_tree.__wrapped__, 4 * files))
    finally:
        sys.setswitchinterval(before)
    assert all(tree is not None and tree.body for tree in found)
