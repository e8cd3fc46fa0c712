"""Values of integers that are known after lowering."""

import pytest

from gyrostat.codegen.fold_ranges import fold_ranges
from gyrostat.codegen.program import Assign, Function, Name, Number


@pytest.mark.parametrize("order", [1, -1])
def test_a_sum_of_indices_drops_a_term_that_is_found_to_be_zero(order):
    chosen, place, total = Name("index"), Name("index"), Name("index")
    flag = Name("logical")
    zero, one = Number("index", 0), Number("index", 1)
    body = [
        Assign(chosen, "select", (flag, zero, zero)),
        Assign(total, "add", (chosen, place)[::order]),
        Assign(further := Name("index"), "add", (total, one)[::order]),
    ]
    function = Function("f", [flag, place], body, [total, further])
    fold_ranges(function)
    assert function.results == [place, further]
    assert [set(each.operands) for each in function.body if each.target is further] == [
        {place, one}
    ]
