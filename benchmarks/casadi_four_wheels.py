"""Four wheels with minimax allocation, fault detector and Kalman filter, in CasADi.

The controller `four_wheels` of `controller_programs.py`: `gyrostat.estimation.AttitudeFilter` with
`gyrostat.control.WheelArrayControl`, without null space and unloading. Parameters are constants.
"""

import itertools

import casadi as ca
import numpy as np

OPTIONS = {"cse": True}
SMALL = 1e-4


def product(p, q):
    """Product of quaternions."""
    vector = p[0] * q[1:] + q[0] * p[1:] + ca.cross(p[1:], q[1:])
    return ca.vertcat(p[0] * q[0] - ca.dot(p[1:], q[1:]), vector)


def conjugate(q):
    """Inverse rotation."""
    return ca.vertcat(q[0], -q[1:])


def normalised(q):
    """Quaternion of unit length."""
    return q / ca.sqrt(ca.dot(q, q))


def to_inertial(q, vector):
    """Vector in inertial axes."""
    twice = 2 * ca.cross(q[1:], vector)
    return vector + q[0] * twice + ca.cross(q[1:], twice)


def from_rotation_vector(vector):
    """Quaternion of a rotation vector."""
    squared = ca.dot(vector, vector)
    near = squared < SMALL**2
    angle = ca.sqrt(ca.if_else(near, 1, squared))
    scale = ca.if_else(near, 0.5 - squared / 48, ca.sin(0.5 * angle) / angle)
    return ca.vertcat(ca.if_else(near, 1 - squared / 8, ca.cos(0.5 * angle)), scale * vector)


def rotation_vector(q):
    """Rotation vector of a quaternion."""
    q = ca.if_else(q[0] < 0, -q, q)
    squared = ca.dot(q[1:], q[1:])
    near = squared < SMALL**2
    length = ca.sqrt(ca.if_else(near, 1, squared))
    return ca.if_else(near, 2 + squared / 3, 2 * ca.atan2(length, q[0]) / length) * q[1:]


def error(q, target):
    """Rotation from target to attitude, with a scalar part of at least 0."""
    turn = product(conjugate(target), q)
    return ca.if_else(turn[0] < 0, -turn, turn)


def inverse(matrix):
    """Inverse of a matrix, (3, 3), by an embedded function of scalars."""
    sym = ca.SX.sym("matrix", 3, 3)
    return ca.Function("inverse", [sym], [ca.inv_minor(sym)], OPTIONS)(matrix)


def largest_of(values, rows):
    """Row of the largest value, the first of equal ones."""
    best, row = values[0], rows[0]
    for value, other in zip(values[1:], rows[1:], strict=True):
        better = value > best
        best, row = ca.if_else(better, value, best), ca.if_else(better, other, row)
    return row


class Reader:
    """Parts of a vector, in their order."""

    def __init__(self, vector):
        self.vector, self.place = vector, 0

    def __call__(self, size=1):
        self.place += size
        return self.vector[self.place - size : self.place]


def predicted(q, bias, covariance, last, rate, c):
    """Attitude, covariance and turn after a period."""
    period = c["period"]
    integral = period * (rate - bias)
    turn = integral + ca.cross(last, integral) / 12
    step, skew, unit = from_rotation_vector(turn), ca.skew(turn), ca.DM.eye(3)
    squared = ca.dot(turn, turn)
    mean = unit - (0.5 - squared / 24) * skew + (1 - squared / 20) / 6 * (skew @ skew)
    matrix = ca.horzcat(*(to_inertial(step, unit[:, k]) for k in range(3)))
    forward = ca.blockcat([[matrix.T, -period * mean], [ca.DM(3, 3), unit]])
    walk = c["bias_walk"] ** 2 * period
    angle, cross = c["angle_walk"] ** 2 * period + walk * period**2 / 3, -0.5 * walk * period
    noise = ca.DM(np.kron([[angle, cross], [cross, walk]], np.eye(3)))
    after = forward @ covariance @ forward.T + noise
    return normalised(product(q, step)), 0.5 * (after + after.T), integral


