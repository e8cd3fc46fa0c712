"""Controllers of which the mode of the reference chooses one."""

from collections.abc import Callable, Mapping
from typing import Any

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.control.guidance.guide import Guide
from gyrostat.control.guidance.guided import toward
from gyrostat.control.missing_sample import predicted
from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, declared_units
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.named_tuples import with_fields


class ModeLaws(Checked):
    """Controllers of which the mode of the reference chooses one.

    The command has the fields of all of them. Those that the active one does not have are zero;
    `works` is true for every wheel, `target` that of the reference. The memory of a controller that
    is not active goes on as at a missing sample, with the command that is sent.

    Attributes:
        laws: Controllers.
        chosen: Number of the controller of each mode, (modes,).
        follows: Whether each controller follows the reference; the others do not get it.
        guide: Reference at the sample, see `toward`.
    """

    laws: tuple[Any, ...]
    chosen: Float[Array, " modes"]
    follows: tuple[bool, ...] = eqx.field(static=True)
    guide: Guide | None = None

    def toward(self, guide: Guide) -> "ModeLaws":
        """Controllers that follow a reference."""
        laws = tuple(
            toward(law, guide) if follows else law
            for law, follows in zip(self.laws, self.follows, strict=True)
        )
        return ModeLaws(laws, self.chosen, self.follows, guide)

    def start(self, period: Scalar) -> tuple[Any, ...]:
        """Initial memory of each controller."""
        return tuple(law.start(period) for law in self.laws)

    def predicted(self, memory: tuple[Any, ...], measurement: Any, command: Any) -> tuple[Any, ...]:
        """Memory of each controller after a period without a sample.

        Args:
            memory: Memory of each controller.
            measurement: Last accepted measurement.
            command: Command that is sent.
        """
        pairs = zip(self.laws, memory, strict=True)
        return tuple(predicted(law, each, measurement, command) for law, each in pairs)

    def __call__(self, memory: tuple[Any, ...], measurement: Any) -> tuple[tuple[Any, ...], Any]:
        """Compute the command of the active controller."""
        assert self.guide is not None
        active = jnp.asarray(self.chosen)[self.guide.at.mode.number]
        is_active = [active == number for number in range(len(self.laws))]
        blank = self._blank(memory, measurement)
        command, after = blank, []
        for law, before, acts in zip(self.laws, memory, is_active, strict=True):
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
            for law, old, computed, acts in zip(self.laws, memory, after, is_active, strict=True)
        ]
        return tuple(later), command

    def _blank(self, memory: tuple[Any, ...], measurement: Any) -> Any:
        """Command with the fields of all controllers, each zero."""
        assert self.guide is not None
        kinds = [
            jax.eval_shape(law, each, measurement)[1]
            for law, each in zip(self.laws, memory, strict=True)
        ]
        fields: dict[str, Any] = {}
        units: dict[str, str] = {}
        for kind in kinds:
            units |= declared_units(type(kind))
            fields |= {n: v for n, v in kind._asdict().items() if n not in fields}
        special: Mapping[str, Callable[[Any], Any]] = {
            "works": lambda shape: jnp.ones(shape.shape, shape.dtype),
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
