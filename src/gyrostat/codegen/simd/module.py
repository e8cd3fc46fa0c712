"""C module for SIMD lanes from a function of scalars."""

from collections.abc import Sequence

from gyrostat.codegen.dependencies import made_from
from gyrostat.codegen.program import Function, Name, Table
from gyrostat.codegen.simd.write import Writer

_TEXT = """\
/* Made by gyrostat from Python, one lane a run. */
#include "lanes.h"

static void fly(const uint64_t *shared, const uint64_t *own, uint64_t *made, uint64_t *every,
    uint64_t *asked)
{{
{body}
}}

int lanes(void) {{ return LANES; }}

void fly_all(int64_t groups, int64_t threads, const uint64_t *shared, const uint64_t *own,
    uint64_t *made, uint64_t *every, uint64_t *asked, const int64_t *place)
{{
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (int64_t group = 0; group < groups; ++group) {{
        WITHOUT_SUBNORMALS(fly(shared, own + group * INT64_C({own_words}) * LANES,
            made + group * INT64_C({made_words}) * LANES,
            every + group * INT64_C({every_words}) * LANES,
            place[group] < 0 ? 0 : asked + place[group] * INT64_C({asked_words}) * LANES))
    }}
}}
"""


def module(
    function: Function, shared: Sequence[Name], own: Sequence[Name], on_demand: Sequence[bool]
) -> str:
    """Text of the C module of a function.

    Its `fly_all` takes 64-bit words: those that all runs share; `own`, (groups, words, lanes);
    gives `made`, alike; gives the function's rows, table after table, (groups, size, lanes):
    those of `every` group; and those of the groups that are `asked` for, whose `place` is from 0.

    Args:
        function: a root: its results and rows are what is made.
        shared: its parameters that are the same for all runs.
        own: its other parameters.
        on_demand: for each of its rows whether it is given where it is asked for alone.
    """
    writer = Writer(made_from(function, own))
    writer.parameters(shared, own)
    words = {"every": 0, "asked": 0}
    places: dict[Table, list[tuple[str, int]]] = {}
    for table, where in zip(function.rows, on_demand, strict=True):
        memory = "asked" if where else "every"
        places.setdefault(table, []).append((memory, words[memory]))
        words[memory] += table.size
    writer.block(function.body, places)
    writer.results(function.results)
    return _TEXT.format(
        body="\n".join(writer.lines),
        every_words=words["every"],
        asked_words=words["asked"],
        own_words=len(own),
        made_words=len(function.results),
    )
