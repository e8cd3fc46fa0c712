"""Parts that depend on the process, the machine or the day are refused; others are not."""

import datetime
import pickle
from operator import ne

import jax
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrostat.codegen.comparison import difference_of, outline_of
from gyrostat.core.errors import InputError
from gyrostat.core.user_modules import Source
from gyrostat.reports.write import check_law_files
from gyrostat.runs.user import elsewhere, unordered
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.wheel.friction_laws import friction_law
from tests.runs.controller_text import source

TABLE = "S = {'roll', 'pitch', 'yaw'}\nINERTIA = {'roll': 1.0, 'pitch': 2.0, 'yaw': 3.0}"
REFUSED = {
    "order of a set": (TABLE, "INERTIA[next(iter(S))]"),
    "hash": ("", "hash('left') % 2"),
    "day": ("from datetime import date", "date.today().toordinal()"),
    "host": ("import socket", "len(socket.gethostname() + '-')"),
}
EQUAL = (
    TABLE + "\nimport datetime, math, os.path, sys, time\nEPOCH = datetime.datetime(2026, 11, 24)"
    # in a trace, it would be computed by operations
    "\nARRAY = jnp.full(4, 1.0) / 3.0",
    "ARRAY[0] * sum(INERTIA[k] for k in sorted(S)) * ('yaw' in S) * len(frozenset(S))"
    " * sys.float_info.max_exp"
    " + hash((3, 4)) % 5 + {'a': 1}['a'] * (hash('a') == hash('a'))"
    " + isinstance(EPOCH, datetime.date) + (EPOCH - datetime.datetime(2026, 1, 1)).days"
    " + sum({1.0, 0.1, 1e-17}) + max(set('abc')).count('c') + os.path.sep.count('/')",
)
LAW = """
from gyrostat.wheel.friction import Friction, parameter

SCALE = 1.0 + abs(hash('dry')) % 1000 / 1000.0


class Own(Friction):
    coulomb: float = parameter("torque")

    def torque(self, speed, direction):
        return direction * SCALE * self.coulomb
"""


@pytest.fixture
def read(folder, short):
    """Reads the scenario with a part of this head and value."""

    def with_value(head, value):
        (folder / "own.py").write_text(source(f"w = {value}", below=head))
        return read_scenario(short())

    return with_value


@pytest.mark.parametrize(("head", "value"), REFUSED.values(), ids=REFUSED)
def test_what_only_this_process_tells_is_refused_with_a_line(read, head, value):
    with pytest.raises(InputError, match=r" here and .* in another process, expected") as caught:
        read(head, value)
    message = str(caught.value)
    number = source(f"w = {value}", below=head).splitlines().index(f"        w = {value}") + 2
    assert f"controller own.py:P, line {number}: found `return memory, Command(" in message
    assert "\n" not in message


def test_sets_dates_and_modules_that_change_nothing_are_allowed(read, monkeypatch):
    # as for users: JAX looks for accelerators in the other process, when a part makes an array
    monkeypatch.delenv("JAX_PLATFORMS")
    assert read(*EQUAL).controller == "own.py:P"


def test_a_friction_law_of_one_process_is_refused_before_the_fit(tmp_path):
    (tmp_path / "law.py").write_text(LAW)
    law = friction_law(f"{tmp_path / 'law.py'}:Own")
    with pytest.raises(InputError, match="in another process, expected") as caught:
        check_law_files(law, tmp_path / "out", force=False)
    line = LAW.splitlines().index("        return direction * SCALE * self.coulomb") + 1
    assert f"friction law.py:Own, line {line}: found `return direction" in str(caught.value)


def test_the_same_texts_and_trace_are_compared_once(tmp_path, monkeypatch):
    monkeypatch.setenv("GYROSTAT_CACHE", str(tmp_path))
    sources = (Source("law.py", LAW.replace("hash('dry')", "len({'dry'})")),)
    elsewhere.check_law_elsewhere("law.py:Own", sources)

    def not_again(*args, **kwargs):
        raise AssertionError(args)

    monkeypatch.setattr(elsewhere.subprocess, "run", not_again)
    elsewhere.check_law_elsewhere("law.py:Own", sources)
    other = (Source("law.py", sources[0].text.replace("1000.0", "1001.0")),)
    with pytest.raises(InputError, match="AssertionError"):
        elsewhere.check_law_elsewhere("law.py:Own", other)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x = {1, 2}", True),
        ("x = {k for k in y}", True),
        ("x = set(y)", True),
        ("import os.path as p", True),
        ("from datetime import date", True),
        ("def f():\n    return id(3)", True),
        ("x = {'a': 1}", False),
        ("import numpy as np\nfrom .os import f", False),
        ("from ossify import set_up", False),
    ],
)
def test_a_second_process_is_asked_only_where_it_can_differ(text, expected):
    assert elsewhere.depends_on_process(Source("own.py", text)) is expected
    assert not elsewhere.depends_on_process(Source("own.csv", text))


