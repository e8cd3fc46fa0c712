"""The verdict rule, and how a reproduction joins and shows its claims."""

import json
import math

import pytest
from matplotlib.figure import Figure

from gyrostat.errors import InputError
from gyrostat.papers import PAPERS, Claim, Drawing, Part, Reproduction, paper_named


def claim(ours, paper=None, tolerance=None, *, name="a.claim"):
    return Claim(
        id=name, quantity="q", ours=ours, unit="s", why="w", paper=paper, tolerance=tolerance
    )


@pytest.mark.parametrize(
    ("ours", "paper", "tolerance", "verdict"),
    [
        (1.5, 1.0, 0.5, "reproduced"),
        (0.5, 1.0, 0.5, "reproduced"),
        (1.5000001, 1.0, 0.5, "not-reproduced"),
        (0.4999999, 1.0, 0.5, "not-reproduced"),
        (-1.0, 1.0, 0.5, "not-reproduced"),
        (0.0, 0.0, 0.0, "reproduced"),
        (1e-300, 0.0, 0.0, "not-reproduced"),
        (True, True, 0.0, "reproduced"),
        (False, False, 0.0, "reproduced"),
        (False, True, 0.0, "not-reproduced"),
        (True, False, 0.0, "not-reproduced"),
        (0.0, None, None, "ours-only"),
        (False, None, None, "ours-only"),
        (1.0, None, 1.0, "ours-only"),
        (None, 1.0, 10.0, "not-testable"),
        (None, 0.0, 10.0, "not-testable"),
        (None, True, 1.0, "not-testable"),
        (None, None, None, "not-testable"),
    ],
)
def test_one_rule_gives_the_verdict(ours, paper, tolerance, verdict):
    assert claim(ours, paper, tolerance).verdict == verdict


@pytest.mark.parametrize("paper", [None, 0.0, 1.0, True, False])
@pytest.mark.parametrize("tolerance", [None, 0.0, 1e300])
def test_nothing_of_ours_is_never_reproduced(paper, tolerance):
    assert claim(None, paper, tolerance).verdict == "not-testable"


@pytest.mark.parametrize(
    ("ours", "paper", "tolerance"),
    [
        (math.nan, None, None),
        (math.inf, 1.0, 1.0),
        (1.0, math.nan, 1.0),
        (1.0, 1.0, math.inf),
        (1.0, 1.0, None),
        (1.0, 1.0, -0.1),
        (True, 1.0, 0.0),
        (1.0, True, 0.0),
    ],
)
def test_what_no_rule_can_judge_is_refused(ours, paper, tolerance):
    with pytest.raises(ValueError, match=r"a\.claim"):
        claim(ours, paper, tolerance)


def test_a_claim_is_one_row_of_claims_json():
    row = claim(1.5, 1.0, 0.5).to_dict()
    assert row == {
        "id": "a.claim",
        "quantity": "q",
        "paper": 1.0,
        "ours": 1.5,
        "unit": "s",
        "tolerance": 0.5,
        "verdict": "reproduced",
        "why": "w",
    }
    assert list(row) == ["id", "quantity", "paper", "ours", "unit", "tolerance", "verdict", "why"]


def reproduction(*claims, complete=True):
    figure = Figure()
    figure.subplots().plot([0.0, 1.0])
    parts = (
        Part(claims[:1], settings=("a setting",)),
        Part(claims[1:], drawings=(Drawing("a title", figure, "a caption"),)),
    )
    return Reproduction("a-paper", "An author, a title", parts, complete)


def test_parts_are_joined_in_order():
    result = reproduction(claim(1.0, name="b"), claim(None, name="a"), claim(1.0, 2.0, 0.1))
    content = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    assert list(content) == ["paper", "claims"]
    assert content["paper"] == "a-paper"
    assert [row["id"] for row in content["claims"]] == ["b", "a", "a.claim"]
    assert result.counts() == {
        "reproduced": 0,
        "not-reproduced": 1,
        "not-testable": 1,
        "ours-only": 1,
    }


def test_an_id_used_twice_is_refused():
    with pytest.raises(ValueError, match="the id b twice"):
        reproduction(claim(1.0, name="b"), claim(2.0, name="b"))


def test_a_page_shows_everything_and_fetches_nothing():
    result = reproduction(claim(True, name="b"), claim(1e-5, 2e-5, 1e-5, name="<c>"))
    page = result.page(command="gyrostat reproduce a-paper")
    for text in ("An author, a title", "a setting", "a title", "a caption", "1e-05", "yes"):
        assert text in page
    assert "<svg" in page
    assert "&lt;c&gt;" in page
    assert "<c>" not in page
    assert "Quick" not in page
    assert 'src="http' not in page
    assert 'href="http' not in page


def test_a_short_run_says_so():
    result = reproduction(claim(1.0), complete=False)
    assert "Quick" in result.page(command="")
    assert result.lines()[-1].startswith("quick")
    assert not reproduction(claim(1.0)).lines()[-1].startswith("quick")


def test_lines_name_every_claim_with_its_verdict():
    lines = reproduction(claim(1.0, name="b"), claim(None, True, name="a")).lines()
    assert [line.split()[0] for line in lines[1:3]] == ["b", "a"]
    assert lines[1].endswith("ours-only")
    assert lines[2].endswith("not-testable")


def test_a_paper_is_found_by_its_name():
    assert paper_named("carrara-kuga") is PAPERS["carrara-kuga"]


@pytest.mark.parametrize("name", ["carara-kuga", "Carrara_Kuga", "carrara"])
def test_a_misspelt_paper_is_guessed(name):
    with pytest.raises(InputError, match=r"did you mean carrara-kuga\?.*expected one of") as error:
        paper_named(name)
    assert repr(name) in str(error.value)


@pytest.mark.parametrize("name", ["", "endo-nonaka-sekiguchi-2", "x"])
def test_an_unknown_paper_is_answered_with_the_known_ones(name):
    with pytest.raises(InputError, match="expected one of carrara-kuga"):
        paper_named(name)
