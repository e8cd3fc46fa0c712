"""C module for SIMD lanes, from a function of scalars."""

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

    The arguments of its `fly_all` are 64-bit words. Inputs are `shared`, the same for all runs,
    and `own`, (groups, words, lanes). Outputs are the results `made`, in the layout of `own`, and
    the function's rows, table after table, (groups, size, lanes): in `every` for all groups, in
    `asked` only for those groups that have a `place` in it, 0 or above.

    Args:
        function: Root function, the results and rows of which are computed.
        shared: Parameters that are the same for all runs.
        own: Other parameters.
        on_demand: For each row of the function, whether it is returned only when asked for.
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
