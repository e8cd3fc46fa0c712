"""Averaging over effects outside the friction model: its parts against dense algebra."""

import dataclasses

import numpy as np
import pytest
from scipy.special import beta
from scipy.stats import multivariate_normal

from gyrostat.core.units import RPM
from gyrostat.identification import identify, rounds
from gyrostat.identification.fit.least_squares import Prior
from gyrostat.identification.fit.prediction import Linearisation, SpeedPrediction
from gyrostat.identification.fit.stages import run_stages
from gyrostat.identification.uncertainty.averaging import Effect, average
from gyrostat.identification.uncertainty.corrections import corrections
from gyrostat.identification.uncertainty.effects import RIPPLES, Nuisance, accumulated
from gyrostat.identification.uncertainty.hypotheses import Segment
from gyrostat.identification.uncertainty.innovations import innovations
from gyrostat.identification.uncertainty.torque_noise import TorqueNoise
from gyrostat.wheel.friction import Stribeck

INERTIA = 1.5e-3


def linear_record(count=40, seed=0):
    """A small linearisation with a wheel that sticks once, and its torque noise."""
    random = np.random.default_rng(seed)
    transition = random.uniform(0.8, 1.0, count - 1)
    transition[count // 2] = 0.0
    linear = Linearisation(
        speed=random.standard_normal(count),
        jacobian=random.standard_normal((count, 2)),
        transition=transition,
        local=random.standard_normal((count - 1, 2)),
    )
    noise = TorqueNoise(
        gain=random.uniform(0.5, 1.0, count - 1),
        crossings=random.uniform(0.0, 4.0, count - 1),
        walk=random.uniform(0.0, 2.0, count - 1),
        first=3.0,
        starts=random.uniform(-1.0, 1.0, count - 1),
        kept=random.uniform(0.0, 1.0, count - 1),
        ripple=2.0,
        fixed=random.uniform(0.0, 0.5, count - 1),
    )
    return linear, noise


def dense_covariance(linear, noise, levels, variance):
    """Covariance of the residuals, from the equations of the state written out in full."""
    count = len(variance)
    sources = 4 * (count - 1) + 2
    x, u, b = (np.zeros((count, sources)) for _ in range(3))
    u[0, -1] = levels[1] * np.sqrt(noise.first)
    b[0, -2] = levels[0] * np.sqrt(noise.ripple)
    for k in range(count - 1):
        x[k + 1] = linear.transition[k] * x[k] + noise.gain[k] * u[k] + noise.starts[k] * b[k]
        x[k + 1, k] += levels[0] * np.sqrt(noise.crossings[k])
        x[k + 1, 3 * (count - 1) + k] += np.sqrt(noise.fixed[k])
        u[k + 1] = u[k]
        u[k + 1, count - 1 + k] += levels[1] * np.sqrt(noise.walk[k])
        b[k + 1] = noise.kept[k] * b[k]
        renewed = noise.ripple * (1.0 - noise.kept[k] ** 2)
        b[k + 1, 2 * (count - 1) + k] += levels[0] * np.sqrt(renewed)
    return x @ x.T + np.diag(variance)


def test_prediction_errors_are_those_of_the_dense_covariance():
    linear, noise = linear_record()
    random = np.random.default_rng(1)
    columns = random.standard_normal((40, 3))
    variance = random.uniform(0.5, 2.0, 40)
    variance[7] = np.inf
    levels = np.array([[0.0, 0.0], [0.3, 0.0], [0.1, 0.2]])
    found = innovations([columns], variance, linear.transition, noise, levels)
    seen = np.isfinite(variance)
    assert found.samples == 39
    for level, products, logs in zip(levels, *found[:2], strict=True):
        full = dense_covariance(linear, noise, level, np.where(seen, variance, 0.0))
        full = full[np.ix_(seen, seen)]
        np.testing.assert_allclose(
            products, columns[seen].T @ np.linalg.solve(full, columns[seen]), rtol=1e-10, atol=1e-10
        )
        assert logs == pytest.approx(np.linalg.slogdet(full)[1], rel=1e-10)


def test_a_long_record_in_parts_gives_the_same(monkeypatch):
    linear, noise = linear_record(count=300, seed=5)
    random = np.random.default_rng(6)
    columns = [random.standard_normal((300, 2)), random.standard_normal((300, 9))]
    variance = random.uniform(0.5, 2.0, 300)
    levels = np.array([[0.0, 0.0], [0.1, 0.2]])
    given = (variance, linear.transition, noise, levels)
    whole, rows = innovations(columns, *given), accumulated(linear, linear.local)
    first = innovations(columns, *given[:-1], levels[:1])
    joined = first.with_levels(innovations(columns, *given[:-1], levels[1:]))
    monkeypatch.setattr("gyrostat.identification.uncertainty.innovations.LONGEST", 128)
    monkeypatch.setattr("gyrostat.identification.uncertainty.effects.LONGEST", 128)
    for found in (joined, innovations(columns, *given)):
        np.testing.assert_allclose(found.products, whole.products, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(found.log_variance, whole.log_variance, rtol=1e-12)
        assert found.samples == 300
    np.testing.assert_allclose(accumulated(linear, linear.local), rows, rtol=1e-12, atol=1e-15)


def test_the_average_is_the_mixture_of_all_hypotheses_computed_densely():
    linear, noise = linear_record(seed=3)
    random = np.random.default_rng(4)
    effect = Nuisance("lag", "lag", "s", (0.5, 2.0), (random.standard_normal((40, 1)),))
    about = random.standard_normal((40, 2))
    further = Nuisance("wave", "wave", "s", (2.0,), (about,), beside="lag")
    residual = random.standard_normal(40) + 1.5 * effect.columns[0][:, 0]
    prior = Prior(np.array([0.2, -0.1]), np.array([0.7, 3.0]))
    x = np.array([0.5, 0.4])
    segment = Segment(residual, linear.jacobian, linear, noise, 1.0, np.ones(40))
    scale = np.array([2.0, 5.0])
    effects = [effect, further]
    found = average([segment], effects, prior, x, scale, stated=True)

    weights, means, covariances = [], [], []
    for ripple in (0.0, *RIPPLES):
        for walk in (0.0, *RIPPLES):
            base = dense_covariance(linear, noise, (ripple, walk), np.ones(40))
            # the second effect is present or not at the scale of the first
            for spread, wide in ((0.0, 0.0), (0.5, 0.0), (2.0, 0.0), (2.0, 2.0)):
                full = base + spread**2 * effect.columns[0] @ effect.columns[0].T
                full += wide**2 * about @ about.T
                shape = linear.jacobian
                before = np.diag(prior.sigma**2)
                offset = prior.mean - x
                marginal = full + shape @ before @ shape.T
                present = (ripple > 0.0, walk > 0.0, spread > 0.0)
                chance = beta(sum(present) + 0.5, 3 - sum(present) + 0.25)
                chance *= np.prod(np.where(present, (1 / 3, 1 / 3, 1 / 2), 1.0))
                chance *= 4.0 if ripple == 0.1 else 1.0
                normal = multivariate_normal(shape @ offset, marginal)
                weights.append(np.log(chance) + normal.logpdf(residual))
                inverse = np.linalg.inv(before) + shape.T @ np.linalg.solve(full, shape)
                right = np.linalg.solve(before, offset)
                right += shape.T @ np.linalg.solve(full, residual)
                means.append(np.linalg.solve(inverse, right))
                covariances.append(np.linalg.inv(inverse))
    weight = np.exp(np.array(weights) - max(weights))
    weight /= weight.sum()
    mean = weight @ np.array(means)
    apart = np.array(means) - mean
    covariance = np.einsum("h,hij->ij", weight, np.array(covariances))
    covariance += np.einsum("h,hi,hj->ij", weight, apart, apart)
    # hypotheses of negligible weight are left out
    np.testing.assert_allclose(found.shift, mean, rtol=1e-6)
    np.testing.assert_allclose(found.covariance, covariance, rtol=1e-6)
    # in a fine record the odds of a wheel without ripple fall as the square of the resolution
    still = np.repeat([True, False, False, False], len(weight) // 4)
    fine = average([segment], effects, prior, x, scale, stated=True, resolution=0.004)
    less = np.where(still, 0.04, 1.0) * weight
    np.testing.assert_allclose(fine.shift, less @ np.array(means) / less.sum(), rtol=1e-6)
    ripple = next(e for e in fine.effects if e.name == "crossing_ripple")
    assert ripple.probability == pytest.approx(1.0 - less[still].sum() / less.sum(), rel=1e-6)

    absent = np.tile([True, False, False, False], len(weight) // 4)
    assert found.effects[0].probability == pytest.approx(weight[~absent].sum(), rel=1e-6)


def test_a_certain_effect_has_its_prior_at_the_linearisation():
    """Linearised at two values of its coefficient, the same line gives the same average."""
    linear, noise = linear_record(seed=5)
    random = np.random.default_rng(7)
    column = random.standard_normal((40, 1))
    residual = random.standard_normal(40) + 0.8 * column[:, 0]
    prior, x, scale = Prior(np.array([0.2, -0.1]), np.array([0.7, 3.0])), np.zeros(2), np.ones(2)
    results = []
    for at in (0.0, 0.7):
        effect = Nuisance("error", "error", "A", (0.5,), (column,), np.array([at]), odds=1.0)
        left = residual - at * column[:, 0]
        segment = Segment(left, linear.jacobian, linear, noise, 1.0, np.ones(40))
        results.append(average([segment], [effect], prior, x, scale, stated=True))
    first, second = results
    np.testing.assert_allclose(first.shift, second.shift, rtol=1e-9)
    np.testing.assert_allclose(first.covariance, second.covariance, rtol=1e-9)
    assert first.effects[0].probability == pytest.approx(1.0)
    assert first.effects[0].value == pytest.approx(second.effects[0].value)
    assert first.coefficients[0] == pytest.approx(second.coefficients[0] + 0.7)


def test_a_friction_that_cycles_is_followed_and_in_sigma(record, changed, truth):
    """Viscous friction of a thermal cycle of one and a half periods, ±15 %, is no line."""
    steps = record("viscous-coulomb", seed=9, sigma_rpm=1.0)
    torque = truth["viscous-coulomb"]["viscous"] * steps.speed
    cycle = 0.15 * np.sin(3.0 * np.pi * steps.time / steps.time[-1])
    # the wheel moves as before: a friction that varies needs another current
    current = steps.current + torque * (cycle - cycle.mean()) / 0.0228
    cycled = changed(steps, current=current)
    fit = identify(cycled, inertia=INERTIA, model="viscous-coulomb")
    plain = identify(cycled, inertia=INERTIA, model="viscous-coulomb", white_noise=True)
    wheel = {"motor_constant": 0.0228, **truth["viscous-coulomb"]}
    names = ("motor_constant", "viscous", "coulomb")
    assert max(abs(plain.parameters[n] - wheel[n]) / plain.sigma[n] for n in names) > 4.0
    assert max(abs(fit.parameters[n] - wheel[n]) / fit.sigma[n] for n in names) < 3.0
    about = next(effect for effect in fit.effects if effect.name == "viscous_variation")
    assert about.probability > 0.99


@pytest.mark.parametrize("seed", [32, 33])
def test_a_drift_that_shifts_zero_crossings_does_not_look_like_static_torque(
    record, changed, truth, seed
):
    """Dry friction that varies by ±5 %; without it in the linearisation, it is 2 to 6 sigma off.

    The record without it has the same noise, and should have the same static torque.
    """
    wheel = truth["stribeck"]
    steps, clean = (record("stribeck", seed=seed, sigma_rpm=sigma) for sigma in (1.0, 0.0))
    cycle = 0.05 * np.sin(3.0 * np.pi * steps.time / steps.time[-1] + seed - 30)
    # zero is crossed within an interval
    inside = clean.speed[:-1] + np.diff(clean.speed) * np.linspace(0.0, 1.0, 100)[:, None]
    sense = np.append(np.mean(np.sign(inside), axis=0), 1.0)
    dry = sense * wheel["coulomb"] * (cycle - cycle.mean())
    drifting = changed(steps, current=steps.current + dry / 0.0228)
    hold = {"stribeck_speed": wheel["stribeck_speed"]}
    alone, fit = (identify(r, inertia=INERTIA, hold=hold) for r in (steps, drifting))
    shift = fit.parameters["static"] - alone.parameters["static"]
    assert abs(shift) < fit.sigma["static"]


def test_local_derivatives_accumulate_to_those_of_the_record(record):
    """The sensitivity of a parameter is the sum of its effects in all intervals, carried on."""
    steps = record("sticky", "ramps")
    prediction = SpeedPrediction([steps], Stribeck, "zero-order")
    values = np.array([0.0228, INERTIA, 4.83e-6, 0.8795e-3, 1.4e-3, 2.0, 0.0, 0.0])
    linear = prediction.linearise(values)
    assert linear is not None
    rows = accumulated(linear[0], linear[0].local)
    np.testing.assert_allclose(rows, linear[0].jacobian[:, :-1], rtol=1e-9, atol=1e-9)


def test_a_lag_of_the_tachometer_is_found_and_its_bias_removed(record, changed):
    """A lag of 80 ms moves least squares by several sigma; the average stays with the truth."""
    steps = record("stribeck", seed=6, sigma_rpm=2.0)
    clean = record("stribeck", seed=6, sigma_rpm=0.0)
    late = np.interp(clean.time - 0.08, clean.time, clean.speed)
    fit = identify(changed(steps, speed=steps.speed - clean.speed + late), inertia=INERTIA)
    lag = next(e for e in fit.effects if e.name == "speed_lag")
    assert lag.probability > 0.999
    assert abs(lag.value - 0.08) < 4.0 * lag.sigma
    motor = fit.names.index("motor_constant")
    assert abs(fit.least_squares[motor] - 0.0228) > 4.0 * fit.noise_sigma[motor]
    assert abs(fit.values[motor] - 0.0228) < 3.0 * fit.sigma[motor]
    assert fit.whiteness is not None
    assert not fit.whiteness.white
    assert any("lag or delay of the measured speed" in w for w in fit.warnings)


def test_a_lag_that_misleads_least_squares_does_not_shift_the_static_torque(record, changed):
    """The average is linear about a static torque; least squares has it too small, or negative.

    The record without the lag has the same noise, and should have the same static torque.
    Linearised at least squares alone, the average is 7 % too large, 2.7 sigma; linearised at
    negative static torques, 1.4 sigma.
    """
    steps, clean = (record("stribeck", seed=6, sigma_rpm=sigma) for sigma in (0.5, 0.0))
    alone = identify(steps, inertia=INERTIA)
    static = alone.names.index("static")
    for lag, biased in ((0.1, 0.75), (0.3, 0.0)):
        late = np.interp(clean.time - lag, clean.time, clean.speed)
        fit = identify(changed(steps, speed=steps.speed - clean.speed + late), inertia=INERTIA)
        assert fit.least_squares[static] < biased * alone.values[static]
        assert abs(fit.values[static] - alone.values[static]) < 0.3 * fit.sigma[static]


def test_an_average_that_does_not_settle_has_its_last_change_as_an_error(
    record, changed, monkeypatch
):
    steps, clean = (record("stribeck", seed=6, sigma_rpm=sigma) for sigma in (0.5, 0.0))
    late = np.interp(clean.time - 0.1, clean.time, clean.speed)
    monkeypatch.setattr(rounds, "ROUNDS", 0)
    fit = identify(changed(steps, speed=steps.speed - clean.speed + late), inertia=INERTIA)
    static = fit.names.index("static")
    change = abs(fit.values[static] - fit.least_squares[static])
    assert change > 2.0 * fit.noise_sigma[static]
    assert change < fit.sigma[static] < 2.0 * change


def test_a_robust_loss_leaves_out_no_samples_that_effects_explain(record, changed):
    """Far from least squares, residuals without the effects would look like outliers."""
    steps, clean = (record("stribeck", seed=6, sigma_rpm=sigma) for sigma in (0.5, 0.0))
    late = np.interp(clean.time - 0.1, clean.time, clean.speed)
    steps_late = changed(steps, speed=steps.speed - clean.speed + late)
    alone = identify(steps, inertia=INERTIA)
    fit = identify(steps_late, inertia=INERTIA, loss="student")
    assert fit.converged
    assert np.all(np.abs(fit.values - alone.values)[:4] < 0.5 * fit.sigma[:4])


def test_plain_least_squares_is_at_hand(record):
    fit = identify(record(), inertia=INERTIA, speed_sigma=5.0 * RPM, white_noise=True)
    np.testing.assert_array_equal(fit.values, fit.least_squares)
    np.testing.assert_allclose(fit.sigma, fit.noise_sigma, rtol=1e-12)
    assert fit.effects == ()


UNEXPLAINED = "viscous-coulomb"


@pytest.fixture(scope="module")
def unexplained(record):
    """A record with a torque that its current does not contain, up to 80 % of the dry friction.

    With its fit, and the number of starts that were tried.
    """
    steps = record(UNEXPLAINED, seed=8, duration=220.0)
    unseen = steps.current + 0.03 * np.sin(2.0 * np.pi * steps.time / 37.0)
    disturbed = dataclasses.replace(steps, current=unseen)
    return (disturbed, *counted(lambda: identify(disturbed, inertia=INERTIA, model=UNEXPLAINED)))


def counted(solve):
    """Result, and the number of starts that were tried."""
    tried = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "gyrostat.identification.solve.run_stages",
            lambda *given: tried.append(given) or run_stages(*given),
        )
        return solve(), len(tried)


def test_a_record_that_the_current_does_not_explain_gives_no_valid_result(unexplained, record):
    _, fit, _ = unexplained
    assert any("unknown torque" in reason for reason in fit.impossible)
    assert set(fit.impossible) <= set(fit.warnings)
    assert "no valid result; model.toml is marked" in repr(fit)
    model = fit.wheel_model()
    assert model is not None
    assert "unknown torque" in model.impossible
    steps = record(UNEXPLAINED, seed=8, duration=220.0)
    assert identify(steps, inertia=INERTIA, model=UNEXPLAINED).impossible == ()


def test_a_long_record_that_no_start_explains_is_given_up_after_two(unexplained, monkeypatch):
    disturbed, _, many = unexplained
    for module in ("solve", "unsampled"):
        monkeypatch.setattr(f"gyrostat.identification.{module}.LONG", 1000)
    _, few = counted(lambda: identify(disturbed, inertia=INERTIA, model=UNEXPLAINED))
    assert many > 2
    assert few == 2


def test_an_average_that_does_not_follow_the_record_gives_no_valid_result(record, monkeypatch):
    """Sigma is then that of white noise alone."""

    def astray(*_, **__):
        raise np.linalg.LinAlgError

    monkeypatch.setattr("gyrostat.identification.averaged.average", astray)
    fit = identify(record(), inertia=INERTIA)
    np.testing.assert_array_equal(fit.sigma, fit.noise_sigma)
    assert any("white noise alone" in reason for reason in fit.impossible)


def test_slow_ramps_allow_for_a_ripple_until_one_is_stated(record):
    """Ramps of 1 rpm noise break away at few angles and resolve the static torque finely."""
    ramps = record("stribeck", profile="ramps", seed=3, sigma_rpm=0.5, period=60.0)
    fit, smooth = (identify(ramps, inertia=INERTIA, ripple=level) for level in (None, 0.0))
    advised = [w for w in fit.warnings if "--ripple states it" in w]
    assert len(advised) == 1
    assert advised[0].startswith("static: sigma allows for a torque ripple")
    assert fit.sigma["static"] > 1.5 * smooth.sigma["static"]
    assert not any("--ripple" in w for w in smooth.warnings)


@pytest.mark.parametrize(("probability", "corrected"), [(0.9, True), (0.67, False)])
def test_an_effect_that_is_shown_is_corrected_in_the_current(probability, corrected):
    """Two in three is the probability before any record."""
    shape = (np.full((3, 1), 2.0),)
    torque = Nuisance("torque", "t", "1", (0.03,), (np.zeros((4, 1)),), currents=shape)
    lag = Nuisance("lag", "l", "s", (0.1,), (np.zeros((4, 1)),))
    found = [Effect(n, n, probability, 0.1, 0.01, "1") for n in ("lag", "torque")]
    result = corrections([lag, torque], found, np.array([0.5, 0.1]))
    assert [each.name for each in result] == ["torque"] * corrected
    for each in result:
        assert each.probability == probability
        np.testing.assert_allclose(each.currents[0], [0.2, 0.2, 0.2, 0.0])
