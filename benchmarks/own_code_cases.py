"""Cases of parts of a user's own, which `soak_own_code.py` executes in cells of a notebook.

In each text, @ after a letter stands for the number of the case. A case is a list of cells; where
none of them defines the class P@, a class that multiplies law@() is defined last, before what is
changed.
"""

PART = """
class P@:
    size: float = 1.0
    def __call__(self, spacecraft, attitude, time):
        return jnp.asarray({value}) * self.size * jnp.ones(3)
"""
LAW = PART.format(value="law@()")


def part(value, before="class P@:", after="", fields=""):
    """Class whose torque is an expression, with other text in place of its first line."""
    text = PART.format(value=value).replace("class P@:", before + fields)
    return text + after


G = "G@ = 2.0\ndef law@(): return G@"
BASE = "class B@:\n    gain = 2.0\n    def law(self): return self.gain"
TWICE = (
    "def twice@(f):\n    @functools.wraps(f)\n    def inner(): return 2.0 * f()\n    return inner"
)
BOX = "class Box@:\n    gain = 2.0\nbox@ = Box@()\ndef law@(): return box@.gain"
MODULE = "write('mod@.py', 'GAIN = 2.0\\ndef law(): return GAIN\\n')\nimport mod@"
FROM_MODULE = "def law@(): return mod@.law()"
EDIT = "write('mod@.py', 'GAIN = 3.0\\ndef law(): return GAIN\\n')"
BODY = "def f@(x, y): return x + G@ * y, x"
SCAN = "def law@(): return jax.lax.scan(f@, 0.0, jnp.arange(3.0))[0]"
DATA = "@dataclasses.dataclass(frozen=True)\nclass Gains@:\n    kp: float = 2.0"

