"""A second reading of a jaxpr: NumPy moves the numbers, libm gives the elementary functions.

It shares nothing with the emitter. All lanes of a batch go through together, first axis the lane;
both sides of a branch are computed and the right one is kept.
"""

import math

import numpy as np

SAME = ("copy", "copy_p", "stop_gradient", "optimization_barrier")


def libm(function):
    """An elementary function of the C library, number by number."""

    def careful(*values):
        try:
            return function(*values)
        except OverflowError:
            return math.inf
        except ValueError:
            return math.nan

    made = np.frompyfunc(careful, (function.__name__ in ("atan2", "pow", "fmod") and 2) or 1, 1)
    return lambda params, *arrays: made(*arrays).astype(float)


def largest(params, a, b):
    return np.where((a >= b) | np.isnan(a), a, b)


def smallest(params, a, b):
    return np.where((a <= b) | np.isnan(a), a, b)


def power(params, base):
    left, total = abs(params["y"]), None
    while left:
        if left % 2:
            total = base if total is None else total * base
        base, left = base * base, left // 2
    if total is None:
        return np.ones_like(base)
    return 1.0 / total if params["y"] < 0 else total


def joined(operation):
    def reduce(params, array):
        axes = tuple(axis + 1 for axis in params["axes"])
        rest = [k for k in range(array.ndim) if k not in axes]
        count = int(np.prod([array.shape[k] for k in axes]))
        rows = array.transpose([*rest, *axes]).reshape([*(array.shape[k] for k in rest), count])
        total = rows[..., 0]
        for k in range(1, count):
            total = operation(total, rows[..., k])
        return total

    return reduce


def dot(params, left, right):
    (left_axes, right_axes), batch = params["dimension_numbers"]
    assert batch == ((), ())
    assert (len(left_axes), len(right_axes)) == (1, 1)
    left = np.moveaxis(left, left_axes[0] + 1, -1)
    right = np.moveaxis(right, right_axes[0] + 1, -1)
    lanes, shape = len(left), (*left.shape[1:-1], *right.shape[1:-1])
    rows = left.reshape(lanes, -1, 1, left.shape[-1])
    columns = right.reshape(lanes, 1, -1, right.shape[-1])
    total = rows[..., 0] * columns[..., 0]
    for k in range(1, rows.shape[-1]):
        total = total + rows[..., k] * columns[..., k]
    return total.reshape(lanes, *shape)


def broadcast(params, array):
    shape = (len(array), *params["shape"])
    thin = [len(array)] + [1] * len(params["shape"])
    for axis, place in enumerate(params["broadcast_dimensions"]):
        thin[place + 1] = array.shape[axis + 1]
    return np.broadcast_to(array.reshape(thin), shape)


def cut(params, array):
    strides = params["strides"] or [1] * (array.ndim - 1)
    every = zip(params["start_indices"], params["limit_indices"], strides, strict=True)
    return array[(slice(None), *(slice(*each) for each in every))]


def pad(params, array, value):
    low_high = [(low, high) for low, high, inside in params["padding_config"] if inside == 0]
    assert len(low_high) == array.ndim - 1
    assert np.ptp(value) == 0.0
    return np.pad(array, [(0, 0), *low_high], constant_values=value.flat[0])


def dynamic_slice(params, array, *starts):
    sizes = params["slice_sizes"]
    made = np.empty((len(array), *sizes), array.dtype)
    for lane in range(len(array)):
        first = [
            min(max(int(start[lane]), 0), whole - size)
            for start, whole, size in zip(starts, array.shape[1:], sizes, strict=True)
        ]
        made[lane] = array[lane][tuple(slice(a, a + n) for a, n in zip(first, sizes, strict=True))]
    return made