@pytest.mark.parametrize("kind", [set, frozenset])
@given(texts=st.lists(st.text(max_size=3), max_size=20))
def test_each_text_of_a_set_is_in_another_place_in_each_turn(kind, texts):
    """Whatever the order is here, it agrees with one turn at most in any place."""
    plain = kind(texts)
    first, second = (unordered.unordered(turn, kind, texts) for turn in (0, 1))
    assert first == second == plain
    assert isinstance(first, kind)
    for one, two, other in (
        (first, second, plain),
        (first | {"yaw"}, second | {"yaw"}, plain | {"yaw"}),
        (first - {""}, second - {""}, plain - {""}),
        (first.union(first), second.union(second), plain),
        (first.union("ab").difference("b"), second.union("ab").difference("b"), None),
        (kind(first), kind(second), plain),
    ):
        assert one == two
        assert other is None or one == other
        if type(one) is not kind:  # the last one is made by Python itself
            assert len(one) < 2 or all(map(ne, one, two))


@given(texts=st.lists(st.text("abcdefgh", min_size=1), min_size=2, max_size=9, unique=True))
def test_the_sets_of_a_module_differ_from_turn_to_turn(texts):
    """Python fills a display of three constants or more in an order of its own."""
    display = f"{{{', '.join(map(repr, texts))}}}"
    lines = f"S = {display}", f"T = {{t + '!' for t in {texts!r}}}", f"U = frozenset({texts!r})"
    module = Source("own.py", "\n".join((*lines, "V = set(S)", "N = {1, 9, 17, 2.5}")))
    here, first, second = {}, {}, {}
    for turn, names in enumerate((first, second)):
        exec(unordered.without_order(module, turn).text, names)
    exec(module.text, here)
    for name in "STUV":
        assert here[name] == first[name] == second[name]
        assert all(map(ne, first[name], second[name]))
    assert [*first["N"]] == [*second["N"]] == [*here["N"]]


def test_sets_that_grow_and_sets_of_numbers():
    made = [unordered.unordered(turn, set) for turn in (0, 1)]
    for text in ("roll", "pitch", "yaw"):
        for each in made:
            each.add(text)
    assert [*made[0]] == ["pitch", "roll", "yaw"]
    assert [*made[1]] == ["roll", "yaw", "pitch"]
    assert made[1].pop() == "roll"
    assert made[1] == {"pitch", "yaw"}
    assert [*unordered.unordered(1, set, (3, 1, 2.5))] == [*{3, 1, 2.5}]
    assert unordered.unordered(1, dict, [("a", 1)]) == {"a": 1}


def test_hashes_and_identities_are_others_but_for_numbers():
    entry = object()
    for kind, value in ((hash, "left"), (hash, ("left", 1)), (hash, entry), (id, entry), (id, 1)):
        assert unordered.unordered(0, kind, value) == kind(value) + 1
    for value in (1, 2.5, True, (1, (2.0, 3))):
        assert unordered.unordered(0, hash, value) == hash(value)


def test_dates_elsewhere_are_those_of_python(monkeypatch):
    assert isinstance(datetime.datetime(2026, 1, 1), elsewhere._Date)
    assert isinstance(datetime.date(2026, 1, 1), elsewhere._Date)
    assert not isinstance(datetime.date(2026, 1, 1), elsewhere._DateTime)
    monkeypatch.setattr(elsewhere.time, "time", lambda: 0.0)
    assert elsewhere._Date.today() == datetime.date.fromtimestamp(0.0)
    assert elsewhere._DateTime.utcnow() == datetime.datetime(1970, 1, 1)
    assert elsewhere._DateTime.now(datetime.UTC).timestamp() == 0.0


def test_an_outline_is_the_same_after_a_pickle_and_differs_where_a_constant_does():
    def traced(table):
        inner = jax.jit(lambda x: jax.lax.cond(x[0] > 0.0, lambda: x * table, lambda: x))
        return jax.make_jaxpr(lambda x: inner(x) + inner(2.0 * x))(np.ones(3))

    table = np.arange(3.0)
    sent = pickle.loads(pickle.dumps(outline_of(traced(table), equations=False)))
    assert difference_of(outline_of(traced(table)), sent) is None
    found = difference_of(outline_of(traced(np.array([0.0, 1.0, 2.0 + 1e-15]))), sent)
    assert found is not None
    assert found.other == "0.0, 1.0, 2.0"
    assert found.equation.primitive.name == "cond"
