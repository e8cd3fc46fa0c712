"""The verdict rule, and how rows, values and facts are joined and shown."""

import json
import math

import pytest
from matplotlib.figure import Figure

from gyrostat.core.errors import InputError
from gyrostat.papers import PAPERS, Claim, Drawing, Paper, Part, Row, Run, paper_named


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


@pytest.mark.parametrize(
    ("ours", "verdict"), [(1.4, "calibrated"), (1.6, "not-reproduced"), (None, "not-testable")]
)
def test_agreement_by_a_setting_chosen_for_it_is_calibrated(ours, verdict):
    (found,) = reproduction({"a": ours}, row("a", paper=1.0, tolerance=0.5, calibrated=True)).claims
    assert found.verdict == verdict


def test_a_value_shown_not_to_exist_is_infeasible():
    full, quick = row("a", infeasible=True), row("b", infeasible=True, full=True)
    assert [c.verdict for c in reproduction({"a": None, "b": 1.0}, full, quick).claims] == [
        "infeasible",
        "ours-only",
    ]
    # a quick run has shown nothing
    assert reproduction({"a": 2.0}, full, quick, quick=True).claims[1].verdict == "not-testable"


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


def row(name, **fields):
    return Row(name, "q", **{"why": "w.", "unit": "s", **fields})


def reproduction(values, *rows, quick=False, facts=None):
    figure = Figure()
    figure.subplots().plot([0.0, 1.0])
    paper = Paper("a-paper", "An author, a title", ("a setting",), rows, ())
    drawing = Drawing("a title", figure, "a caption")
    return paper.judged([Part(values), Part({}, facts or {}, (drawing,))], quick=quick)


def test_values_are_joined_with_rows_in_the_order_of_the_paper():
    rows = row("b"), row("a", testable=False), row("c", paper=2.0, tolerance=0.1)
    result = reproduction({"c": 1.0, "b": 1.0}, *rows)
    content = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    assert list(content) == ["paper", "claims"]
    assert [row["id"] for row in content["claims"]] == ["b", "a", "c"]
    assert result.counts() == {
        "reproduced": 0,
        "not-reproduced": 1,
        "calibrated": 0,
        "infeasible": 0,
        "not-testable": 1,
        "ours-only": 1,
    }


def test_a_statement_needs_no_tolerance():
    (found,) = reproduction({"a": True}, row("a", paper=True)).claims
    assert (found.tolerance, found.verdict) == (0.0, "reproduced")


def test_an_id_used_twice_is_refused():
    with pytest.raises(ValueError, match="the id b 2 times"):
        reproduction({"b": 1.0}, row("b"), row("b"))


@pytest.mark.parametrize(
    ("values", "message"), [({}, "no value of b"), ({"b": 1.0, "c": 1.0}, "without a row of c")]
)
def test_values_and_rows_must_agree(values, message):
    with pytest.raises(ValueError, match=message):
        reproduction(values, row("b"))


def test_facts_fill_quantity_and_reason():
    (found,) = reproduction(
        {"a": 1.0}, row("a", why="{x[k]:.1f} of {n}."), facts={"x": {"k": 0.25}, "n": 3}
    ).claims
    assert found.why == "0.2 of 3."


@pytest.mark.parametrize(
    ("value", "limits", "says"),
    [
        (0.5, {"at_most": 0.5}, "at most 0.5 s; met"),
        (0.6, {"at_most": 0.5}, "at most 0.5 s; not met"),
        (None, {"at_most": 0.5}, "at most 0.5 s; not met"),
        (1.0, {"at_least": 1.0}, "at least 1 s; met"),
        (0.9, {"at_least": 1.0}, "at least 1 s; not met"),
    ],
)
def test_a_requirement_is_met_or_not(value, limits, says):
    (found,) = reproduction({"a": value}, row("a", **limits)).claims
    assert found.why == f"w. Required beforehand: {says}."


def test_a_quick_run_leaves_out_what_only_the_full_one_computes():
    rows = row("a"), row("b", full=True, why="{missing}")
    first, second = reproduction({"a": 1.0}, *rows, quick=True).claims
    assert first.ours == 1.0
    assert second.verdict == "not-testable"
    assert "Not computed" in second.why
    with pytest.raises(ValueError, match="no value of b"):
        reproduction({"a": 1.0}, *rows)


def test_experiments_share_what_is_computed_once():
    calls = []

    def costly(run):
        calls.append(run)
        return 2.0

    def experiment(name):
        return lambda run: Part({name: run.once(costly)})

    paper = Paper("p", "c", (), (row("a"), row("b")), (experiment("a"),), (experiment("b"),))
    told = []
    assert [claim.ours for claim in paper.reproduce(quick=False, say=told.append).claims] == [2, 2]
    assert len(calls) == 1
    run = Run(True, told.append)
    assert run.once(costly) is run.once(costly)


def test_a_page_shows_everything_and_fetches_nothing():
    rows = row("b", unit=""), row("<c>", paper=2e-5, tolerance=1e-5, source="Fig. 7")
    page = reproduction({"b": True, "<c>": 1e-5}, *rows).page(command="gyrostat reproduce a-paper")
    for text in (
        "An author, a title",
        "a setting",
        "a title",
        "a caption",
        "1e-05",
        "yes",
        "Fig. 7",
    ):
        assert text in page
    assert "<svg" in page
    assert "&lt;c&gt;" in page
    assert "<c>" not in page
    assert "Quick" not in page
    assert 'src="http' not in page
    assert 'href="http' not in page


def test_a_short_run_says_so():
    result = reproduction({"a": 1.0}, row("a"), quick=True)
    assert "Quick" in result.page(command="")
    assert result.lines()[-1].startswith("quick")
    assert not reproduction({"a": 1.0}, row("a")).lines()[-1].startswith("quick")


def test_lines_name_every_claim_with_its_verdict():
    rows = row("b"), row("a", paper=True, testable=False)
    lines = reproduction({"b": 1.0}, *rows).lines()
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
