"""Own parts from objects: what runs is the object in memory, or it is refused in one line."""

import math
import sys
from types import ModuleType, SimpleNamespace

import jax.numpy as jnp
import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.reports.write import law_source
from gyrostat.scenario.user.live_calls import compare_live, comparing
from gyrostat.scenario.user.parts import user_part
from gyrostat.scenario_files.python.objects import user_object
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.wheel.friction_laws import loaded_law

SECTION = "environment.torque"
HEAD = "import functools\nimport dataclasses\nimport jax.numpy as jnp\nimport numpy as np\n"
PART = """class P:
    size: float = 1.0

    def __call__(self, spacecraft, attitude, time):
        return jnp.asarray({value}) * self.size * jnp.ones(3)
"""
P = PART.format(value="law()")


@pytest.fixture
def notebook(monkeypatch):
    """Executes cells as a notebook does; a cell that raises an exception ends there."""
    module = ModuleType("__main__")
    monkeypatch.setitem(sys.modules, "__main__", module)
    module.In = [""]

    def run(*cells):
        for cell in (HEAD, *cells):
            module.In.append(cell)
            try:
                exec(cell, vars(module))
            except ZeroDivisionError:
                continue
        return SimpleNamespace(**vars(module))

    return run


def torque(part):
    return np.asarray(part(None, None, 0.0))


def loaded(given):
    """The object as another process makes it."""
    found = user_object(SECTION, given)
    part = user_part(SECTION, found.kind, found.sources)
    return part.build(found.values)


