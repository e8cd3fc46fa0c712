"""The claims of every paper against those that docs/claims.md publishes."""

import pytest

from gyrostat.papers import PAPERS


@pytest.mark.parametrize("paper", PAPERS)
def test_published_ids_are_those_of_the_rows(paper, published):
    assert list(published[paper]) == [row.id for row in PAPERS[paper].rows]


@pytest.mark.parametrize("paper", PAPERS)
def test_every_row_is_whole(paper):
    for row in PAPERS[paper].rows:
        assert row.quantity
        assert row.why.endswith((".", "}"))
        assert "{" not in row.quantity or not row.full
        assert (row.paper is None) == (not row.source)
        number = row.paper is not None and not isinstance(row.paper, bool)
        assert (row.tolerance is not None) == number
