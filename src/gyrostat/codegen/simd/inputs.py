"""Inputs of a program for SIMD lanes, and their places in the memory of the inputs."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from gyrostat.codegen.arrays import Data, data_or_scalars
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import Assign, Block, Name, Table, statements
from gyrostat.codegen.simd.batch_scope import LARGEST, batch_kind
from gyrostat.codegen.source import UnsupportedError


def inputs_of(avals: Iterable[Any], own: Sequence[bool]) -> list[Scalars | Data]:
    """Inputs, without parameters for the elements of large ones.

    Args:
        avals: Shape and type of each.
        own: For each, whether it differs between runs.

    Raises:
        UnsupportedError: A type is not supported.
    """
    words = [0, 0]
    inputs = []
    for aval, each in zip(avals, own, strict=True):
        kind = batch_kind(aval.dtype)
        if kind is None:
            what = f"numbers of type {aval.dtype}"
            raise UnsupportedError(f"argument: found {what}, expected float64 ones", what)
        indices = np.arange(int(np.prod(aval.shape))).reshape(aval.shape)
        table = Table(kind, indices.size, memory="own" if each else "shared", start=words[each])
        # a logical value in memory is a mask
        data = Data(table, indices)
        inputs.append(data.scalars() if kind == "logical" else data_or_scalars(data))
        words[each] += indices.size
    return inputs


def parameters_of(
    inputs: Sequence[Scalars | Data], own: Sequence[bool], body: Block
) -> tuple[dict[Name, int], dict[Name, int]]:
    """Parameters shared by all runs, and those that differ between runs, with their places.

    Args:
        inputs: Inputs.
        own: For each, whether it differs between runs.
        body: Program that reads them.
    """
    read = {s.table for s in statements(body) if isinstance(s, Assign)}
    words = [0, 0]
    parameters: tuple[dict[Name, int], dict[Name, int]] = ({}, {})
    for array, each in zip(inputs, own, strict=True):
        if isinstance(array, Data) and array.size <= LARGEST and array.table not in read:
            array.scalars()  # only read at known indices: a list of parameters
        names = array.table.parameters if isinstance(array, Data) else dict(enumerate(array.flat))
        parameters[each].update({names[k]: words[each] + k for k in sorted(names)})
        words[each] += array.size
    return parameters
