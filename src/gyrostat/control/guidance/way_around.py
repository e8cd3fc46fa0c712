"""Ways around keep-out cones that are found when a turn starts: rotations by way of a waypoint.

A turn leads to its target, which may move, by three rotations from rest to rest: away from a body
that is too near at the start (otherwise by nothing), to a waypoint, to the target. Each is about
one axis of the target's frame. With the boresight b, the direction d of a body and the axis n, the
cosine of their angle during a rotation is A + B cos x + C sin x with A = (d n)(n b), B = d b - A
and C = d (n x b): its largest value between two angles has a closed form, without samples.

For one instrument and one body that rests in this frame, a way always exists if start and target
are outside of the cone: by a waypoint whose boresight points away from the body. Seen from the
point opposite to the body by stereographic projection, the cone is a disc about the origin, and a
circle through that point is a straight line. The boresight of any rotation to or from the waypoint
moves along such a circle, so that the shorter and the longer way around are the two rays from an
end outside of the disc along one line; at most one of them meets the disc.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from jaxtyping import Array, Bool, Float

from gyrostat.control.guidance.bodies import Bodies, Sky
from gyrostat.control.guidance.slew_profile import SlewProfile
from gyrostat.control.guidance.waypoints import Waypoints, across_to
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jax, jnp

PARTS = 8
"""Parts of equal time of a rotation; in each of them a cone is wider by the motion of its body."""
WIDER = 0.75
"""Angle by which a cone is wider in a part, over the way of its body in it: half of the way if the
body moved evenly along an arc."""
FINE_PARTS = 64
"""Parts of each rotation in which the way that is taken is tested: a target may sway within an
eighth of a rotation."""
BEYOND = 1e-3
"""Angle by which a turn leaves a cone beyond its edge, rad."""
TINY = 1e-9
"""Smallest angle of a rotation with an axis, rad."""


class Rotation(NamedTuple):
    """Rotation of a way.

    Attributes:
        turn: Rotation vector from its end to its start, (3,), rad.
        profile: Profile of its progress.
        excess: Largest cosine to a body less that of its cone, at most 0 if all are clear.
    """

    turn: Vector3
    profile: SlewProfile
    excess: Scalar


class Way(NamedTuple):
    """Rotations before the last one of a turn, and the last one.

    Attributes:
        turns: Rotation vectors from the end to the start of those before, (2, 3), rad.
        profiles: Their profiles, leading axis (2,).
        last: Rotation vector of the last one, from the target to its start, (3,), rad.
        profile: Its profile.
        blocked: What is not as it should be: 0 nothing; 1 a body may come too near on the way; 2 a
            body is too near at the start, which the turn leaves by the shortest way; 3 both.
    """

    turns: Float[Array, "2 3"]
    profiles: SlewProfile
    last: Vector3
    profile: SlewProfile
    blocked: Scalar

    @classmethod
    def straight(cls, turn: Vector3, profile: SlewProfile) -> "Way":
        """Way of one rotation."""
        zero = jnp.zeros(2)
        none = SlewProfile(zero, zero, zero, zero, zero)
        return cls(jnp.zeros((2, 3)), none, turn, profile, jnp.zeros(()))


class Start(NamedTuple):
    """Start of a turn.

    Attributes:
        offset: Attitude relative to the target, (4,).
        time: Time, s.
        profile: Function (rotation vector of the turn, attitude relative to the target at its
            start, time) -> its profile.
        wider: Angle by which all cones are wider, rad.
        margin: Part of it that a turn may lack at its start, as it leaves the cone there, rad.
    """

    offset: Quaternion
    time: Scalar
    profile: Callable[[Vector3, Quaternion, Scalar], SlewProfile]
    wider: Scalar
    margin: Scalar


def way_around(start: Start, bodies: Bodies) -> Way:
    """Shortest way of a fixed set; if none is clear, the one that enters a cone least.

    Args:
        start: Start of the turn.
        bodies: Cones.
    """
    leaving, first_test, too_near = _leaving(start, bodies)
    left = rotations.product(start.offset, rotations.from_rotation_vector(-leaving.turn))
    begin = start.time + leaving.profile.duration
    points = Waypoints.of(left, bodies, begin)
    target = jnp.array([1.0, 0.0, 0.0, 0.0])
    still = SlewProfile(*(jnp.zeros(()) for _ in SlewProfile._fields))
    none = Rotation(jnp.zeros(3), still, jnp.array(2.0))

    def leg(at: tuple[Quaternion, Scalar], end: Quaternion) -> tuple[Any, Rotation]:
        rotation = _rotation(start, bodies, at[0], end, at[1])
        return (end, at[1] + rotation.profile.duration), rotation

    def by(k: Any) -> Rotation:
        ends = jnp.stack([points(k), target])
        return jax.lax.scan(leg, (left, begin), ends)[1]

    def goes_on(state: tuple[Any, Any, Rotation]) -> Any:
        # generated code reports a loop that reaches its bound, which this one does not
        k, done, _ = state
        return jnp.logical_not(done) & (k <= points.number)

    def better(state: tuple[Any, Any, Rotation]) -> tuple[Any, Any, Rotation]:
        k, _, best = state
        best = _least(by(k), best)
        # the first way is that without a waypoint; it needs no other one if it is short and clear
        is_short = jnp.sum(best.turn**2) <= (jnp.pi + TINY) ** 2
        done = (k == 0) & is_short & (jnp.max(best.excess) <= 0.0)
        return k + 1, done | (k + 1 == points.number), best

    first = jax.tree.map(lambda each: jnp.stack([each, each]), none)
    begins = jnp.zeros((), dtype=int), jnp.array(False), first
    *_, found = jax.lax.while_loop(goes_on, better, begins)
    every = jax.tree.map(lambda one, both: jnp.stack([one, *both]), leaving, found)
    excess = jnp.maximum(jnp.max(found.excess), _tested(start, bodies, every, left, first_test))
    blocked = jnp.where(excess <= 0.0, 0.0, 1.0) + jnp.where(too_near, 2.0, 0.0)
    before, last = (jax.tree.map(lambda x, at=at: x[at], every) for at in (slice(2), 2))
    return Way(before.turn, before.profile, last.turn, last.profile, blocked)


def _least(found: Rotation, best: Rotation) -> Rotation:
    """Better one of two ways, each of two rotations."""
    # of ways that take the same time the first one, whatever the rounding
    is_better = _cost(found) < (1.0 - 1e-9) * _cost(best)
    return jax.tree.map(lambda one, other: jnp.where(is_better, one, other), found, best)


def _cost(ways: Rotation) -> Scalar:
    """Duration of a clear way, s; of others a greater number, by their excess."""
    excess = jnp.max(ways.excess)
    time = jnp.sum(jnp.asarray(ways.profile.duration))
    return jnp.where(excess <= 0.0, time, 1e12 * (1.0 + jnp.maximum(excess, 0.0)))


def _rotation(
    start: Start, bodies: Bodies, origin: Quaternion, end: Quaternion, time: Scalar
) -> Rotation:
    """Shorter rotation between two attitudes, or the longer one if that is nearer to be clear.

    Args:
        start: Start of the turn.
        bodies: Cones.
        origin: Attitude relative to the target at its start, (4,).
        end: Attitude at its end, (4,).
        time: Time of its start, s.
    """
    turn = rotations.rotation_vector(rotations.error(origin, end))
    angle = jnp.sqrt(turn @ turn)
    # a rotation by nothing has no longer way
    longer = jnp.where(angle > TINY, 1.0 - 2.0 * jnp.pi / jnp.maximum(angle, TINY), 1.0)

    def along(share: Scalar) -> Rotation:
        way = share * turn
        profile = _profile(start, way, origin, time)
        return Rotation(way, profile, _excess(start, bodies, way, end, profile, time))

    both = jax.lax.map(along, jnp.stack([jnp.ones(()), longer]))
    takes_longer = (both.excess[1] < both.excess[0]) & (both.excess[0] > 0.0)
    return jax.tree.map(lambda each: jnp.where(takes_longer, each[1], each[0]), both)


def _profile(start: Start, turn: Vector3, origin: Quaternion, time: Scalar) -> SlewProfile:
    """Profile of a rotation; a rotation by nothing takes no time."""
    found = start.profile(-turn, origin, time)
    turns = jnp.where(turn @ turn > TINY**2, 1.0, 0.0)
    return SlewProfile(found.angle, found.acceleration, *(turns * each for each in found[2:]))


def _excess(
    start: Start,
    bodies: Bodies,
    turn: Vector3,
    end: Quaternion,
    profile: SlewProfile,
    time: Scalar,
    parts: int = PARTS,
    counts: Any = True,
) -> Scalar:
    """Largest cosine to a body less that of its cone during a rotation; see `Rotation`."""
    size = jnp.sqrt(turn @ turn)
    axis = turn / jnp.maximum(size, TINY)
    step = profile.duration / parts
    boresights = bodies.boresights
    along, across = boresights @ axis, jnp.cross(axis, boresights)

    def part(k: Any, state: tuple[Scalar, Sky, Scalar]) -> tuple[Scalar, Sky, Scalar]:
        most, before, high = state
        since = (k + 1.0) * step
        after, low = bodies.at(time + since), size * (1.0 - profile.progress(since))
        angles = jnp.maximum(after.angles, before.angles)
        moved = jax.vmap(rotations.angle_between)(after.directions, before.directions)
        middle = jax.vmap(lambda each: rotations.to_body(end, rotations.normalised(each)))
        seen = middle(before.directions + after.directions)
        constant = along[:, None] * (seen @ axis)
        cosine, sine = boresights @ seen.T - constant, across @ seen.T
        ends = [constant + cosine * jnp.cos(x) + sine * jnp.sin(x) for x in (low, high)]
        top = jnp.arctan2(sine, cosine)
        top = jnp.where(top < 0.0, top + 2.0 * jnp.pi, top)
        passed = constant + jnp.sqrt(cosine**2 + sine**2)
        largest = jnp.where((top >= low) & (top <= high), passed, jnp.maximum(*ends))
        excess = largest - jnp.cos(jnp.minimum(angles + start.wider + WIDER * moved, jnp.pi))
        worst = jnp.max(jnp.where(counts & (angles > 0.0), excess, -1.0))
        return jnp.maximum(most, worst), after, low

    begin = -jnp.ones(()), bodies.at(time), size
    return jax.lax.fori_loop(0, parts, part, begin)[0]


def _tested(
    start: Start, bodies: Bodies, every: Rotation, left: Quaternion, first_test: tuple[Array, Array]
) -> Scalar:
    """Largest excess of the rotations of a way, in `FINE_PARTS` of each.

    Args:
        start: Start of the turn.
        bodies: Cones.
        every: Rotations, leading axis (3,).
        left: Attitude relative to the target after the first one, (4,).
        first_test: During the first one, whether each cone counts, and the angle by which it is
            wider, rad, (instruments, bodies).
    """

    def leg(time: Scalar, each: Any) -> tuple[Scalar, Scalar]:
        (turn, profile, _), end, counts, wider = each
        widened = start._replace(wider=wider)
        excess = _excess(widened, bodies, turn, end, profile, time, FINE_PARTS, counts)
        return time + profile.duration, excess

    ends = jnp.stack([left, rotations.from_rotation_vector(every.turn[2]), jnp.eye(4)[0]])
    counts, wider = first_test
    counts = jnp.stack([counts, *2 * [jnp.ones_like(counts)]])
    wider = jnp.stack([wider, *2 * [start.wider * jnp.ones_like(wider)]])
    return jnp.max(jax.lax.scan(leg, start.time, (every, ends, counts, wider))[1])


def _leaving(start: Start, bodies: Bodies) -> tuple[Rotation, tuple[Array, Array], Bool[Array, ""]]:
    """Rotation by which the boresight leaves the nearest body.

    Returns:
        Rotation, without its excess; `first_test` of `_tested`; whether a body is too near at the
        start.
    """
    boresights = jax.vmap(lambda each: rotations.to_inertial(start.offset, each))(bodies.boresights)
    directions, angles = bodies.at(start.time)
    while_turning = start.profile(boresights[0], start.offset, start.time).duration
    later = bodies.at(start.time + while_turning).directions
    from_body = jax.vmap(jax.vmap(rotations.angle_between, (None, 0)), (0, None))
    distance = jnp.where(angles > 0.0, from_body(boresights, directions), jnp.inf)
    drift = jnp.asarray(jax.vmap(rotations.angle_between)(directions, later))
    depth = jnp.where(angles > 0.0, angles + start.wider - distance, -1.0)
    worst = jnp.argmax(depth)
    count = len(directions)
    instrument, body = worst // count, worst % count
    deepest = jnp.maximum(depth.ravel()[worst], 0.0)
    # beyond the edge by the way of the body in the time of a turn by 1 rad
    angle = jnp.where(deepest > 0.0, deepest + drift[body] + BEYOND, 0.0)
    angle = jnp.minimum(angle, jnp.pi - jnp.minimum(distance.ravel()[worst], jnp.pi))
    normal = jnp.cross(directions[body], boresights[instrument])
    size = jnp.sqrt(normal @ normal)
    normal = jnp.where(
        size > TINY, normal / jnp.maximum(size, TINY), across_to(boresights[instrument])
    )
    turn = -angle * rotations.to_body(start.offset, normal)
    profile = _profile(start, turn, start.offset, start.time)
    too_near = jnp.any(distance < angles)
    is_worst = jnp.arange(depth.size).reshape(depth.shape) == worst
    counts = (angle > 0.0) & jnp.logical_not(is_worst & too_near)
    wider = start.wider - jnp.where(is_worst, start.margin, 0.0)
    return Rotation(turn, profile, -jnp.ones(())), (counts, wider), too_near