CHANGES = {
    # a name is bound again
    "number of a later cell": ([G], ["G@ = 3.0"]),
    "helper defined again": ([G], ["def law@(): return 3.0"]),
    "helper of a helper defined again": (
        ["def f@(): return 2.0", "def law@(): return f@()"],
        ["def f@(): return 3.0"],
    ),
    "helper in a magic cell": ([G], ["%%time\ndef law@(): return 3.0"]),
    "class defined again": ([LAW, "def law@(): return 2.0"], [part("3.0 * law@()")]),
    "class in a magic cell": ([LAW, "def law@(): return 2.0"], ["%%time" + part("3.0 * law@()")]),
    "lambda": (["law@ = lambda: 2.0"], ["law@ = lambda: 3.0"]),
    "two lambdas on a line": (["law@ = lambda: 2.0"], ["a@, law@ = (lambda: 3.0), (lambda: 4.0)"]),
    "function from a text": (["def law@(): return 2.0"], ["exec('def law@(): return 3.0')"]),
    "definition executed again": (
        ["def law@(): return 2.0", "def law@(): return 3.0"],
        ["def law@(): return 2.0"],
    ),
    "cell that fails after a definition": ([G], ["def law@(): return 3.0\n1 / 0"]),
    "cell that fails before a definition": ([G], ["1 / 0\ndef law@(): return 3.0"]),
    "other branch": (
        ["F@ = True", "if F@:\n    def law@(): return 2.0\nelse:\n    def law@(): return 3.0"],
        ["F@ = False", "if F@:\n    def law@(): return 2.0\nelse:\n    def law@(): return 3.0"],
    ),
    "flag of a branch that was taken": (
        ["F@ = True", "if F@:\n    def law@(): return 2.0\nelse:\n    def law@(): return 3.0"],
        ["F@ = False"],
    ),
    "handler of an import": (
        ["try:\n    from math import tau as g@\nexcept ImportError:\n    g@ = 1.0", G],
        ["try:\n    import no@\nexcept ImportError:\n    def law@(): return 3.0"],
    ),
    "loop that defines": ([G], ["for k@ in (4.0, 5.0):\n    def law@(k=k@): return k"]),
    "walrus": ([G], ["if (G@ := 3.0) > 1.0: pass"]),
    "target of with": ([G], ["with contextlib.nullcontext(3.0) as G@: pass"]),
    "globals()": ([G], ["globals()['G@'] = 3.0"]),
    "global in a function": ([G], ["def set@():\n    global G@\n    G@ = 3.0\nset@()"]),
    "del": ([G], ["del G@\nG@ = 3.0"]),
    "augmented assignment": ([G], ["G@ += 1.5"]),
    "sign of zero": (
        ["G@ = 0.0\ndef law@(): return np.copysign(1.0, G@)"],
        ["G@ = -0.0"],
    ),
    "type of a number": (
        ["G@ = 1\ndef law@(): return 3.0 if G@ is True else 2.0"],
        ["G@ = True"],
    ),
    "alias of a module": (
        ["import math as m@\ndef law@(): return m@.cos(0.5)"],
        ["class m@:\n    cos = staticmethod(lambda x: 3.0)"],
    ),
    "built-in name hidden": (["def law@(): return abs(-2.0)"], ["_abs = abs\nabs = lambda x: 3.0"]),
    # a captured value
    "captured by partial": (
        ["def f@(g): return g\ng@ = 2.0\nlaw@ = functools.partial(f@, g@)"],
        ["g@ = 3.0"],
    ),
    "partial of a function defined again": (
        ["def f@(): return 2.0", "law@ = functools.partial(f@)"],
        ["def f@(): return 3.0"],
    ),
    "argument of partial changed in place": (
        ["a@ = [2.0]\ndef f@(a): return a[0]\nlaw@ = functools.partial(f@, a@)"],
        ["a@[0] = 3.0"],
    ),
    "captured by a factory": (
        ["def make@(g):\n    def f(): return g\n    return f", "g@ = 2.0\nlaw@ = make@(g@)"],
        ["g@ = 3.0"],
    ),
    "captured by a default value": (["g@ = 2.0\ndef law@(g=g@): return g"], ["g@ = 3.0"]),
    "captured by a decorator": (
        [
            "def times@(k):\n    def deco(f): return lambda: k * f()\n    return deco",
            "k@ = 2.0\n@times@(k@)\ndef law@(): return 2.0",
        ],
        ["k@ = 3.0"],
    ),
    "decorator defined again": (
        [TWICE, "@twice@\ndef law@(): return 2.0"],
        [TWICE.replace("2.0 * f", "3.0 * f")],
    ),
    "nonlocal": (
        [
            "def make@():\n    n = 2.0\n    def f(): return n\n    def b():\n"
            "        nonlocal n\n        n += 1\n    return f, b",
            "pair@ = make@()\nlaw@ = pair@[0]",
        ],
        ["pair@[1]()"],
    ),
    "captured by vmap": (
        ["g@ = 2.0\nf@ = jax.vmap(lambda x: g@ * x)\ndef law@(): return f@(jnp.ones(2))[0]"],
        ["g@ = 3.0"],
    ),
    "method of an instance": (
        [
            BOX.replace("gain = 2.0", "gain = 2.0\n    def law(self): return self.gain"),
            "law@ = box@.law",
        ],
        ["box@.gain = 3.0"],
    ),
    # a function
    "default value replaced": (["def law@(g=2.0): return g"], ["law@.__defaults__ = (3.0,)"]),
    "default list changed": (["def law@(g=[2.0]): return g[0]"], ["law@.__defaults__[0][0] = 3.0"]),
    "keyword default": (["def law@(*, g=2.0): return g"], ["law@.__kwdefaults__ = {'g': 3.0}"]),
    "code replaced": (["def law@(): return 2.0"], ["law@.__code__ = (lambda: 3.0).__code__"]),
    "attribute of a function": (["def law@(): return law@.g\nlaw@.g = 2.0"], ["law@.g = 3.0"]),
    "rule registered later": (
        ["@functools.singledispatch\ndef f@(x): return 2.0", "def law@(): return f@(1.0)"],
        ["@f@.register(float)\ndef _(x): return 3.0"],
    ),
    "derivative replaced": (
        [
            "@jax.custom_jvp\ndef f@(x): return 2.0 * x\n@f@.defjvp\n"
            "def g@(p, t): return f@(p[0]), 2.0 * t[0]",
            "def law@(): return jax.grad(f@)(1.0)",
        ],
        ["@f@.defjvp\ndef g@(p, t): return f@(p[0]), 3.0 * t[0]"],
    ),
    # a class or an instance
    "class attribute set later": ([BOX], ["Box@.gain = 3.0"]),
    "attribute of the part's class": ([part("self.k", fields="\n    k = 2.0")], ["P@.k = 3.0"]),
    "method replaced": (
        [LAW, "def law@(): return 2.0"],
        ["P@.__call__ = lambda self, s, a, t: 3.0 * jnp.ones(3)"],
    ),
    "attribute of a base": (
        [BASE, part("self.law()", "class P@(B@):")],
        ["B@.gain = 3.0"],
    ),
    "method of a base": (
        [BASE, part("self.law()", "class P@(B@):")],
        ["B@.law = lambda self: 3.0"],
    ),
    "other base": (
        [BASE, BASE.replace("B@", "C@").replace("2.0", "3.0"), part("self.law()", "class P@(B@):")],
        ["P@.__bases__ = (C@,)"],
    ),
    "instance attribute": ([BOX], ["box@.gain = 3.0"]),
    "instance of a class defined again": ([BOX], ["class Box@:\n    gain = 3.0"]),
    "slot": (
        ["class S@:\n    __slots__ = ('g',)\ns@ = S@()\ns@.g = 2.0\ndef law@(): return s@.g"],
        ["s@.g = 3.0"],
    ),
    "property": (
        [part("self.g", fields="\n    @property\n    def g(self): return 2.0\n")],
        ["P@.g = property(lambda self: 3.0)"],
    ),
    "class method": (
        [part("self.g()", fields="\n    @classmethod\n    def g(cls): return 2.0\n")],
        ["P@.g = classmethod(lambda cls: 3.0)"],
    ),
    "metaclass": (
        [
            "class M@(type):\n    gain = 2.0\nclass B@(metaclass=M@): pass",
            "def law@(): return B@.gain",
        ],
        ["M@.gain = 3.0"],
    ),
    "field of a named tuple": (
        ["class N@(typing.NamedTuple):\n    a: float\nn@ = N@(2.0)\ndef law@(): return n@.a"],
        ["n@ = N@(3.0)"],
    ),
    "member of an enumeration": (
        ["class E@(enum.Enum):\n    A = 2.0\ne@ = E@.A\ndef law@(): return e@.value"],
        ["class E@(enum.Enum):\n    A = 3.0\ne@ = E@.A"],
    ),
    # data
    "entry of a dict": (["D@ = {'k': 2.0}\ndef law@(): return D@['k']"], ["D@['k'] = 3.0"]),
    "order of a dict": (
        ["D@ = {'a': 2.0, 'b': 3.0}\ndef law@(): return next(iter(D@.values()))"],
        ["D@ = {'b': 3.0, 'a': 2.0}"],
    ),
    "array in place": (["K@ = np.full(3, 2.0)\ndef law@(): return K@[0]"], ["K@[0] = 3.0"]),
    "base of a view": (
        ["B@ = np.full(4, 2.0)\nK@ = B@[::2]\ndef law@(): return K@[1]"],
        ["B@[2] = 3.0"],
    ),
    "large array in place": (
        ["K@ = np.full(200_000, 2.0)\ndef law@(): return K@[777]"],
        ["K@[777] = 3.0"],
    ),
    "large JAX array": (
        ["K@ = jnp.full(200_000, 2.0)\ndef law@(): return K@[777]"],
        ["K@ = K@.at[777].set(3.0)"],
    ),
    "two names of one list": (
        ["A@ = [1.0]\nB@ = [1.0]\ndef law@(): return 3.0 if A@ is B@ else 2.0"],
        ["B@ = A@"],
    ),
    # what was stored
    "functools.cache": ([G.replace("def", "@functools.cache\ndef"), "law@()"], ["G@ = 3.0"]),
    "jax.jit": (
        ["G@ = 2.0\n@jax.jit\ndef f@(x): return G@ * x\ndef law@(): return f@(1.0)\nlaw@()"],
        ["G@ = 3.0"],
    ),
    "body of a scan": (["G@ = 2.0", BODY, SCAN, "law@()"], ["G@ = 3.0"]),
    # modules
    "value of a library": (["def law@(): return math.tau"], ["math.tau = 3.0"]),
    "value of NumPy": (["def law@(): return np.pi"], ["np.pi = 3.0"]),
    "function of a library": (["def law@(): return np.cos(0.5)"], ["np.cos = lambda x: 3.0"]),
    "function of a library from it": (["def law@(): return jnp.cos(0.5)"], ["jnp.cos = jnp.sin"]),
    "new name in a library": (["def law@(): return getattr(math, 'e@', 2.0)"], ["math.e@ = 3.0"]),
    "value of the user's module": ([MODULE, FROM_MODULE], ["mod@.GAIN = 3.0"]),
    "user's module edited after its import": ([MODULE, FROM_MODULE], [EDIT]),
    "user's module edited and reloaded": (
        [MODULE, FROM_MODULE],
        [f"{EDIT}\nimportlib.invalidate_caches()\nimportlib.reload(mod@)"],
    ),
    "name imported from the user's module": (
        [MODULE, "from mod@ import GAIN as g@\ndef law@(): return g@"],
        ["mod@.GAIN = 3.0"],
    ),
}
"""Name -> cells before the result is taken, cells that change something afterwards."""

