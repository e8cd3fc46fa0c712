"""Power, false alarms and first name of the diagnosis, over virtual records with one effect.

    python benchmarks/diagnosis.py [--records 24] [--seed 60000] [--size 5]

Records of 1500 samples (150 s of profile 2 at 10 Hz, 2 rpm noise) of wheels with dispersed truth
(`bench_wheels.py`). Each is fitted without an effect (false alarms; the sigma of each candidate in
this very record) and with one effect of `--size` sigmas. Noticed: the diagnosis finds anything.
Right: the effect is first, or one of the class that is named first. Seeds below 10000 served
development; proof uses others.
"""

import argparse
from collections import Counter
from dataclasses import replace

import numpy as np
from bench_wheels import INERTIA, NOISE_ONLY, STRIBECK_SPEED, Effects, records

from gyrostat.core.units import RPM
from gyrostat.identification import identify

DURATION = 150.0
BASE = replace(NOISE_ONLY, speed_sigma=2.0 * RPM)
HOLD = {"stribeck_speed": STRIBECK_SPEED}
CASES = {
    "speed_lag": lambda size: replace(BASE, lag=size),
    "viscous_drift": lambda size: replace(BASE, drift=size),
    "coulomb_drift": lambda size: replace(BASE, dry_drift=size),
    "current_offset": lambda size: replace(BASE, offset=size),
    "asymmetry": lambda size: replace(BASE, asymmetry=size),
    "ripple_1": lambda size: replace(BASE, ripple=size, second=0.0),
    "crossing_ripple": lambda size: Effects(ripple=0.15, speed_sigma=2.0 * RPM),
}
"""Effect -> what a wheel with so large a one is; the ripple at crossings has one size for all."""


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=24)
    parser.add_argument("--seed", type=int, default=60000)
    parser.add_argument("--size", type=float, default=5.0)
    arguments = parser.parse_args()
    alarms = total = noticed_all = right_all = 0
    false_names: Counter = Counter()
    for place, (name, effects) in enumerate(CASES.items()):
        seed, count = arguments.seed + place, arguments.records
        plain = records(seed, count, BASE, duration=DURATION)
        sigma = []
        for record, _, _ in plain:
            fit = identify(record, inertia=INERTIA, hold=HOLD)
            alarms += bool(fit.findings)
            false_names.update(f.names[0] for f in fit.findings)
            own = [s.sigma for s in fit.scores if s.name == name]
            sigma.append(own[0] if own else 0.0)
        changed = records(seed, count, effects(arguments.size * np.array(sigma)), duration=DURATION)
        noticed = right = 0
        first: Counter = Counter()
        for record, _, _ in changed:
            fit = identify(record, inertia=INERTIA, hold=HOLD)
            noticed += bool(fit.findings)
            named = fit.findings[0].names if fit.findings else ()
            # one ripple has several names: coherent over the record, and random at each crossing
            right += any(("ripple" in name and "ripple" in n) or n == name for n in named)
            first.update(["|".join(named)])
        total, noticed_all, right_all = total + count, noticed_all + noticed, right_all + right
        print(f"{name:16s} noticed {noticed}/{count}, right first {right}/{count}", flush=True)
        for names, times in first.most_common(4):
            print(f"    {times:3d}  {names or '-'}")
    print(f"noticed {noticed_all} of {total}, right first {right_all} of {total}")
    print(f"false alarms {alarms} of {total}: {dict(false_names)}")


if __name__ == "__main__":
    main()