def gather(params, array, indices):
    dimensions, sizes = params["dimension_numbers"], params["slice_sizes"]
    made = []
    for lane in range(len(array)):
        rows = np.empty(indices.shape[1:-1], object)
        for row in np.ndindex(rows.shape):
            first = [0] * len(sizes)
            for axis, start in zip(dimensions.start_index_map, indices[(lane, *row)], strict=True):
                first[axis] = min(max(int(start), 0), array.shape[axis + 1] - sizes[axis])
            part = array[lane][tuple(slice(a, a + n) for a, n in zip(first, sizes, strict=True))]
            rows[row] = part.squeeze(dimensions.collapsed_slice_dims)
        whole = np.array(rows.tolist())
        behind = range(whole.ndim - len(dimensions.offset_dims), whole.ndim)
        made.append(np.moveaxis(whole, list(behind), dimensions.offset_dims))
    return np.array(made)


def place_of(function):
    def find(params, array):
        assert array.ndim == 2
        return function(array, axis=1)

    return find


SIMPLE = {
    "add": lambda p, a, b: a + b,
    "add_any": lambda p, a, b: a + b,
    "sub": lambda p, a, b: a - b,
    "mul": lambda p, a, b: a * b,
    "div": lambda p, a, b: a / b,
    "neg": lambda p, a: -a,
    "abs": lambda p, a: np.abs(a),
    "sqrt": lambda p, a: np.sqrt(a),
    "rsqrt": lambda p, a: 1.0 / np.sqrt(a),
    "square": lambda p, a: a * a,
    "one_minus_square": lambda p, a: (1.0 + a) * (1.0 - a),
    "floor": lambda p, a: np.floor(a),
    "ceil": lambda p, a: np.ceil(a),
    "round": lambda p, a: np.rint(a),
    "sign": lambda p, a: np.where(a > 0, 1.0, np.where(a < 0, -1.0, a)),
    "max": largest,
    "min": smallest,
    "clamp": lambda p, low, a, high: smallest(p, largest(p, low, a), high),
    "lt": lambda p, a, b: a < b,
    "le": lambda p, a, b: a <= b,
    "gt": lambda p, a, b: a > b,
    "ge": lambda p, a, b: a >= b,
    "eq": lambda p, a, b: a == b,
    "ne": lambda p, a, b: a != b,
    "and": lambda p, a, b: a & b,
    "or": lambda p, a, b: a | b,
    "not": lambda p, a: ~a,
    "is_finite": lambda p, a: np.isfinite(a),
    "integer_pow": power,
    "logistic": lambda p, a: 1.0 / (1.0 + libm(math.exp)(p, -a)),
    "convert_element_type": lambda p, a: a.astype(p["new_dtype"]),
    "reduce_sum": joined(np.add),
    "reduce_prod": joined(np.multiply),
    "reduce_max": joined(lambda a, b: largest(None, a, b)),
    "reduce_min": joined(lambda a, b: smallest(None, a, b)),
    "reduce_and": joined(np.logical_and),
    "reduce_or": joined(np.logical_or),
    "argmax": place_of(np.argmax),
    "argmin": place_of(np.argmin),
    "dot_general": dot,
    "broadcast_in_dim": broadcast,
    "slice": cut,
    "pad": pad,
    "dynamic_slice": dynamic_slice,
    "gather": gather,
    "reshape": lambda p, a: a.reshape(len(a), *p["new_sizes"]),
    "squeeze": lambda p, a: a.squeeze(tuple(k + 1 for k in p["dimensions"])),
    "expand_dims": lambda p, a: np.expand_dims(a, tuple(k + 1 for k in p["dimensions"])),
    "transpose": lambda p, a: a.transpose([0, *(k + 1 for k in p["permutation"])]),
    "rev": lambda p, a: np.flip(a, tuple(k + 1 for k in p["dimensions"])),
    "concatenate": lambda p, *a: np.concatenate(a, p["dimension"] + 1),
    "stack": lambda p, *a: np.stack(a, p["axis"] + 1),
    **{
        name: libm(getattr(math, name))
        for name in (
            *("exp", "expm1", "log", "log1p", "sin", "cos", "tan", "asin", "acos", "atan", "sinh"),
            *("cosh", "tanh", "atan2", "pow"),
        )
    },
    "rem": libm(math.fmod),
}


BROADCAST = ("add", "add_any", "sub", "mul", "div", "lt", "le", "gt", "ge", "eq", "ne", "and", "or")


