"""Rows of the regression of a wheel in a window, and what is estimated from them."""

from dataclasses import dataclass, replace

from gyrostat.core.types import Matrix, Vector
from gyrostat.monitoring.moments import Prior
from gyrostat.monitoring.noise import Noise


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows of the regression of one wheel, one per block, times the sign of the speed.

    Attributes:
        time: Middle of the block, (N,), s.
        white: Variance of the white noise over that of a block of usual length, (N,).
        response: Drive, (N,), A.
        regressors: (N, P).
        instruments: (N, P).
        lag_noise: Noise with the variance of that of the regressor of the lag, and of that of its
            instrument, (N, 2).
        start: Start of the window, s.
        end: End of the window, s.
    """

    time: Vector
    white: Vector
    response: Vector
    regressors: Matrix
    instruments: Matrix
    lag_noise: Matrix
    start: float
    end: float


@dataclass(frozen=True, eq=False)
class Estimate:
    """Estimate of a window. The order of the parameters is that of `moments`.

    Attributes:
        value: Parameters, (P,); the Coulomb torque is its long-run level.
        covariance: (P, P).
        scatter: Part of the covariance that differs from window to window, (P, P).
        mean: Realised mean of the Coulomb torque, N·m.
        mean_covariance: Its covariance with the parameters, (P,).
        mean_variance: Its variance.
        mean_scatter: Part of this variance that differs from window to window.
        noise: Most likely noise.
        noise_sigma: Standard deviation of the slow noise, N·m.
        white_sigma: Standard deviation of the white noise of a block, A.
        beta: Coefficients at the most likely noise, (P,).
        prior: What was known beforehand, without what the data clearly contradict.
        held: Places of the parameters that hold as known beforehand, as rounding leaves them more
            open.
    """

    value: Vector
    covariance: Matrix
    scatter: Matrix
    mean: float
    mean_covariance: Vector
    mean_variance: float
    mean_scatter: float
    noise: Noise
    noise_sigma: float
    white_sigma: float
    beta: Vector
    prior: Prior
    held: tuple[int, ...] = ()

    def with_errors(
        self, moved: Matrix, mean_moved: Vector, *, lasting: bool = False
    ) -> "Estimate":
        """Estimate with further independent errors.

        Args:
            moved: What one sigma of each moves the parameters by, (P, M).
            mean_moved: What it moves the mean of the Coulomb torque by, (M,).
            lasting: Whether they are the same in each window.
        """
        added, mean_added = moved @ moved.T, float(mean_moved @ mean_moved)
        share = 0.0 if lasting else 1.0
        return replace(
            self,
            covariance=self.covariance + added,
            scatter=self.scatter + share * added,
            mean_covariance=self.mean_covariance + moved @ mean_moved,
            mean_variance=self.mean_variance + mean_added,
            mean_scatter=self.mean_scatter + share * mean_added,
        )
