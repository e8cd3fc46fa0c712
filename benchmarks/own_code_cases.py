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
    # protocols of Python, states, containers, and what the process tells
    "__init_subclass__": (
        [
            "S@ = 2.0\nclass B@:\n    def __init_subclass__(cls): cls.gain = S@",
            "class C@(B@): pass\ndef law@(): return C@.gain",
        ],
        ["S@ = 3.0"],
    ),
    "registry by __init_subclass__": (
        [
            "class B@:\n    known = []\n    def __init_subclass__(cls): B@.known.append(cls)",
            "class C@(B@): pass\ndef law@(): return 1.0 + len(B@.known)",
        ],
        ["class D@(B@): pass"],
    ),
    "__class_getitem__": (
        [
            "class Box@:\n    table = {2: 2.0}\n"
            "    def __class_getitem__(cls, k): return cls.table[k]\ndef law@(): return Box@[2]",
        ],
        ["Box@.table[2] = 3.0"],
    ),
    "descriptor": (
        [
            "class D@:\n    def __init__(self, k): self.k = k\n"
            "    def __get__(self, one, of): return self.k\nclass Box@:\n    gain = D@(2.0)\n"
            "def law@(): return Box@.gain",
        ],
        ["Box@.__dict__['gain'].k = 3.0"],
    ),
    "__set_name__": (
        [
            "class D@:\n    def __set_name__(self, of, name): self.k = float(len(name))\n"
            "    def __get__(self, one, of): return self.k\nclass Box@:\n    ab = D@()\n"
            "def law@(): return Box@.ab",
        ],
        [
            "Box@.abc = D@(); Box@.__dict__['abc'].__set_name__(Box@, 'abc'); Box@.ab = "
            "Box@.__dict__['abc']",
        ],
    ),
    "__getattr__ of a module": (
        [
            "write('mod@.py', 'STATE = [2.0]\\ndef __getattr__(name): return STATE[0]\\n')\n"
            "import mod@\ndef law@(): return mod@.anything",
        ],
        ["mod@.STATE[0] = 3.0"],
    ),
    "__getattr__ of an object": (
        [
            "class Box@:\n    def __init__(self): self.table = {'gain': 2.0}\n"
            "    def __getattr__(self, name): return self.__dict__['table'][name]\n"
            "box@ = Box@()\ndef law@(): return box@.gain",
        ],
        ["box@.table['gain'] = 3.0"],
    ),
    "class that counts its objects": (
        [
            "class Box@:\n    count = 0\n    def __init__(self): Box@.count += 1\n"
            "def law@(): return 2.0 + Box@.count",
        ],
        ["Box@()"],
    ),
    "object that counts its calls": (
        [
            "class Box@:\n    count = 1.0\n    def __call__(self):\n        self.count += 1.0\n"
            "        return self.count\nlaw@ = Box@()",
        ],
        ["law@()"],
    ),
    "__call__ of a metaclass": (
        [
            "class M@(type):\n    def __call__(cls):\n        made = super().__call__()\n"
            "        made.gain = cls.start\n        return made\nclass Box@(metaclass=M@):\n"
            "    start = 2.0\nbox@ = Box@()\ndef law@(): return box@.gain",
        ],
        ["Box@.start = 3.0"],
    ),
    "__new__": (
        [
            "G@ = 2.0\nclass Box@(float):\n"
            "    def __new__(cls): return super().__new__(cls, G@)\nbox@ = Box@()\n"
            "def law@(): return box@ + 0.0",
        ],
        ["G@ = 3.0"],
    ),
    "__slots__ with a state": (
        [
            "class Box@:\n    __slots__ = ('gain', 'x')\n"
            "    def __init__(self): self.gain = 2.0\n"
            "    def __getstate__(self): return (None, {'gain': 2.0})\nbox@ = Box@()\n"
            "def law@(): return box@.gain",
        ],
        ["box@.gain = 3.0"],
    ),
    "__reduce__ that leaves out": (
        [
            "class Box@:\n    def __init__(self, gain=2.0): self.gain = gain\n"
            "    def __reduce__(self): return (Box@, ())\nbox@ = Box@()\n"
            "def law@(): return box@.gain",
        ],
        ["box@.gain = 3.0"],
    ),
    "__eq__ that is always true": (
        [
            "class K@(float):\n    def __eq__(self, other): return True\n"
            "    __hash__ = float.__hash__\nG@ = K@(2.0)\ndef law@(): return G@ + 0.0",
        ],
        ["G@ = K@(3.0)"],
    ),
    "class of an object replaced": (
        [
            "class A@:\n    gain = 2.0\nclass B@:\n    gain = 3.0\nbox@ = A@()\n"
            "def law@(): return box@.gain",
        ],
        ["box@.__class__ = B@"],
    ),
    "__dict__ of an object": (
        ["class Box@:\n    gain = 2.0\nbox@ = Box@()\ndef law@(): return box@.gain"],
        ["box@.__dict__['gain'] = 3.0"],
    ),
    "default of a named tuple": (
        ["class N@(typing.NamedTuple):\n    k: float = 2.0\ndef law@(): return N@().k"],
        ["N@.__new__.__defaults__ = (3.0,)"],
    ),
    "default of a data class": (
        ["@dataclasses.dataclass\nclass N@:\n    k: float = 2.0\ndef law@(): return N@().k"],
        ["N@.__init__.__defaults__ = (3.0,)"],
    ),
    "factory of a data class": (
        [
            "G@ = 2.0\n@dataclasses.dataclass\nclass N@:\n"
            "    k: float = dataclasses.field(default_factory=lambda: G@)\nn@ = N@()\n"
            "def law@(): return n@.k",
        ],
        ["G@ = 3.0"],
    ),
    "__post_init__": (
        [
            "G@ = 2.0\n@dataclasses.dataclass\nclass N@:\n    k: float = 1.0\n"
            "    def __post_init__(self): self.k = self.k * G@\nn@ = N@()\n"
            "def law@(): return n@.k",
        ],
        ["G@ = 3.0"],
    ),
    "default of the part": (
        [part("2.0")],
        ["P@.__init__ = lambda self, size=1.5: setattr(self, 'size', size)"],
    ),
    "default object of the part": (
        [part("self.k[0]", fields="\n    k = [2.0]\n")],
        ["P@.k[0] = 3.0"],
    ),
    "single dispatch registered later": (
        ["@functools.singledispatch\ndef f@(x): return 2.0\ndef law@(): return f@(1)"],
        ["@f@.register\ndef g@(x: int): return 3.0"],
    ),
    "single dispatch of a method": (
        [
            "class Box@:\n    @functools.singledispatchmethod\n    def f(self, x): return 2.0\n"
            "box@ = Box@()\ndef law@(): return box@.f(1)",
        ],
        ["Box@.__dict__['f'].register(int, lambda self, x: 3.0)"],
    ),
    "wrapped function replaced": (
        ["def f@(): return 2.0\n@functools.wraps(f@)\ndef law@(): return law@.__wrapped__()"],
        ["law@.__wrapped__ = lambda: 3.0"],
    ),
    "cached property": (
        [
            "class Box@:\n    g = 2.0\n    @functools.cached_property\n"
            "    def gain(self): return self.g\nbox@ = Box@()\nbox@.gain\n"
            "def law@(): return box@.gain",
        ],
        ["box@.g = 3.0"],
    ),
    "cache with an argument": (
        [
            "G@ = 2.0\n@functools.lru_cache(maxsize=None)\ndef f@(k): return G@ * k\nf@(1.0)\n"
            "def law@(): return f@(1.0)",
        ],
        ["G@ = 3.0"],
    ),
    "attrgetter": (
        [
            "import operator\nclass Box@:\n    a = 2.0\n    b = 3.0\n"
            "get@ = operator.attrgetter('a')\ndef law@(): return get@(Box@)",
        ],
        ["get@ = operator.attrgetter('b')"],
    ),
    "methodcaller": (
        [
            "import operator\nclass Box@:\n    def a(self, k): return k\n"
            "get@ = operator.methodcaller('a', 2.0)\ndef law@(): return get@(Box@())",
        ],
        ["get@ = operator.methodcaller('a', 3.0)"],
    ),
    "jax.tree_util.Partial": (
        ["def f@(a): return 2.0 * a\nlaw@ = jax.tree_util.Partial(f@, 1.0)"],
        ["def f@(a): return 3.0 * a"],
    ),
    "context variable": (
        [
            "import contextvars\nc@ = contextvars.ContextVar('c@', default=2.0)\n"
            "def law@(): return c@.get()",
        ],
        ["c@.set(3.0)"],
    ),
    "thread local": (
        [
            "import threading\nlocal@ = threading.local()\nlocal@.gain = 2.0\n"
            "def law@(): return local@.gain",
        ],
        ["local@.gain = 3.0"],
    ),
    "iterator": (
        ["it@ = iter([2.0, 3.0, 4.0, 5.0, 6.0, 7.0] * 9)\ndef law@(): return next(it@)"],
        ["next(it@)"],
    ),
    "generator": (
        [
            "def gen@():\n    k = 2.0\n    while True:\n        yield k\n        k += 1.0\n"
            "it@ = gen@()\ndef law@(): return next(it@)",
        ],
        ["next(it@)"],
    ),
    "generator of random numbers": (
        ["rng@ = np.random.default_rng(1)\ndef law@(): return rng@.random()"],
        ["rng@.random()"],
    ),
    "global random numbers": (
        ["import random\ndef law@(): return random.random()"],
        ["random.seed(3)"],
    ),
    "seeded global random numbers": (
        ["def law@():\n    np.random.seed(1)\n    return np.random.rand()"],
        ["np.random.seed(3)"],
    ),
    "time of day": (
        ["import time\ndef law@(): return time.time()"],
        ["pass"],
    ),
    "date": (
        ["import datetime\ndef law@(): return float(datetime.date.today().toordinal())"],
        ["pass"],
    ),
    "number of the process": (
        ["import os\ndef law@(): return float(os.getpid())"],
        ["pass"],
    ),
    "working folder": (
        ["import os\ndef law@(): return float(len(os.getcwd()))"],
        ["pass"],
    ),
    "host": (
        ["import socket\ndef law@(): return float(len(socket.gethostname()))"],
        ["pass"],
    ),
    "arguments of the process": (
        ["import sys\ndef law@(): return float(len(sys.argv[0]))"],
        ["pass"],
    ),
    "hash of a text": (
        ["def law@(): return float(hash('left') % 1000)"],
        ["pass"],
    ),
    "order of a set": (
        ["S@ = {'a%d' % k for k in range(9)}\ndef law@(): return float(list(S@)[0][1:])"],
        ["pass"],
    ),
    "order of a set in a function": (
        ["def law@(): return float(list({'a%d' % k for k in range(9)})[0][1:])"],
        ["pass"],
    ),
    "address of an object": (
        ["def law@(): return float(id(object()) % 1000003)"],
        ["pass"],
    ),
    "whether in a notebook": (
        ["def law@(): return 3.0 if 'get_ipython' in globals() else 2.0"],
        ["pass"],
    ),
    "whether in a kernel": (
        ["import sys\ndef law@(): return 3.0 if 'ipykernel' in sys.modules else 2.0"],
        ["pass"],
    ),
    "name of the module": (
        ["def law@(): return 3.0 if __name__ == '__main__' else 2.0"],
        ["pass"],
    ),
    "name of the class": (
        [part("float(len(type(self).__module__))")],
        ["pass"],
    ),
    "frames of the caller": (
        ["import sys\ndef law@(): return float(len(sys._getframe().f_back.f_globals))"],
        ["Q@ = 1"],
    ),
    "try of a name": (
        ["def law@():\n    try: return later@\n    except NameError: return 2.0"],
        ["later@ = 3.0"],
    ),
    "globals in a function": (
        ["def law@(): return globals().get('later@', 2.0)"],
        ["later@ = 3.0"],
    ),
    "eval": (
        ["G@ = 2.0\ndef law@(): return eval('G@')"],
        ["G@ = 3.0"],
    ),
    "vars of main": (
        ["import __main__\nG@ = 2.0\ndef law@(): return __main__.G@"],
        ["G@ = 3.0"],
    ),
    "weak reference": (
        [
            "import weakref\nclass Box@: gain = 2.0\nbox@ = Box@()\nref@ = weakref.ref(box@)\n"
            "def law@(): return 2.0 if ref@() is None else ref@().gain",
        ],
        ["del box@"],
    ),
    "default dict": (
        [
            "import collections\nd@ = collections.defaultdict(lambda: 2.0)\n"
            "def law@(): return d@['k']",
        ],
        ["d@.default_factory = lambda: 3.0; d@.clear()"],
    ),
    "deque": (
        ["import collections\nd@ = collections.deque([2.0])\ndef law@(): return d@[-1]"],
        ["d@.append(3.0)"],
    ),
    "chain map": (
        [
            "import collections\nA@ = {'k': 2.0}\nd@ = collections.ChainMap({}, A@)\n"
            "def law@(): return d@['k']",
        ],
        ["A@['k'] = 3.0"],
    ),
    "simple namespace": (
        ["import types\nn@ = types.SimpleNamespace(k=2.0)\ndef law@(): return n@.k"],
        ["n@.k = 3.0"],
    ),
    "mapping proxy": (
        [
            "import types\nD@ = {'k': 2.0}\nn@ = types.MappingProxyType(D@)\n"
            "def law@(): return n@['k']",
        ],
        ["D@['k'] = 3.0"],
    ),
    "subclass of a dict": (
        [
            "class D@(dict):\n    extra = 0.0\nd@ = D@(k=2.0)\n"
            "def law@(): return d@['k'] + d@.extra",
        ],
        ["d@.extra = 1.0"],
    ),
    "list that contains itself": (
        ["L@ = [2.0]\nL@.append(L@)\ndef law@(): return L@[1][0]"],
        ["L@[0] = 3.0"],
    ),
    "bytearray": (
        ["b@ = bytearray([2])\ndef law@(): return float(b@[0])"],
        ["b@[0] = 3"],
    ),
    "array.array": (
        ["import array\nb@ = array.array('d', [2.0])\ndef law@(): return b@[0]"],
        ["b@[0] = 3.0"],
    ),
    "memory view": (
        ["b@ = bytearray([2])\nm@ = memoryview(b@)\ndef law@(): return float(m@[0])"],
        ["b@[0] = 3"],
    ),
    "structured array": (
        [
            "K@ = np.zeros(2, dtype=[('a', float), ('b', float)])\nK@['a'] = 2.0\n"
            "def law@(): return K@['a'][0]",
        ],
        ["K@['a'] = 3.0"],
    ),
    "subclass of an array": (
        [
            "class A@(np.ndarray): pass\nK@ = np.zeros(2).view(A@)\nK@.gain = 2.0\n"
            "def law@(): return K@.gain",
        ],
        ["K@.gain = 3.0"],
    ),
    "masked array": (
        ["K@ = np.ma.array([2.0, 3.0], mask=[False, True])\ndef law@(): return float(K@.sum())"],
        ["K@.mask = False"],
    ),
    "object array": (
        ["K@ = np.array([[2.0], None], dtype=object)\ndef law@(): return K@[0][0]"],
        ["K@[0][0] = 3.0"],
    ),
    "strides of an array": (
        ["K@ = np.arange(4.0)\nV@ = K@[::2]\ndef law@(): return V@[1]"],
        ["V@ = K@[::3]"],
    ),
    "data frame": (
        [
            "import pandas as pd\nF@ = pd.DataFrame({'k': [2.0]})\n"
            "def law@(): return float(F@.k[0])",
        ],
        ["F@.loc[0, 'k'] = 3.0"],
    ),
    "data array": (
        ["import xarray as xr\nF@ = xr.DataArray([2.0])\ndef law@(): return float(F@[0])"],
        ["F@[0] = 3.0"],
    ),
    "spline": (
        [
            "from scipy.interpolate import CubicSpline\n"
            "f@ = CubicSpline([0.0, 1.0, 2.0], [2.0, 2.0, 2.0])\n"
            "def law@(): return float(f@(0.5))",
        ],
        ["f@.c[:] = 3.0"],
    ),
    "polynomial": (
        ["p@ = np.poly1d([2.0])\ndef law@(): return p@(0.0)"],
        ["p@.coeffs[0] = 3.0"],
    ),
    "fraction and decimal": (
        [
            "import decimal, fractions\nG@ = fractions.Fraction(1, 2)\n"
            "D@ = decimal.Decimal('1.5')\ndef law@(): return float(G@) + float(D@)",
        ],
        ["D@ = decimal.Decimal('2.5')"],
    ),
    "complex number": (
        ["G@ = 2j\ndef law@(): return abs(G@)"],
        ["G@ = 3j"],
    ),
    "time delta": (
        [
            "import datetime\nG@ = datetime.timedelta(seconds=2)\n"
            "def law@(): return G@.total_seconds()",
        ],
        ["G@ = datetime.timedelta(seconds=3)"],
    ),
    "compiled pattern": (
        [
            "import re\nG@ = re.compile('a+')\n"
            "def law@(): return 1.0 + len(G@.match('aab').group())",
        ],
        ["G@ = re.compile('a+b')"],
    ),
    "number as a text": (
        ["G@ = '2.0'\ndef law@(): return float(f'{G@}')"],
        ["G@ = '3.0'"],
    ),
    "range and slice": (
        ["s@ = slice(0, 1)\nr@ = range(2, 9)\ndef law@(): return float(r@[s@][0])"],
        ["s@ = slice(1, 2)"],
    ),
    "frozen set": (
        ["S@ = frozenset({1.0, 2.0})\ndef law@(): return sum(S@)"],
        ["S@ = frozenset({1.0, 3.0})"],
    ),
    "NaN": (
        ["G@ = float('nan')\ndef law@(): return 2.0 if G@ != G@ else 3.0"],
        ["G@ = 1.0"],
    ),
    "smallest change of a number": (
        ["G@ = 2.0\ndef law@(): return G@"],
        ["G@ = np.nextafter(2.0, 3.0)"],
    ),
    "integer or truth": (
        ["G@ = True\ndef law@(): return 3.0 if G@ is True else 2.0"],
        ["G@ = 1"],
    ),
    "type of an array": (
        ["G@ = np.ones(2)\ndef law@(): return float(G@.dtype.itemsize)"],
        ["G@ = G@.astype(np.float32)"],
    ),
    "32-bit number": (
        ["G@ = np.float32(0.1)\ndef law@(): return float(G@ * 3)"],
        ["G@ = 0.1"],
    ),
    "precision of JAX": (
        ["def law@(): return jnp.asarray(0.1) * 3.0"],
        ["pass"],
    ),
    "entry of sys.modules": (
        [
            "write('mod@.py', 'GAIN = 2.0\\n')\nimport mod@\ndef law@():\n    import mod@ as m\n"
            "    return m.GAIN",
        ],
        ["import sys, types\nsys.modules['mod@'] = types.SimpleNamespace(GAIN=3.0)"],
    ),
    "built-in replaced": (
        ["def law@(): return float(divmod(5, 2)[0])"],
        ["import builtins\n_divmod = divmod\nbuiltins.divmod = lambda x, y: (3.0, 0)"],
    ),
    "sys.path": (
        ["write('mod@.py', 'GAIN = 2.0\\n')\ndef law@():\n    import mod@\n    return mod@.GAIN"],
        [
            "import os, sys\nos.makedirs('other@', exist_ok=True)\n"
            "write('other@/mod@.py', 'GAIN = 3.0\\n')\nsys.path.insert(0, 'other@')",
        ],
    ),
    "star import hides a name": (
        ["G@ = 2.0\ndef law@(): return G@"],
        ["write('mod@.py', 'G@ = 3.0\\n')\nfrom mod@ import *"],
    ),
    "name deleted": (
        ["G@ = 2.0\ndef law@():\n    return G@ if 'G@' in globals() else 3.0"],
        ["del G@"],
    ),
    "own method replaced": (
        [part("self.law()", fields="\n    def law(self): return 2.0\n")],
        ["P@.law = lambda self: 3.0"],
    ),
    "own call wrapped": (
        [part("2.0")],
        ["_call@ = P@.__call__\nP@.__call__ = lambda self, *a: 1.5 * _call@(self, *a)"],
    ),
    "instance as the part": (
        [part("2.0 + getattr(self, 'extra', 0.0)")],
        [
            "_init@ = P@.__init__ if '__init__' in vars(P@) else None\n"
            "def init@(self, size=1.0): self.size = size; self.extra = 1.0\nP@.__init__ = init@",
        ],
    ),
    "annotations": (
        ["def law@(x: 2.0 = 1.0): return law@.__annotations__['x']"],
        ["law@.__annotations__['x'] = 3.0"],
    ),
    "documentation": (
        ["def law@():\n    '22'\n    return float(len(law@.__doc__))"],
        ["law@.__doc__ = '333'"],
    ),
    "name of a function": (
        ["def law@(): return float(len(law@.__name__))"],
        ["law@.__name__ = 'q'"],
    ),
    "line number": (
        ["import sys\ndef law@(): return float(sys._getframe().f_lineno)"],
        ["pass"],
    ),
    "alias in a closure cell": (
        [
            "def make@():\n    k = [2.0]\n    def get(): return k[0]\n    def put(x): k[0] = x\n"
            "    return get, put\nlaw@, put@ = make@()",
        ],
        ["put@(3.0)"],
    ),
    "closure cell": (
        ["def make@(k):\n    def get(): return k\n    return get\nlaw@ = make@(2.0)"],
        ["law@.__closure__[0].cell_contents = 3.0"],
    ),
    "staticmethod replaced": (
        ["class Box@:\n    @staticmethod\n    def f(): return 2.0\ndef law@(): return Box@.f()"],
        ["Box@.f = staticmethod(lambda: 3.0)"],
    ),
    "mixin order": (
        [
            "class A@:\n    gain = 2.0\nclass B@:\n    gain = 3.0\nclass C@(A@, B@): pass\n"
            "def law@(): return C@.gain",
        ],
        ["del A@.gain"],
    ),
    "abstract method filled later": (
        [
            "import abc\nclass A@(abc.ABC):\n    @abc.abstractmethod\n    def f(self): ...\n"
            "class B@(A@):\n    def f(self): return 2.0\n"
            "def law@(): return 2.0 if isinstance(3.0, A@) else 3.0",
        ],
        ["A@.register(float)"],
    ),
    "operator of a class": (
        [
            "class V@(float):\n    def __mul__(self, other): return 2.0\nG@ = V@(1.0)\n"
            "def law@(): return G@ * 5.0",
        ],
        ["V@.__mul__ = lambda self, other: 3.0"],
    ),
    "exception as a value": (
        [
            "class E@(Exception):\n    k = 2.0\ndef law@():\n    try: raise E@\n"
            "    except E@ as e: return e.k",
        ],
        ["E@.k = 3.0"],
    ),
    "match statement": (
        ["G@ = {'k': 2.0}\ndef law@():\n    match G@:\n        case {'k': v}: return v"],
        ["G@ = {'k': 3.0}"],
    ),
    "type alias and generic": (
        [
            "T@ = typing.TypeVar('T@')\nclass Box@(typing.Generic[T@]):\n    gain = 2.0\n"
            "def law@(): return Box@[int].gain",
        ],
        ["Box@.gain = 3.0"],
    ),
    "custom derivative": (
        [
            "@jax.custom_jvp\ndef f@(x): return 2.0 * x\n"
            "f@.defjvp(lambda p, t: (f@(p[0]), 7.0 * t[0]))\ndef law@(): return jax.grad(f@)(1.0)",
        ],
        ["f@.defjvp(lambda p, t: (f@(p[0]), 9.0 * t[0]))"],
    ),
    "default precision of matrices": (
        ["def law@(): return jnp.ones(3) @ jnp.full(3, 2.0)"],
        ["jax.config.update('jax_default_matmul_precision', 'float32')"],
    ),
    "equinox field": (
        ["class E@(eqx.Module):\n    k: float = 2.0\ne@ = E@()\ndef law@(): return e@.k"],
        ["e@ = E@(3.0)"],
    ),
    "equinox static field": (
        [
            "class E@(eqx.Module):\n    k: float = eqx.field(static=True, default=2.0)\n"
            "e@ = E@()\ndef law@(): return e@.k",
        ],
        ["e@ = eqx.tree_at(lambda e: e.k, e@, 3.0) if False else E@(3.0)"],
    ),
    "equinox converter": (
        [
            "G@ = 2.0\nclass E@(eqx.Module):\n"
            "    k: float = eqx.field(converter=lambda x: x * G@)\ne@ = E@(1.0)\n"
            "def law@(): return e@.k",
        ],
        ["G@ = 3.0"],
    ),
    "data of a closure in a partial": (
        [
            "def make@(k):\n    return functools.partial(lambda a, b: a * b, k)\n"
            "f@ = make@(2.0)\ndef law@(): return f@(1.0)",
        ],
        ["f@ = make@(3.0)"],
    ),
    "module attribute set from outside": (
        [
            "write('mod@.py', 'class C:\\n    gain = 2.0\\n')\nimport mod@\n"
            "def law@(): return mod@.C.gain",
        ],
        ["mod@.C.gain = 3.0"],
    ),
    "module of a module": (
        [
            "write('moda@.py', 'GAIN = 2.0\\n')\n"
            "write('modb@.py', 'import moda@\\ndef f(): return moda@.GAIN\\n')\nimport modb@\n"
            "def law@(): return modb@.f()",
        ],
        ["import moda@\nmoda@.GAIN = 3.0"],
    ),
    "object of a module": (
        [
            "write('mod@.py', 'class C:\\n    def __init__(self): self.k = 2.0\\n')\n"
            "from mod@ import C as C@\nc@ = C@()\ndef law@(): return c@.k",
        ],
        ["c@.k = 3.0"],
    ),
}
"""Name -> cells before the result is taken, cells that change something afterwards."""

UNDO = """
math.tau, np.pi, np.cos, jnp.cos = saved
if "_abs" in globals(): del abs, _abs
if "_divmod" in globals():
    builtins.divmod = _divmod
    del _divmod
jax.config.update("jax_default_matmul_precision", None)
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