def interpret(closed, inputs):
    """Results of a closed jaxpr.

    Args:
        closed: the jaxpr.
        inputs: one array for each input, first axis the lane.
    """
    lanes, jaxpr, values = len(inputs[0]), closed.jaxpr, {}

    def every_lane(value):
        value = np.asarray(value)
        return np.broadcast_to(value, (lanes, *value.shape))

    def read(atom):
        return every_lane(atom.val) if hasattr(atom, "val") else values[atom]

    values.update(zip(jaxpr.constvars, map(every_lane, closed.consts), strict=True))
    values.update(zip(jaxpr.invars, inputs, strict=True))
    for equation in jaxpr.eqns:
        given = [read(atom) for atom in equation.invars]
        made = step(equation, given, lanes)
        for variable, array in zip(equation.outvars, made, strict=True):
            assert array.shape == (lanes, *variable.aval.shape), equation.primitive
        values.update(zip(equation.outvars, made, strict=True))
    return [read(atom) for atom in jaxpr.outvars]


def step(equation, given, lanes):
    name, params = equation.primitive.name, equation.params
    if name in SAME:
        return given
    if name in ("jit", "pjit"):
        return interpret(params["jaxpr"], given)
    if name in ("custom_jvp_call", "closed_call"):
        return interpret(params["call_jaxpr"], given)
    if name == "iota":
        every = np.indices(params["shape"])[params["dimension"]].astype(params["dtype"])
        return [np.broadcast_to(every, (lanes, *every.shape))]
    if name == "split":
        ends = np.cumsum(params["sizes"])[:-1]
        return np.split(given[0], ends, params["axis"] + 1)
    if name == "unstack":
        return [*np.moveaxis(given[0], params["axis"] + 1, 0)]
    if name == "select_n":
        which, no, yes = given
        return [np.where(which.reshape(which.shape + (1,) * (no.ndim - which.ndim)), yes, no)]
    if name == "scan":
        return scan(params, given)
    if name == "while":
        return passes(params, given)
    if name == "cond":
        index, *operands = given
        sides = [interpret(branch, operands) for branch in params["branches"]]
        index = np.clip(index, 0, len(sides) - 1)
        return [chosen(index, arrays) for arrays in zip(*sides, strict=True)]
    with np.errstate(all="ignore"):
        # a number may stand for an array of it
        if name in BROADCAST:
            most = max(array.ndim for array in given)
            given = [a.reshape(a.shape + (1,) * (most - a.ndim)) for a in given]
        return [SIMPLE[name](params, *given)]


def chosen(index, arrays):
    made = arrays[0]
    for k, array in enumerate(arrays):
        made = np.where((index == k).reshape(-1, *(1,) * (array.ndim - 1)), array, made)
    return made


def scan(params, given):
    fixed, carried = counts(params)
    state = fixed + carried
    constants, carry, rows = given[:fixed], given[fixed:state], given[state:]
    order = range(params["length"])
    made = {}
    for k in reversed(order) if params["reverse"] else order:
        results = interpret(params["jaxpr"], [*constants, *carry, *(row[:, k] for row in rows)])
        carry, made[k] = results[:carried], results[carried:]
    stacked = zip(*(made[k] for k in order), strict=True)
    return [*carry, *(np.stack(arrays, 1) for arrays in stacked)]


def counts(params):
    """Constants and carries of a scan, of JAX 0.10 and of the later ones."""
    if "num_consts" in params:
        return params["num_consts"], params["num_carry"]
    return tuple(len(part.vals) for part in params["ft_in"].unpack())[:2]


def passes(params, given):
    """Lanes that are done stand still while the others go on."""
    first, second = params["cond_nconsts"], params["cond_nconsts"] + params["body_nconsts"]
    tested, fixed, carry = given[:first], given[first:second], list(given[second:])
    going = interpret(params["cond_jaxpr"], [*tested, *carry])[0]
    while going.any():
        on = np.flatnonzero(going)
        after = interpret(params["body_jaxpr"], [a[on] for a in (*fixed, *carry)])
        carry = [np.array(a) for a in carry]
        for array, new in zip(carry, after, strict=True):
            array[on] = new
        going = going.copy()
        going[on] = interpret(params["cond_jaxpr"], [a[on] for a in (*tested, *carry)])[0]
    return carry