EQUAL = {
    "annotations as texts": (
        "from __future__ import annotations\ndef law(x: Any = 2.0): return x",
        P,
    ),
    "an array without a type of its own": ("W = jnp.full(3, 2.0)\ndef law(): return W[0]", P),
    "a random key": (
        "import jax\nKEY = jax.random.key(0)\ndef law(): return jax.random.normal(KEY)",
        P,
    ),
    "a helper": ("def law(): return 2.0", P),
    "a number of a later cell": ("def law(): return GAIN", P, "GAIN = 3.0"),
    "the other branch": (
        "if 1 > 2:\n    def law(): return 2.0\nelse:\n    def law(): return 3.0",
        P,
    ),
    "the first branch": (
        "if 2 > 1:\n    def law(): return 2.0\nelse:\n    def law(): return 3.0",
        P,
    ),
    "no handler": (
        "try:\n    from math import pi\n    law = lambda: pi\n"
        "except ImportError:\n    def law(): return 3.0",
        P,
    ),
    "an import and its handler": (
        "try:\n    from math import tau as law\nexcept ImportError:\n    law = 6.0",
        PART.format(value="law"),
    ),
    "a cell that failed": ("def law(): return 2.0", P, "1 / 0\ndef law(): return 3.0"),
    "a closure": ("def make(gain):\n    def f(): return gain\n    return f", "law = make(2.0)", P),
    "partial": ("def f(gain): return gain", "gain = 2.0\nlaw = functools.partial(f, gain)", P),
    "partial of a name that changed": (
        "def f(gain): return gain",
        "gain = 2.0\nlaw = functools.partial(f, gain)",
        P,
        "gain = 3.0",
    ),
    "a data class": (
        "@dataclasses.dataclass(frozen=True)\nclass Gains:\n    kp: float = 2.0",
        "GAINS = Gains(4.0)\ndef law(): return GAINS.kp",
        P,
    ),
    "a decorator": (
        "def twice(f):\n    @functools.wraps(f)\n    def inner(): return 2.0 * f()\n"
        "    return inner",
        "@twice\ndef law(): return 2.0",
        P,
    ),
    "a default value": ("GAIN = 2.0\ndef law(gain=GAIN): return gain", P),
    "an inherited method": (
        "class Base:\n    def law(self): return 2.0",
        PART.format(value="self.law()").replace("class P", "class P(Base)"),
    ),
    "an array": ("K = np.array([1.0, np.pi]) / 3.0\ndef law(): return K[1]", P),
    "a compiled helper": ("import jax\n@jax.jit\ndef law(): return 2.0", P),
    "a mapped helper": (
        "import jax",
        "law = lambda: jax.vmap(lambda x: 2.0 * x)(K)[0]",
        "K = jnp.ones(2)",
        P,
    ),
    "a text of several lines": (
        "if True:\n    def law():\n        '''Two\n   lines.'''\n        return len('''a\n  b''')",
        P,
    ),
    "an enumeration": (
        "import enum\nclass Mode(enum.Enum):\n    FAST = 2.0\nMODE = Mode.FAST",
        "def law(): return MODE.value",
        P,
    ),
}
REFUSED = {
    "a derivative of one's own": (
        "import jax\n@jax.custom_jvp\ndef f(x): return 2.0 * x",
        "@f.defjvp\ndef g(p, t): return f(p[0]), 3.0 * t[0]\ndef law(): return f(1.0)",
        P,
    ),
    "a function of a library": (
        "def law(): return np.cos(0.0)",
        "def cosine(x): return 2.0",
        P,
        "np.cos = cosine",
    ),
    "a class attribute set later": (P, "def law(): return 1.0", "P.extra = 2.0"),
    "a class attribute changed later": (
        P.replace("size:", "unit = 'm'\n    size:"),
        "def law(): return 1.0",
        "P.unit = 's'",
    ),
    "a patched method": (
        P,
        "def law(): return 1.0",
        "P.__call__ = lambda self, s, a, t: jnp.ones(3)",
    ),
    "a factory of a name that changed": (
        "def make(gain):\n    def f(): return gain\n    return f",
        "gain = 2.0\nlaw = make(gain)",
        P,
        "gain = 3.0",
    ),
    "a default value of a name that changed": (
        "GAIN = 2.0\ndef law(gain=GAIN): return gain",
        P,
        "GAIN = 3.0",
    ),
    "a decorator of a name that changed": (
        "def times(k):\n    def deco(f):\n        return lambda: k * f()\n    return deco",
        "K = 2.0\n@times(K)\ndef law(): return 2.0",
        P,
        "K = 3.0",
    ),
    "an attribute of a function": ("def law(): return law.gain", P, "law.gain = 2.0"),
    "a captured function that was defined again": (
        "def f(): return 2.0",
        P.replace("size:", "law = f\n    size:"),
        "def law(): return 1.0",
        "def f(): return 3.0",
    ),
    "a base class that changed": (
        "class Base:\n    gain = 1.0\n    def law(self): return self.gain",
        PART.format(value="self.law()").replace("class P", "class P(Base)"),
        "Base.gain = 5.0",
    ),
    "an instance that changed": (
        "class Box:\n    gain = 1.0\nbox = Box()\ndef law(): return box.gain",
        P,
        "box.gain = 2.0",
    ),
    "a function from a text": (
        "exec('def law(): return 2.0')",
        "if 1 > 2:\n    def law(): return 3.0",
        P,
    ),
    "a use of globals()": ("gain = 2.0\ndef law(): return globals()['gain']", P),
    "a large array from several statements": (
        "K = jnp.ones(200_000)\nK = K.at[7].set(3.0)",
        "def law(): return K[7]",
        P,
    ),
    "an annotation": (P, "def law(): return 1.0", "P.__annotations__['size'] = int"),
    "a rule that was registered later": (
        "@functools.singledispatch\ndef f(x): return 1.0",
        "def law(): return f(1.0)",
        P,
        "@f.register(float)\ndef _(x): return 9.0",
    ),
    "a file": ("def law(): return len(STREAM.name)", "import os\nSTREAM = open(os.devnull)", P),
}


@pytest.mark.parametrize("cells", EQUAL.values(), ids=EQUAL)
def test_what_runs_is_the_object_in_memory(notebook, cells):
    given = notebook(*cells).P
    made = given()
    made.size = 1.5
    np.testing.assert_array_equal(torque(loaded(made)), torque(made))


@pytest.mark.parametrize("cells", REFUSED.values(), ids=REFUSED)
def test_what_the_text_does_not_give_is_refused(notebook, monkeypatch, cells):
    monkeypatch.setattr(np, "cos", np.cos)  # restored, if a cell replaces it
    expected = r"expected (the same: execute its|the value of the library: other)"
    with pytest.raises(InputError, match=rf"found .* in memory, .*{expected}"):
        user_object(SECTION, notebook(*cells).P())


