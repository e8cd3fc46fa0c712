"""What can be compiled, for many runs or for flight: primitives of JAX, and traced functions."""

from types import SimpleNamespace
from typing import Any

from jax.extend.core import primitives

from gyrostat.codegen.composed import COMPOSED
from gyrostat.codegen.lower import Lowering
from gyrostat.codegen.rules import RULES
from gyrostat.codegen.scope import Scope
from gyrostat.codegen.simd.batch_scope import BATCH
from gyrostat.codegen.simd.inputs import inputs_of
from gyrostat.codegen.source import UnsupportedError
from gyrostat.codegen.tracing import CALLS
from gyrostat.core.jax64 import Tracer


def compiled_primitives() -> dict[str, tuple[bool, bool]]:
    """Primitives of JAX -> whether many runs and whether flight code can be compiled with them."""
    all_names = {getattr(primitives, name).name for name in dir(primitives) if name.endswith("_p")}
    common = RULES.keys() | COMPOSED.keys() | CALLS.keys()
    native = common | BATCH.rules.keys()
    return {name: (name in native, name in common) for name in sorted(all_names | native)}


def unsupported(closed: Any, scope: Scope) -> UnsupportedError | None:
    """First operation of a jaxpr that cannot be compiled; None if there is none.

    Args:
        closed: Closed jaxpr. Constants that are values of an outer trace are taken as arguments.
        scope: Limits on what may be compiled.
    """
    jaxpr, inputs, constants = closed.jaxpr, [*closed.jaxpr.invars], []
    for variable, value in zip(jaxpr.constvars, closed.consts, strict=True):
        if isinstance(value, Tracer):
            inputs.append(variable)
        else:
            constants.append((variable, value))
    body = SimpleNamespace(
        invars=inputs,
        constvars=[variable for variable, _ in constants],
        eqns=jaxpr.eqns,
        outvars=jaxpr.outvars,
    )
    function = SimpleNamespace(jaxpr=body, consts=[value for _, value in constants])
    try:
        # parameters that are the same in all runs and those that are not are compiled alike
        arguments = inputs_of([variable.aval for variable in inputs], [True] * len(inputs))
        Lowering(scope).graph(function, arguments, [])
        for atom in jaxpr.outvars:
            if scope.kind_of(atom.aval.dtype) is None:
                what = f"numbers of type {atom.aval.dtype}"
                raise UnsupportedError(f"result: found {what}, expected float64", what)
    except UnsupportedError as error:
        return error
    return None
