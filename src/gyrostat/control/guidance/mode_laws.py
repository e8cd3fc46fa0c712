"""Controllers of which the mode of the reference chooses one."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Bool, Float

from gyrostat.control.guidance.guide import Guide
from gyrostat.control.guidance.guided import toward
from gyrostat.control.missing_sample import predicted
from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, declared_units
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.named_tuples import with_fields


class ModeLawsMemory(NamedTuple):
    """State of controllers in modes between two samples.

    Attributes:
        laws: Memory of each controller.
        works: Whether each wheel works, as the last active controller with `works` said.
    """

    laws: tuple[Any, ...]
    works: Bool[Array, " wheels"]


class ModeLaws(Checked):
    """Controllers of which the mode of the reference chooses one.

    The command has the fields of all of them. Those that the active one does not have are zero;
    `works` is what the last one that has it said, `target` that of the reference. The memory of a
    controller that is not active goes on as at a missing sample, with the command that is sent.

    Attributes:
        laws: Controllers.
        chosen: Number of the controller of each mode, (modes,).
        follows: Whether each controller follows the reference; the others do not get it.
        wheels: Number of wheels.
        guide: Reference at the sample, see `toward`.
    """

    laws: tuple[Any, ...]
    chosen: Float[Array, " modes"]
    follows: tuple[bool, ...] = eqx.field(static=True)
    wheels: int = eqx.field(static=True)
    guide: Guide | None = None

    def toward(self, guide: Guide) -> "ModeLaws":
        """Controllers that follow a reference."""
        laws = tuple(
            toward(law, guide) if follows else law
            for law, follows in zip(self.laws, self.follows, strict=True)
        )
        return replace(self, laws=laws, guide=guide)

    def start(self, period: Scalar) -> ModeLawsMemory:
        """Initial memory."""
        laws = tuple(law.start(period) for law in self.laws)
        return ModeLawsMemory(laws, jnp.ones(self.wheels, bool))

    def predicted(self, memory: ModeLawsMemory, measurement: Any, command: Any) -> ModeLawsMemory:
        """Memory of each controller after a period without a sample.

        Args:
            memory: Memory from the last sample.
            measurement: Last accepted measurement.
            command: Command that is sent.
        """
        pairs = zip(self.laws, memory.laws, strict=True)
        laws = tuple(predicted(law, each, measurement, command) for law, each in pairs)
        return memory._replace(laws=laws)

    def __call__(self, memory: ModeLawsMemory, measurement: Any) -> tuple[ModeLawsMemory, Any]:
        """Compute the command of the active controller."""
        assert self.guide is not None
        active = jnp.asarray(self.chosen)[self.guide.at.mode.number]
        is_active = [active == number for number in range(len(self.laws))]
        blank = self._blank(memory, measurement)
        command, after = blank, []
        for law, before, acts in zip(self.laws, memory.laws, is_active, strict=True):
            result = before, command

            def compute(law: Any = law, result: Any = result) -> Any:
                later, of_law = law(result[0], measurement)
                return later, blank._replace(**of_law._asdict())

            later, command = jax.lax.cond(acts, _as(result, compute), lambda result=result: result)
            after.append(later)
        later = [
            jax.lax.cond(
                acts,
                lambda computed=computed: computed,
                _as(computed, lambda law=law, old=old: predicted(law, old, measurement, command)),
            )
            for law, old, computed, acts in zip(
                self.laws, memory.laws, after, is_active, strict=True
            )
        ]
        return ModeLawsMemory(tuple(later), getattr(command, "works", memory.works)), command

    def _blank(self, memory: ModeLawsMemory, measurement: Any) -> Any:
        """Command with the fields of all controllers, with what stands for those that lack it."""
        assert self.guide is not None
        kinds = [
            jax.eval_shape(law, each, measurement)[1]
            for law, each in zip(self.laws, memory.laws, strict=True)
        ]
        fields: dict[str, Any] = {}
        units: dict[str, str] = {}
        for kind in kinds:
            units |= declared_units(type(kind))
            fields |= {n: v for n, v in kind._asdict().items() if n not in fields}
        special: Mapping[str, Callable[[Any], Any]] = {
            "works": lambda _: memory.works,
            "target": lambda _: self.guide.now.attitude,  # pyright: ignore[reportOptionalMemberAccess]
        }
        values = {
            name: special.get(name, lambda shape: jnp.zeros(shape.shape, shape.dtype))(shape)
            for name, shape in fields.items()
        }
        first = type(kinds[0])
        added = {n: v for n, v in values.items() if n not in first._fields}
        base = first(*(values[name] for name in first._fields))
        if not added:
            return base
        return with_fields("InModes", base, added, {n: units[n] for n in added if n in units})


def _as(like: Any, function: Callable[[], Any]) -> Callable[[], Any]:
    """Function whose results have the types of an example."""
    return lambda: jax.tree.map(
        lambda value, example: jnp.asarray(value, jnp.result_type(example)), function(), like
    )