def test_an_attribute_that_is_no_field_is_refused(notebook):
    made = notebook("def law(): return 1.0", P).P()
    made.extra = 2.0
    with pytest.raises(InputError, match=r"found P\.extra: 2\.0 in memory"):
        user_object(SECTION, made)


def test_a_module_that_was_edited_after_its_import_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "edited_law.py"
    path.write_text(f"{HEAD}\nGAIN = 2.0\ndef law(): return GAIN\n{P}")
    monkeypatch.syspath_prepend(tmp_path)
    import edited_law  # pyright: ignore[reportMissingImports]

    try:
        np.testing.assert_array_equal(torque(loaded(edited_law.P())), torque(edited_law.P()))
        path.write_text(path.read_text().replace("GAIN = 2.0", "GAIN = 3.0"))
        with pytest.raises(InputError, match=r"found GAIN: 2\.0 in memory, 3\.0 from the text of"):
            user_object(SECTION, edited_law.P())
    finally:
        del sys.modules["edited_law"]


def test_the_digest_stays_if_something_else_changes(notebook):
    cells = "def law(): return 2.0", P
    one = user_object(SECTION, notebook(*cells).P)
    other = user_object(SECTION, notebook("x = 1", *cells, "def unused(): return 3.0").P)
    assert one[:3] == other[:3]


def test_comments_and_blank_lines_leave_the_digest(notebook):
    bare = "def law():\n    text = '''a # b\n\n  c'''\n    return len(text) + 1.0"
    full = bare.replace("():", "():  # comment\n\n    # comment").replace("1.0", "1.0  # c")
    one, other = (user_object(SECTION, notebook(cell, P).P) for cell in (bare, full))
    assert one[:3] == other[:3]
    assert "a # b\n\n  c" in other.sources[0].text


STALE = {
    "functools.cache": ("G = 2.0\n@functools.cache\ndef law(): return G", "law()"),
    "functools.lru_cache of an argument": (
        "G = 2.0\n@functools.lru_cache(maxsize=4)\ndef f(x): return G * x",
        "def law(): return f(1.5)\nlaw()",
    ),
    "jax.jit": ("import jax\nG = 2.0\n@jax.jit\ndef law(): return G * jnp.ones(())", "law()"),
    "equinox.filter_jit": (
        "import equinox\nG = 2.0\n@equinox.filter_jit\ndef f(x): return G * x",
        "def law(): return f(jnp.ones(()))\nlaw()",
    ),
    "a scan": (
        "import jax\nG = 2.0\ndef f(x, y): return x + G * y, x",
        "def law(): return jax.lax.scan(f, 0.0, jnp.arange(3.0))[0]\nlaw()",
    ),
}
"""Helpers that keep what they computed before a name changed."""


def compare_calls(given):
    """Compare a call of the object with one of its text."""
    found = user_object(SECTION, given)
    inner = user_part(SECTION, found.kind, found.sources).build(found.values)
    arguments = None, None, 0.0
    with comparing({found.kind: given}):
        compare_live(
            f"{SECTION} {found.kind}", inner, "__call__", arguments, lambda: inner(*arguments)
        )


@pytest.mark.parametrize("cells", STALE.values(), ids=STALE)
def test_a_result_that_was_stored_before_a_change_is_refused(notebook, cells):
    compare_calls(notebook(*cells, P).P())
    with pytest.raises(InputError, match=r"line \d+: found `.*`, which gives .* and .* in memory"):
        compare_calls(notebook(*cells, P, "G = 3.0").P())


def test_code_that_asks_which_of_two_equal_objects_it_has_is_refused(notebook):
    cells = "A = [1.0]\nB = [1.0]\ndef law(): return 1.0 if A is B else 2.0", P
    compare_calls(notebook(*cells).P())
    with pytest.raises(InputError, match=r"2\.0 from the text and 1\.0 in memory.* not by `is`"):
        compare_calls(notebook(*cells, "B = A").P())