def corrected(q, bias, covariance, started, attitude, measured, c):
    """Estimate after a sample of the star tracker."""
    noise = c["attitude_sigma"] ** 2 * ca.DM.eye(3)
    innovation = rotation_vector(error(attitude, q))
    information = inverse(covariance[:3, :3] + noise)
    gain = covariance[:, :3] @ information
    rest = ca.DM.eye(6) - ca.horzcat(gain, ca.DM(6, 3))
    change = gain @ innovation
    after = rest @ covariance @ rest.T + gain @ noise @ gain.T
    surprise = ca.dot(innovation, information @ innovation)
    new = [
        normalised(product(q, from_rotation_vector(change[:3]))), bias + change[3:],
        ca.vec(0.5 * (after + after.T)), innovation, surprise, 1,
    ]  # fmt: skip
    start = ca.diag(ca.DM([c["attitude_sigma"] ** 2] * 3 + [c["bias_sigma"] ** 2] * 3))
    first = [attitude, ca.DM(3, 1), ca.vec(ca.densify(start)), ca.DM(3, 1), 0, 1]
    old = [q, bias, ca.vec(covariance), ca.DM(3, 1), 0, started]
    begun = ca.if_else(started, ca.vertcat(*new), ca.densify(ca.vertcat(*first)))
    return ca.if_else(measured, begun, ca.densify(ca.vertcat(*old)))


def decided(share, axes, limit, normals, usable):
    """Load all wheels to the level of the normal that needs the highest one."""
    given, rest, unknown = share
    values, rows = [], []
    for normal, use in zip(normals, usable, strict=True):
        length = ca.sqrt(ca.dot(normal, normal))
        real = ca.logic_and(use, length > 1e-6)
        normal = ca.if_else(real, 1 / ca.if_else(real, length, 1), 0) * normal
        heights = ca.if_else(unknown, axes.T @ normal, 0)
        heights = ca.if_else(ca.fabs(heights) > 1e-6, heights, 0)
        reach = ca.dot(ca.fabs(heights), limit)
        bounds = ca.logic_and(real, reach > 0)
        level = ca.dot(normal, rest) / ca.if_else(bounds, reach, 1)
        values.append(ca.if_else(bounds, 1 + ca.fabs(level), ca.if_else(real, length, 0) / 2))
        rows.append(ca.vertcat(level, ca.sign(heights), normal))
    row = largest_of(values, rows)
    level, sense, normal = row[0], row[1:5], row[5:]
    torque = level * limit * sense
    return (given + torque, rest - axes @ torque, ca.logic_and(unknown, sense == 0)), normal


def allocated(axes, limit, works, torque):
    """Minimax allocation."""
    pairs = list(itertools.combinations(range(4), 2))
    normals = [ca.cross(axes[:, i], axes[:, j]) for i, j in pairs]
    usable = [ca.logic_and(works[i], works[j]) for i, j in pairs]
    share, plane = decided((ca.DM.zeros(4), torque, works), axes, limit, normals, usable)
    normals = [ca.cross(plane, axes[:, k]) for k in range(4)]
    share, _ = decided(share, axes, limit, normals, [share[2][k] for k in range(4)])
    given, rest, unknown = share
    weight = unknown * limit
    line = largest_of([weight[k] for k in range(4)], [axes[:, k] for k in range(4)])
    along = axes.T @ line
    total = ca.dot(weight, ca.fabs(along))
    level = ca.dot(rest, line) / ca.if_else(total > 0, total, 1)
    return given + level * weight * ca.sign(along)


def pseudo_inverse(axes, works):
    """Pseudo-inverse of the working axes."""
    columns = axes @ ca.diag(works)
    square = columns @ columns.T
    projector = 1e-10 * inverse(square + 1e-10 * ca.DM.eye(3))
    return columns.T @ inverse(square + projector @ projector)


def law(kind, c):
    """Function: attitude, its derivative and limits -> rate and its derivative."""
    q, slope, slowing, fastest = (kind.sym(n, s) for n, s in zip("qsdf", (4, 4, 1, 1), strict=True))
    vector = rotation_vector(error(q, ca.DM([1, 0, 0, 0])))
    angle = ca.sqrt(ca.dot(vector, vector) + 1e-24)
    gain = c["turn_gain"]
    speed = gain * angle / ca.sqrt(1 + ca.fabs(angle) * gain**2 / (2 * slowing))
    rate = -vector / angle * ca.fmin(speed, fastest)
    results = [rate, ca.jtimes(rate, q, slope)]
    return ca.Function("law", [q, slope, slowing, fastest], results, OPTIONS)