UNDO = """
math.tau, np.pi, np.cos, jnp.cos = saved
if "_abs" in globals(): del abs, _abs
for name in [n for n in vars(math) if n[0] == "e" and n[1:].isdigit()]: delattr(math, name)
"""
"""Cell that restores the libraries after a case."""

UNCHANGED = {
    "comment": (
        ["def law@():\n    return 2.0"],
        ["def law@():\n    # why\n    return 2.0  # what"],
    ),
    "blank lines": (
        ["def law@():\n    g = 2.0\n    return g"],
        ["\n\ndef law@():\n\n    g = 2.0\n\n    return g\n"],
    ),
    "cell executed again": ([G], [G]),
    "unrelated cell": ([G], ["other@ = 7.0\ndef unused@(): return other@"]),
    "unrelated class": ([G], [BASE]),
    "order of cells": (
        ["G@ = 2.0", "def f@(): return G@", "def law@(): return f@()"],
        ["def law@(): return f@()", "def f@(): return G@", "G@ = 2.0"],
    ),
    "print options": ([G], ["np.set_printoptions(precision=3)"]),
    "result of a call": ([G], ["law@()", "x@ = P@()(None, None, 0.0)"]),
}
"""Name -> cells, and cells that change nothing of the part: its digest stays."""

HONEST = {
    "helper": [G],
    "helper of a helper in three cells": [
        "g@ = 2.0",
        "def f@(): return g@",
        "def law@(): return f@()",
    ],
    "data class": [DATA, "GAINS@ = Gains@(4.0)\ndef law@(): return GAINS@.kp"],
    "data class with a default factory": [
        "@dataclasses.dataclass\nclass N@:\n"
        "    a: list = dataclasses.field(default_factory=lambda: [2.0])",
        "def law@(): return N@().a[0]",
    ],
    "closure": ["def make@(g):\n    def f(): return g\n    return f", "law@ = make@(2.0)"],
    "closure with nonlocal": [
        "def law@():\n    n = 0.0\n    def add():\n        nonlocal n\n        n += 1.0\n"
        "    add(); add()\n    return n"
    ],
    "partial": ["def f@(a, *, b): return a * b", "law@ = functools.partial(f@, 2.0, b=1.5)"],
    "decorator": [TWICE, "@twice@\ndef law@(): return 2.0"],
    "decorator with an argument": [
        "def times@(k):\n    def deco(f):\n        @functools.wraps(f)\n"
        "        def inner(*a): return k * f(*a)\n        return inner\n    return deco",
        "@times@(1.5)\ndef law@(): return 2.0",
    ],
    "inherited method": [BASE, part("self.law()", "class P@(B@):")],
    "super()": [
        BASE,
        "class C@(B@):\n    def law(self): return 1.5 * super().law()",
        part("self.law()", "class P@(C@):"),
    ],
    "abstract base": [
        "import abc\nclass A@(abc.ABC):\n    @abc.abstractmethod\n    def law(self): ...\n"
        "class C@(A@):\n    def law(self): return 2.0",
        "def law@(): return C@().law()",
    ],
    "property": [part("self.g", fields="\n    @property\n    def g(self): return 2.0\n")],
    "class method and static method": [
        "class C@:\n    @classmethod\n    def f(cls): return cls.g()\n    @staticmethod\n"
        "    def g(): return 2.0",
        "def law@(): return C@.f()",
    ],
    "instance with __call__": [
        "class Law@:\n    def __init__(self, g): self.g = g\n    def __call__(self): return self.g",
        "law@ = Law@(2.0)",
    ],
    "slots": [
        "class S@:\n    __slots__ = ('g',)\n    def __init__(self, g): self.g = g",
        "s@ = S@(2.0)\ndef law@(): return s@.g",
    ],
    "equinox module": [
        "class M@(eqx.Module):\n    a: jax.Array\n    def __call__(self, x): return self.a @ x",
        "m@ = M@(jnp.arange(3.0))\ndef law@(): return m@(jnp.ones(3))",
    ],
    "jitted helper tried before": [
        "@jax.jit\ndef f@(x): return 2.0 * x",
        "f@(1.0), f@(jnp.ones(3))\ndef law@(): return f@(jnp.ones(()))\nlaw@()",
    ],
    "jitted helper of an array": [
        "A@ = np.arange(3.0)\n@functools.partial(jax.jit, static_argnums=1)\n"
        "def f@(x, n): return (A@ @ x) ** n",
        "def law@(): return f@(jnp.ones(3), 2)\nlaw@()",
    ],
    "equinox.filter_jit tried before": [
        "@eqx.filter_jit\ndef f@(x): return 2.0 * x\ndef law@(): return f@(jnp.ones(()))\nlaw@()"
    ],
    "cached helper tried before": [
        "@functools.lru_cache\ndef f@(n): return 1.0 if n < 2 else n * f@(n - 1)",
        "def law@(): return f@(5)\nlaw@()",
    ],
    "vmap": ["f@ = jax.vmap(lambda x: 2.0 * x)\ndef law@(): return f@(jnp.arange(3.0))[1]"],
    "scan tried before": ["G@ = 2.0", BODY, SCAN, "law@()"],
    "cond and fori_loop": [
        "def law@():\n    a = jax.lax.cond(True, lambda x: 2.0 * x, lambda x: x, 1.5)\n"
        "    return jax.lax.fori_loop(0, 3, lambda i, x: x + 1.0, a)"
    ],
    "grad": ["def f@(x): return x**3\ndef law@(): return jax.grad(f@)(2.0)"],
    "enumeration": [
        "class E@(enum.Enum):\n    FAST = 2.0\n    SLOW = 1.0\nMODE@ = E@.FAST",
        "def law@(): return 3.0 if MODE@ is E@.FAST else 1.0",
    ],
    "enumeration of integers": [
        "class I@(enum.IntEnum):\n    X = 0\n    Y = 1",
        "def law@(): return np.array([2.0, 3.0])[I@.Y]",
    ],
    "named tuple with a method": [
        "class N@(typing.NamedTuple):\n    a: float\n    def twice(self): return 2.0 * self.a",
        "n@ = N@(2.0)\ndef law@(): return n@.twice()",
    ],
    "module of the user's folder": [MODULE, FROM_MODULE],
    "package of the user's folder": [
        "write('pack@/__init__.py', 'from .inner import law\\n')\n"
        "write('pack@/inner.py', 'def law(): return 2.5\\n')\nfrom pack@ import law as law@"
    ],
    "arrays": [
        "K@ = np.linalg.inv(np.array([[2.0, 1.0], [1.0, 3.0]]))\nW@ = jnp.full(2, 1 / 3)",
        "def law@(): return W@ @ K@ @ W@",
    ],
    "table": [
        "X@, Y@ = np.linspace(0.0, 1.0, 50), np.linspace(0.0, 1.0, 50) ** 2",
        "def law@(): return np.interp(0.33, X@, Y@)",
    ],
    "numbers of a fixed seed": [
        "K@ = np.random.default_rng(3).normal(size=3)\ndef law@(): return K@[0]"
    ],
    "generator and comprehension": [
        "def f@(n):\n    for k in range(n):\n        yield float(k)\n"
        "def law@(): return sum([x * x for x in f@(4)]) + max(y for y in f@(3))"
    ],
    "arguments of all kinds": [
        "def f@(a, /, b=2.0, *c, d=3.0, **e): return a * b + sum(c) + d + sum(e.values())",
        "def law@(): return f@(1.0, 2.0, 3.0, d=4.0, e=5.0)",
    ],
    "functions in a dict": [
        "T@ = {'a': lambda: 2.0}\nT@['b'] = T@['a']\ndef law@(): return T@['a']()"
    ],
    "import inside and star import": [
        "from math import *",
        "def law@():\n    from math import cosh\n    return cosh(0.5) + sinh(0.5)",
    ],
    "import with a handler": [
        "try:\n    import no@ as lib@\nexcept ImportError:\n    import math as lib@",
        "def law@(): return lib@.sqrt(2.0)",
    ],
    "context manager": [
        "@contextlib.contextmanager\ndef c@():\n    yield 2.0",
        "def law@():\n    with c@() as g:\n        return g",
    ],
    "tree registered in the notebook": [
        "@jax.tree_util.register_pytree_node_class\nclass T@:\n"
        "    def __init__(self, a): self.a = a\n"
        "    def tree_flatten(self): return (self.a,), None\n"
        "    @classmethod\n    def tree_unflatten(cls, aux, c): return cls(*c)",
        "def law@(): return jax.tree.map(lambda x: 2.0 * x, T@(1.5)).a",
    ],
}
"""Name -> cells of an honest notebook."""