def test_a_stored_trace_is_found_when_a_scenario_takes_the_object(notebook, short):
    scenario = read_scenario(short('kind = "three_axis"'))
    cells = (*STALE["jax.jit"], P)
    scenario.replace(environment=(notebook(*cells).P(),))
    with pytest.raises(InputError, match=r"environment.torque.p notebook_P.py:P, line"):
        scenario.replace(environment=(notebook(*cells, "G = 3.0").P(),))


LAW = """from gyrostat.wheel.friction import Friction, parameter
class Law(Friction):
    coulomb: float = parameter("torque")
    def torque(self, speed, direction): return direction * self.coulomb * law()
"""


@pytest.mark.parametrize("cells", STALE.values(), ids=STALE)
def test_a_stored_result_in_a_friction_law_is_refused_before_its_text_is_written(notebook, cells):
    kind, sources = law_source(notebook(*cells, LAW).Law)
    assert float(loaded_law(kind, sources)(0.5).torque(1.0, 1.0)) == pytest.approx(
        float(notebook(*cells, LAW).Law(0.5).torque(1.0, 1.0))
    )
    with pytest.raises(InputError, match=r"friction notebook_Law.py:Law, line \d+: found `"):
        law_source(notebook(*cells, LAW, "G = 3.0").Law)


RAISING = """class P:
    size: float = 1.0
    def __call__(self, spacecraft, attitude, time): return law() * self.size * jnp.ones(3)
"""


def test_an_object_that_fails_in_memory_only_is_refused(notebook):
    given = notebook("SEEN = [1.0]\ndef law(): return SEEN[0]", RAISING).P()
    compare_calls(given)
    found = user_object(SECTION, given)
    inner = user_part(SECTION, found.kind, found.sources).build(found.values)
    type(given).__call__ = lambda *_: 1 / 0
    with (
        comparing({found.kind: given}),
        pytest.raises(InputError, match=r"found ZeroDivisionError \(division by zero\) from"),
    ):
        compare_live(f"part {found.kind}", inner, "__call__", (None, None, 0.0), lambda: 1.0)


PATCHED = {
    "math.tau": (math, "tau", 9.0),
    "np.pi": (np, "pi", 9.0),
    "math.extra": (math, "extra", 9.0),
    "jnp.sin": (jnp, "sin", jnp.cos),
    "math.sqrt": (math, "sqrt", np.sqrt),
    "np.linalg.norm": (np.linalg, "norm", np.linalg.det),
}
"""Name -> module, attribute and the value that is set in it."""


@pytest.mark.parametrize("name", PATCHED)
@pytest.mark.parametrize("form", ["import {0}", "from {0} import {1} as g"])
def test_a_value_that_was_set_in_a_library_is_refused(notebook, monkeypatch, name, form):
    module, attribute, value = PATCHED[name]
    cells = f"import math\n{form.format(module.__name__, attribute)}"
    short = f"{module.__name__}.{attribute}" if form.startswith("import") else "g"
    cells = cells, f"def law(): return {short} if isinstance({short}, float) else 1.0", P
    if attribute != "extra":
        user_object(SECTION, notebook(*cells).P())
    monkeypatch.setattr(module, attribute, value, raising=False)
    given = notebook(*cells).P()
    with pytest.raises(InputError, match=rf"{attribute}: .*expected the value of the library"):
        user_object(SECTION, given)


def test_attributes_of_a_metaclass_are_not_those_of_the_class(notebook):
    cells = (
        "class M(type):\n    def __getattr__(cls, name):\n        if name != 'gain':\n"
        "            raise AttributeError(name)\n        return 2.0",
        PART.format(value="type(self).gain").replace("class P", "class P(metaclass=M)"),
    )
    given = notebook(*cells).P()
    np.testing.assert_array_equal(torque(loaded(given)), torque(given))


def test_a_class_is_used_again_after_many_others(notebook):
    found = user_object(SECTION, notebook("def law(): return 2.0", P).P)
    user_part.cache_clear()  # as the parts of many other cells do
    assert user_part(SECTION, found.kind, found.sources).fields == ("size",)