def target_rate(inner, q, rate, wheel_speed, momentum, works, c):
    """Commanded rate and its derivative along the motion."""
    inertia, axes, limit = ca.DM(c["inertia"]), ca.DM(c["axes"]), ca.DM(c["wheel_torque_limit"])
    across = pseudo_inverse(axes, works)
    vector = rotation_vector(error(q, ca.DM([1, 0, 0, 0])))
    axis = vector / ca.sqrt(ca.dot(vector, vector) + 1e-24)

    def largest(direction, limit):
        return ca.mmin(limit / ca.fmax(ca.fabs(across @ direction), 1e-12))

    slowing = 0.5 * largest(inertia @ axis, limit)
    turning = 0.4 * largest(ca.cross(momentum, axis), limit)
    resting = works * c["rotor"] * wheel_speed + across @ (inertia @ rate)
    room = ca.fmax(c["momentum_limit"] - ca.fabs(resting), 0)
    fastest = ca.fmin(turning, ca.fmax(largest(inertia @ axis, room), 1e-4))
    fastest = ca.fmin(fastest, c["largest_rate"])
    slope = 0.5 * product(q, ca.vertcat(0, rate))
    return law(inner, c)(q, slope, slowing, fastest)


def commanded(inner, memory, q, rate, wheel_speed, wheel_measured, c):
    """Memory of the controller and torques; see `WheelArrayControl`."""
    period, axes, inertia = c["period"], ca.DM(c["axes"]), ca.DM(c["inertia"])
    limit, rotor = ca.DM(c["wheel_torque_limit"]), ca.DM(c["rotor"])
    samples, sent, in_space, unknown, begun = memory(), memory(3), memory(3), memory(3), memory()
    memory()  # the period
    before, torque, drag, lost = (memory(4) for _ in range(4))
    works, detecting, wear = memory(4), memory(), memory(4)
    relative = rotor * wheel_speed
    absolute = relative + rotor * (axes.T @ rate)
    momentum = inertia @ rate + axes @ absolute
    valid = ca.logic_and(detecting, wheel_measured)
    loss = torque - (absolute - before) / period
    lost = lost + period / (5 + period) * ca.if_else(valid, loss - lost, 0)
    drag = drag + period / (10 + period) * ca.if_else(valid, loss - drag, 0)
    drag = ca.if_else(works, ca.fmin(ca.fmax(drag, -limit / 2), limit / 2), 0)
    wanted, change = target_rate(inner, q, rate, wheel_speed, momentum, works, c)
    now = to_inertial(q, momentum)
    mean = to_inertial(conjugate(q), now - in_space) / period
    share = ca.if_else(begun, period / (20 + period), 0)
    unknown = unknown + share * (mean - sent - unknown)
    push = change + c["rate_gain"] * (wanted - rate)
    failed = ca.logic_and(ca.logic_not(works), wheel_measured)
    bearing = axes @ ca.if_else(failed, lost, 0)
    demand = unknown + bearing - ca.cross(rate, momentum) - inertia @ push
    available = limit - ca.fabs(drag)
    torque = allocated(axes, available, works, demand)
    torque = torque / ca.fmax(ca.mmax(ca.fabs(torque) / available), 1) + drag
    upper = ca.fmax(c["momentum_limit"] - relative, 0) / period
    lower = ca.fmin(-c["momentum_limit"] - relative, 0) / period
    torque = ca.fmin(ca.fmax(torque, lower), upper)
    later = [samples + 1, ca.DM.zeros(3), now, unknown, 1, period, absolute, torque, drag, lost]
    return [*later, works, 1, wear], torque, works


def four_wheels(kind, inner, c):
    """Function: memory and measurement -> memory and command, in the order of the leaves."""
    memory, measurement = kind.sym("memory", 89), kind.sym("measurement", 16)
    state, sample = Reader(memory), Reader(measurement)
    q, bias, covariance = state(4), state(3), ca.reshape(state(36), 6, 6)
    state(4)  # innovation and surprise
    started, last = state(), state(3)
    attitude, measured, rate, wheel_speed, wheel_measured = map(sample, (4, 1, 3, 4, 4))
    q, covariance, turn = predicted(q, bias, covariance, last, rate, c)
    estimate = corrected(q, bias, covariance, started, attitude, measured, c)
    part = Reader(estimate)
    q, bias, variance, innovation = part(4), part(3), part(36), part(4)
    rate = rate - bias
    later, torque, works = commanded(inner, state, q, rate, wheel_speed, wheel_measured, c)
    after = ca.vertcat(estimate, turn, *later, c["period"])
    sigma = ca.sqrt(ca.vertcat(variance[0], variance[7], variance[14]))
    parts = [torque, ca.DM.zeros(3), ca.DM([1, 0, 0, 0]), works, q, rate, bias, sigma, innovation]
    results = [ca.densify(after), ca.densify(ca.vertcat(*parts))]
    return ca.Function("step", [memory, measurement], results, OPTIONS)
