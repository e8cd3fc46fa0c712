"""Words of the inputs that a C module reads and uses."""

import re
from collections import Counter

_READS = re.compile(
    r"^ *(?:(?:const \w+|COMMON\(\w+,) (?P<name>v\d+))?.*?(?:SHARED|OWN|_words)\(.*$", re.MULTILINE
)
_SHARED = re.compile(r"\bSHARED\((\d+)|_words\(shared, (\d+)")
_OWN = re.compile(r"\bOWN\(\w+, (\d+)|_words\(own, (\d+)")


def words_read(text: str) -> tuple[set[int], set[int]]:
    """Words that the runs share, and words of a run, that a module reads and uses.

    A module declares every parameter, also those that it does not use. Of a table that is read at a
    computed index, the word is the first.

    Args:
        text: Text of the module; see `gyrostat.codegen.simd.module`.
    """
    counts = Counter(re.findall(r"\bv\d+\b", text))
    words: tuple[set[int], set[int]] = set(), set()
    for line in _READS.finditer(text):
        if line["name"] and counts[line["name"]] == 1:
            continue
        for pattern, read in zip((_SHARED, _OWN), words, strict=True):
            read |= {int(place[1] or place[2]) for place in pattern.finditer(line[0])}
    return words
