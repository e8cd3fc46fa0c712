"""Functions that are traced once: their numbers are the same, and a user's part is traced anew."""

from pathlib import Path

import equinox as eqx
import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit
from gyrostat.control.guidance import Reference
from gyrostat.core import traced_once as module
from gyrostat.core.arrays import Scalar
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import to_body, to_inertial
from gyrostat.core.traced_once import method_traced_once, one_function, traced_once
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import ViscousCoulomb


def test_a_program_gives_the_numbers_of_the_plain_function():
    def turned(convert):
        def program(attitude, vector):
            return jax.vmap(convert, (None, 0))(attitude, jnp.stack([vector, 2.0 * vector]))

        return program

    attitude, vector = np.array([0.5, 0.5, -0.5, 0.5]), np.arange(3.0)
    for convert in (to_body, to_inertial):
        programs = [turned(convert), turned(convert.__wrapped__)]
        first, second = (jax.jit(each)(attitude, vector) for each in programs)
        np.testing.assert_array_equal(first, second)


def test_shapes_that_are_known_are_not_traced_again():
    traces = []

    @traced_once
    def doubled(vector):
        traces.append(vector.shape)
        return 2.0 * vector

    for _ in range(3):
        jax.make_jaxpr(lambda vector: doubled(doubled(vector)))(np.ones(3))
    jax.make_jaxpr(doubled)(np.ones(2))
    assert traces == [(3,), (2,)]


class Holder(eqx.Module):
    """Object with a part."""

    part: Wheel | Scalar

    def value(self, scale):
        TRACES.append(scale)
        return scale * jnp.sum(jnp.stack(jax.tree.leaves(self.part)))


TRACES = []


@pytest.mark.parametrize(("of_this_package", "count"), [(True, 1), (False, 3)])
def test_an_object_with_a_part_of_a_user_is_traced_anew(monkeypatch, of_this_package, count):
    friction = ViscousCoulomb(viscous=2e-6, coulomb=1e-3)
    wheel = jax.tree.map(jnp.asarray, Wheel(1.5e-3, 0.02, friction))
    if of_this_package:
        monkeypatch.setattr(Holder, "__module__", "gyrostat.holder")
    module._is_shipped.cache_clear()
    value = method_traced_once(Holder.value)
    TRACES.clear()
    for _ in range(3):
        result = jax.jit(lambda wheel: value(Holder(wheel), wheel.inertia))(wheel)
    assert len(TRACES) == count
    assert result == pytest.approx(1.5e-3 * sum(jax.tree.leaves(wheel)))
    module._is_shipped.cache_clear()


def test_numbers_that_a_program_knows_are_not_made_variables():
    value = method_traced_once(Holder.value)
    traced = jax.make_jaxpr(lambda scale: value(Holder(2.0), scale))(3.0)
    plain = jax.make_jaxpr(lambda scale: Holder.value(Holder(2.0), scale))(3.0)
    assert str(traced) == str(plain)


class Turning(eqx.Module):
    """Attitude over time of a user, with an `if` of a Python float."""

    rate: float

    def __call__(self, time):
        if self.rate > 0.0:
            return jnp.array([jnp.cos(time), 0.0, 0.0, jnp.sin(time)])
        return jnp.array([1.0, 0.0, 0.0, 0.0])


def test_an_if_in_a_user_s_profile_is_one_line_that_says_where():
    reference = Reference.of(Turning(0.1))
    line = next(
        k
        for k, text in enumerate(Path(__file__).read_text().splitlines(), 1)
        if "if self.rate > 0.0" in text
    )
    with pytest.raises(InputError) as caught:
        reference.at(reference.start(), 1.0)
    message = str(caught.value)
    assert f"__call__ (test_traced_once.py, line {line}): found an if" in message
    assert "in `if self.rate > 0.0:`, expected jnp.where(condition, a, b)" in message
    assert "\n" not in message


class Law(eqx.Module):
    """Law whose torque is one function of C."""

    gain: Scalar

    @one_function
    def torque(self, angle):
        return jnp.sin(self.gain * angle)


def test_a_call_in_c_has_the_line_that_calls_not_that_of_the_decorator():
    def step(law, angle):
        first = law.torque(angle)
        return law.torque(first)

    given = {"law": Law(np.ones(())), "angle": np.ones(())}
    text = emit("law", [Entry("step", step, given, ("value",))]).source
    assert text.count("static double torque(") == 1
    assert "test_traced_once.py" in text
    assert "first = law.torque(angle)" in text
    assert "traced_once.py" not in text.replace("test_traced_once.py", "")
