"""The controllers of `controller_programs.py` in CasADi, and their C.

    PYTHON benchmarks/casadi_controllers.py CONSTANTS.npz FOLDER

PYTHON has CasADi (`pip install casadi`) and needs nothing of gyrostat. CONSTANTS.npz has the
constants of the controllers, which `casadi_peer.py` writes. For each controller and variant, writes
FOLDER/NAME.VARIANT.c with the function `step`. Variants: `sx`, one graph of scalars with common
subexpressions eliminated; `mx`, a graph of matrices; `mixed`, matrices with functions of scalars in
it, as CasADi's documentation recommends. Every input and output is a dense vector.
"""

import sys
from pathlib import Path

import casadi as ca
import numpy as np
from casadi_four_wheels import four_wheels

OPTIONS = {"cse": True}


def product(p, q):
    """Product of quaternions."""
    vector = p[0] * q[1:] + q[0] * p[1:] + ca.cross(p[1:], q[1:])
    return ca.vertcat(p[0] * q[0] - ca.dot(p[1:], q[1:]), vector)


def conjugate(q):
    """Inverse rotation."""
    return ca.vertcat(q[0], -q[1:])


def rotation(vector):
    """Quaternion of a rotation vector."""
    half = 0.5 * ca.sqrt(ca.dot(vector, vector) + 1e-30)
    return ca.vertcat(ca.cos(half), 0.5 * ca.sin(half) / half * vector)


def small(vector):
    """Quaternion of a small rotation, to first order."""
    return ca.vertcat(1, 0.5 * vector)


def moved(kind, period):
    """Function: state and rate -> attitude after a period, derivative of the error."""
    q, calibration, rate = kind.sym("q", 4), kind.sym("calibration", 12), kind.sym("rate", 3)
    error = kind.sym("error", 15)
    bias, scale = calibration[:3], calibration[3:6]
    turn = period * (rate * (1 - scale) - bias)
    change = rate * (scale + error[6:9]) + bias + error[3:6]
    true = product(small(error[:3]), rotation(period * (rate - change)))
    angle = 2 * product(conjugate(rotation(turn)), true)[1:]
    slope = ca.jacobian(ca.vertcat(angle, error[3:]), error)
    slope = ca.substitute(slope, error, kind.zeros(15))
    results = [product(q, rotation(turn)), slope]
    return ca.Function("moved", [q, calibration, rate], results, OPTIONS)


def seen(kind):
    """Function: attitude, calibration and sensors -> innovation, derivative of the measurements."""
    q, calibration, error = kind.sym("q", 4), kind.sym("calibration", 12), kind.sym("error", 15)
    measured = [kind.sym("attitude", 4), kind.sym("field", 3), kind.sym("model", 3)]
    misalignment, offset = calibration[6:9], calibration[9:]
    true = product(q, small(error[:3]))
    both = product(true, small(misalignment + error[9:12]))
    predicted = product(q, small(misalignment))
    angle = 2 * product(conjugate(predicted), both)[1:]
    pure = ca.vertcat(0, measured[2])
    field = product(product(conjugate(true), pure), true)[1:] + offset + error[12:]
    slope = ca.substitute(ca.jacobian(ca.vertcat(angle, field), error), error, kind.zeros(15))
    difference = product(conjugate(predicted), measured[0])
    angle = 2 * ca.sign(difference[0]) * difference[1:]
    field = measured[1] - ca.substitute(field, error, kind.zeros(15))
    return ca.Function(
        "seen", [q, calibration, *measured], [ca.vertcat(angle, field), slope], OPTIONS
    )


def kalman_filter(kind, inner, constants):
    """Filter of 15 states.

    Args:
        kind: SX or MX, of the matrices.
        inner: SX or MX, of the models.
        constants: `period`, `gyro` and `sensors`.
    """
    state, sensors = kind.sym("state", 241), kind.sym("sensors", 13)
    attitude, calibration = state[:4], state[4:16]
    covariance = ca.reshape(state[16:], 15, 15)
    attitude, forward = moved(inner, constants["period"])(attitude, calibration, sensors[:3])
    covariance = forward @ covariance @ forward.T + ca.diag(constants["gyro"])
    model = seen(inner)
    innovation, slope = model(attitude, calibration, sensors[3:7], sensors[7:10], sensors[10:])
    noise = ca.DM(ca.diag(constants["sensors"]))
    across = slope @ covariance
    gain = solved(kind, across @ slope.T + noise, across).T
    change = gain @ innovation
    rest = ca.DM.eye(15) - gain @ slope
    covariance = rest @ covariance @ rest.T + gain @ noise @ gain.T
    attitude = product(attitude, rotation(change[:3]))
    covariance = 0.5 * (covariance + covariance.T)
    result = ca.vertcat(
        attitude / ca.sqrt(ca.dot(attitude, attitude)), calibration + change[3:], ca.vec(covariance)
    )
    return ca.Function("step", [state, sensors], [ca.densify(result)], OPTIONS)


def solved(kind, matrix, right):
    """Solution of a positive definite system of equations."""
    if kind is ca.MX:
        return ca.solve(matrix, right, "ldl")
    root = ca.chol(matrix)
    return ca.solve(root, ca.solve(root.T, right))


def model_predictive(kind, inner, constants):
    """Projected gradient steps; with MX a function that is called again and again."""
    hessian, linear = ca.DM(constants["hessian"]), ca.DM(constants["linear"])
    size = hessian.shape[0]
    plan, slope = inner.sym("plan", size), inner.sym("slope", size)
    lower = plan - constants["step_size"] * (hessian @ plan + slope)
    lower = ca.fmin(ca.fmax(lower, -1), 1)
    descend = ca.Function("descend", [plan, slope], [lower], OPTIONS)
    old, motion = kind.sym("old", size), kind.sym("motion", 6)
    start, slope = ca.vertcat(old[3:], old[-3:]), linear @ motion
    count = int(constants["iterations"])
    if kind is ca.MX:
        plan = descend.fold(count)(start, ca.repmat(slope, 1, count))
    else:
        plan = start
        for _ in range(count):
            plan = descend(plan, slope)
    torque = constants["torque_limit"] * plan[:3]
    return ca.Function("step", [old, motion], [plan, torque], OPTIONS)


CONTROLLERS = {"filter": kalman_filter, "mpc": model_predictive, "four_wheels": four_wheels}
VARIANTS = {"sx": (ca.SX, ca.SX), "mx": (ca.MX, ca.MX), "mixed": (ca.MX, ca.SX)}


def main():
    constants, folder = np.load(sys.argv[1]), Path(sys.argv[2]).resolve()
    for name, controller in CONTROLLERS.items():
        for variant, (kind, inner) in VARIANTS.items():
            function = controller(kind, inner, constants)
            file = f"{name}_{variant}"
            generator = ca.CodeGenerator(file, {"casadi_int": "int"})
            generator.add(function)
            generator.generate(f"{folder}/")


if __name__ == "__main__":
    main()
