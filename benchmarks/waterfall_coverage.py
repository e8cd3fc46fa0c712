"""Coverage of the 95 % intervals of `waterfall` on simulated waterfalls of known truth.

python benchmarks/waterfall_coverage.py --waterfalls 200

An interrupt ends it with the waterfalls so far.
"""

import argparse
from collections import defaultdict

import numpy as np

from gyrostat.microvibration.fit import fit_waterfall
from gyrostat.microvibration.model import Harmonic, Mode, Noise, WheelDisturbance
from gyrostat.microvibration.simulate import simulated_waterfall

HZ, RPM = 2.0 * np.pi, np.pi / 30.0
SPEED = np.linspace(300.0, 3000.0, 40) * RPM
WHEEL = WheelDisturbance(
    "wheel",
    (
        Harmonic(0.63, {"force": 3e-7, "torque": 2e-8}),
        Harmonic(1.0, {"force": 1e-6, "torque": 3e-8, "axial": 3e-7, "torsion": 5e-9}),
        Harmonic(2.0, {"force": 4e-7, "axial": 2e-7}, {"torque": 3e-8}),
        Harmonic(3.17, {"force": 2e-7, "torque": 1e-8}, {"torque": 1e-8}),
        Harmonic(4.4, {"torque": 1.5e-8, "axial": 1e-7}),
    ),
    {
        "force": Mode(180.0 * HZ, 0.02),
        "axial": Mode(220.0 * HZ, 0.02),
        "torque": Mode(75.0 * HZ, 0.015, 1.7),
    },
    {
        "force": Noise(2e-6, 1.0, SPEED[-1]),
        "axial": Noise(1e-6, 1.0, SPEED[-1]),
        "torque": Noise(3e-9, 1.5, SPEED[-1]),
    },
)
FLOOR = {"force": 1e-6, "axial": 1e-6, "torque": 1e-9, "torsion": 1e-9}


def intervals(fit):
    """Name -> (low, high, truth, value, sigma) of each parameter of the truth."""
    for truth in WHEEL.harmonics:
        near = [h for h in fit.harmonics if abs(h.number.value - truth.number) < 0.01]
        if not near:
            yield f"h {truth.number:g} found", None, 0.0
            continue
        yield f"h {truth.number:g}", near[0].number, truth.number
        for kind in FLOOR:
            sizes = [getattr(truth, part).get(kind, 0.0) for part in ("forward", "backward")]
            found = near[0].coefficients[kind]
            if any(sizes):
                yield f"{kind} {truth.number:g}", found.total, np.hypot(*sizes)
            if all(sizes):
                yield f"{kind} {truth.number:g} forward", found.forward, sizes[0]
                yield f"{kind} {truth.number:g} backward", found.backward, sizes[1]
    for kind, mode in WHEEL.modes.items():
        for name, estimate in fit.kinds[kind].mode.items():
            yield f"{kind} {name}", estimate, getattr(mode, name)
        yield f"{kind} density", fit.kinds[kind].noise["density"], WHEEL.noise[kind].density
        yield f"{kind} exponent", fit.kinds[kind].noise["exponent"], WHEEL.noise[kind].exponent
    for kind, value in FLOOR.items():
        yield f"{kind} floor", fit.kinds[kind].noise["floor"], value


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--waterfalls", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    held, score = defaultdict(list), defaultdict(list)
    extra = missing = count = 0
    for k in range(options.waterfalls):
        generator = np.random.default_rng([options.seed, k])
        try:
            fit = fit_waterfall(simulated_waterfall(WHEEL, SPEED, generator, floor=FLOOR))
        except KeyboardInterrupt:
            break
        count += 1
        extra += len(fit.harmonics) > len(WHEEL.harmonics)
        for name, estimate, truth in intervals(fit):
            if estimate is None:
                missing += 1
                continue
            held[name].append(estimate.low <= truth <= estimate.high)
            score[name].append((estimate.value - truth) / estimate.sigma)
    for name, values in held.items():
        z = np.array(score[name])
        print(
            f"{name:22s} {100 * np.mean(values):6.1f} %   bias {z.mean():6.2f}   rms {z.std():5.2f}"
        )
    total = np.concatenate(list(held.values()))
    print(f"{count} waterfalls: {100 * total.mean():.1f} % of {total.size} intervals")
    print(f"harmonics not found: {missing}; waterfalls with further harmonics: {extra}")


if __name__ == "__main__":
    main()
