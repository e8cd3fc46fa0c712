"""Kalman filter of the speed error of a wheel under random torques.

The speed error x of a wheel, a random-walk torque u and the torque ripple b at its last start from
zero speed obey, from sample to sample,
    x' = f x + g u + h b + v,   u' = u + w,   b' = k b + c,
with the transition f and the gains g and h of each interval of the exact prediction. The variance
of v has a part that scales with the ripple and a fixed part. A state is (x, u, b), each of any
shape; a covariance is (xx, xu, uu, xb, ub, bb), each a number or one for each of several noise
levels. Squared levels are those of (ripple, random walk).
"""

from typing import Any

State = tuple[Any, Any, Any]
Covariance = tuple[Any, Any, Any, Any, Any, Any]


def first_covariance(first: Any, squared: Any) -> Covariance:
    """Covariance at the first sample.

    Args:
        first: Variance of u and b at level one, (2,), (N·m)².
        squared: Squared levels.
    """
    zero = 0.0 * squared[0]
    return (zero, zero, first[0] * squared[1], zero, zero, first[1] * squared[0])


def corrected(covariance: Covariance, weight: Any) -> tuple[State, Covariance]:
    """Gains of a measurement of x, and the covariance after it.

    Args:
        covariance: Before the measurement.
        weight: Inverse of the variance of the prediction error; zero where nothing is measured.
    """
    xx, xu, uu, xb, ub, bb = covariance
    kx, ku, kb = xx * weight, xu * weight, xb * weight
    after = (xx - kx * xx, xu - kx * xu, uu - ku * xu, xb - kx * xb, ub - ku * xb, bb - kb * xb)
    return (kx, ku, kb), after


def predicted(
    state: State, covariance: Covariance, interval: Any, squared: Any
) -> tuple[State, Covariance]:
    """State and covariance one sample later.

    Args:
        state: After the measurement.
        covariance: After the measurement.
        interval: Row of `TorqueNoise.intervals`, (8,).
        squared: Squared levels.
    """
    f, g, h, k, crossing, walk, renewal, fixed = (interval[index] for index in range(8))
    x, u, b = state
    xx, xu, uu, xb, ub, bb = covariance
    # covariances of the new x with the old u and b
    from_u, from_b = f * xu + g * uu + h * ub, f * xb + g * ub + h * bb
    ahead = f * (f * xx + g * xu + h * xb) + g * from_u + h * from_b + crossing * squared[0] + fixed
    after = (ahead, from_u, uu + walk * squared[1], k * from_b, k * ub)
    return (f * x + g * u + h * b, u, k * b), (*after, k * k * bb + renewal * squared[0])
