"""Judge the window tables that benchmarks/monitor_fleet.py wrote.

    python benchmarks/monitor_judge.py DIR

Prints, for each cell: coverage and error of the intervals, false alarms, delays and classes; then
the peers on the same flights. Shares have 95 % intervals resampled by wheel. Batches whose first
flight is below 100000 set the thresholds of the peers and are not judged.
"""

import argparse
import json
from collections import Counter, defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from monitor_fleet import VEHICLES
from monitor_peers import FIRST, NUMBERS, paths

from gyrostat.monitoring.change.assess import DAY, episodes, reference_to
from gyrostat.monitoring.change.channels import STATED, observation
from gyrostat.monitoring.change.detector import AlarmSettings, Detector
from gyrostat.monitoring.change.evidence import KINDS
from gyrostat.monitoring.change.kinds.tachometer import Tachometer
from gyrostat.monitoring.change.levels import RAMP
from gyrostat.monitoring.fleet.known import known_wheels
from gyrostat.monitoring.fleet.sampling import Sampling
from gyrostat.monitoring.windows import REGRESSED, read_windows

JUDGED = 100000
DELAY = 10
PARAMETERS = (*REGRESSED,)
APART = 3.29
"""Distance of two classes, in standard deviations, at which the best test is right in 95 %."""
GRADUAL = ("Coulomb growth", "viscous growth", "motor constant", "offset", "tachometer fault")
"""Classes that estimates and speed scale tell apart; the others have channels of their own."""
TRUTH = ("coulomb_level", "viscous", "motor_constant", "offset", "tachometer")
FALSE_ALARMS = 0.5
"""False alarms per wheel-year for which the thresholds of the peers are set."""


@dataclass
class Wheel:
    """One wheel of a flight."""

    key: tuple
    name: str
    days: int
    table: object
    truth: dict
    peers: dict
    fault: str | None
    onset: float | None
    tuning: bool
    verdicts: list = field(default_factory=list)
    seen: list = field(default_factory=list)
    reference: object = None
    statistic: dict = field(default_factory=dict)


def wheels_of(path):
    """Wheels of one batch."""
    about = json.loads(path.with_suffix(".json").read_text())
    table = read_windows(path)
    days, flights = about["days"], about["flights"]
    truth, peers = (
        {
            name: np.array([row[name] for row in about[group]]).reshape(days, flights, 4)
            for name in about[group][0]
        }
        for group in ("truth", "peers")
    )
    onsets = {(e["flight"], e["wheel"]): e["day"] for e in about["events"]}
    key = tuple(about[k] for k in ("vehicle", "orbit", "pointing", "noise", "drive", "ugly"))
    for f in range(flights):
        number = about["first"] + f
        for k in range(4):
            onset = onsets.get((number, k + 1))
            if about["fault"] == "seizure" and onset is None:
                continue  # its spacecraft has lost another wheel
            yield Wheel(
                key,
                f"{number}/wheel{k + 1}",
                days,
                table.wheel(f"{number}/wheel{k + 1}"),
                {name: values[:, f, k] for name, values in truth.items()},
                {name: values[:, f, k] for name, values in peers.items()},
                about["fault"],
                onset,
                number < JUDGED,
            )


def detect(wheel):
    """Verdicts of the monitor."""
    known = known_wheels(VEHICLES[wheel.key[0]], Sampling()).wheels[0]
    wheel.reference = reference_to(known)
    detector = Detector(wheel.reference, AlarmSettings())
    columns = wheel.table.columns
    for k in range(len(wheel.table)):
        row = {name: v[k] for name, v in columns.items()}
        wheel.seen.append(observation(row, wheel.reference))
        wheel.verdicts.append(detector.take(wheel.seen[-1]))


def resampled(values, weights=None):
    """Share and its 95 % interval, resampled by wheel."""
    values = np.asarray(values, dtype=float)
    weights = np.ones(values.size) if weights is None else np.asarray(weights, dtype=float)
    random = np.random.default_rng(0)
    rows = random.integers(values.size, size=(1000, values.size))
    shares = np.sum((values * weights)[rows], axis=1) / np.sum(weights[rows], axis=1)
    low, high = np.quantile(shares, [0.025, 0.975])
    return f"{np.sum(values * weights) / np.sum(weights):.3f} [{low:.3f}, {high:.3f}]"


def intervals(wheels):
    """Coverage, error and stated sigma of each parameter."""
    for name in PARAMETERS:
        inside, days, errors, sigmas = [], [], [], []
        for wheel in wheels:
            table = wheel.table
            day = np.round(table["start"] / DAY).astype(int)
            good = table["valid"] & table[f"{name}_observable"] & (day < wheel.days)
            if not np.any(good):
                continue
            error = table[name][good] - wheel.truth[name][day[good]]
            sigma = table[f"{name}_sigma"][good]
            scale = np.abs(wheel.truth["coulomb" if name == "offset" else name][day[good]])
            inside.append(np.mean(np.abs(error) < 1.96 * sigma))
            days.append(good.sum())
            errors.append(np.mean((error / scale) ** 2))
            sigmas.append(np.median(sigma / scale))
        if inside:
            rms = np.sqrt(np.average(errors, weights=days))
            total = sum(len(w.table) for w in wheels)
            print(
                f"    {name:15s} inside {resampled(inside, days)}  rms {100 * rms:.2f} %  "
                f"stated {100 * np.median(sigmas):.2f} %  observable {sum(days) / total:.3f}"
            )
        else:
            print(f"    {name:15s} observable 0")


def alarm_days(flags, start):
    """Windows in which alarms begin."""
    return episodes(list(flags), start)


def false_alarms(wheels, flags_of):
    """Episodes per wheel-year, with the number and the years."""
    count = [len(alarm_days(flags_of(w), w.table["start"])) for w in wheels]
    years = sum(len(w.table) for w in wheels) / 365.25
    return sum(count), years


def delay(wheel, flags):
    """Days from the onset to the first alarm; infinite if there is none, NaN if it was before."""
    first = np.flatnonzero(flags)
    if not first.size:
        return np.inf
    if first[0] < int(wheel.onset):
        return np.nan
    return float(first[0] - int(wheel.onset))


def report_delays(name, delays):
    """One line of delays."""
    delays = np.asarray(delays)
    good = np.isfinite(delays) & (delays <= DELAY)
    median = np.median(np.where(np.isnan(delays), np.inf, delays))
    print(
        f"    {name:30s} within {DELAY} days {resampled(good)}  median {median:.0f}  "
        f"before onset {np.isnan(delays).sum()} of {delays.size}"
    )


def judged(wheel):
    """Window ten days after the first alarm; None without an alarm, or if it was before onset."""
    first = next((k for k, v in enumerate(wheel.verdicts) if v.alarm), None)
    if first is None or first < int(wheel.onset):
        return None
    return min(first + 10, len(wheel.verdicts) - 1)


def answered(wheel):
    """Verdict in this window; None without one."""
    window = judged(wheel)
    return None if window is None else wheel.verdicts[window]


def classes(fault, wheels):
    """Class ten days after the alarm."""
    right = pair = more = wrong = 0
    probability = []
    for wheel in wheels:
        if (verdict := answered(wheel)) is None:
            continue
        probability.append(verdict.probabilities[fault])
        right += verdict.classes == (fault,)
        pair += len(verdict.classes) == 2 and fault in verdict.classes
        more += len(verdict.classes) > 2 and fault in verdict.classes
        wrong += bool(verdict.classes) and fault not in verdict.classes
    total = max(len(probability), 1)
    print(
        f"    {'class':30s} right {right / total:.3f}  in a pair {pair / total:.3f}  one of three "
        f"{more / total:.3f}  wrong {wrong / total:.3f}  the rest open  "
        f"mean probability {np.mean(probability or [np.nan]):.3f}"
    )


def alike(wheel):
    """Classes that these windows cannot tell from the wheel's fault ten days after the alarm.

    The windows' own errors are taken as exact, the levels before the fault and the fault as known.
    Of another class, the size, onset and course that come closest to the fault are d standard
    deviations away. Of two such wheels, one with each class and equally probable, the best test is
    right in the share Phi(d / 2) (Neyman and Pearson): 95 % need a d of 3.29. Only changes of the
    estimates and of the scale of the speed are compared.
    """
    onset, last = int(wheel.onset), judged(wheel)
    scales = np.append(wheel.reference.scales(), 1.0)
    truth = np.stack([wheel.truth[n] for n in TRUTH], axis=1)[: last + 1] / scales
    change = truth - truth[max(onset - 5, 0) : onset].mean(axis=0)
    scale = np.eye(STATED)[-1]
    # a wrong speed shows as the class says, not in the true torques
    change += np.outer(change[:, -1], Tachometer.signatures[0][:STATED] - scale)
    change[:onset] = 0.0
    design, roots = zip(*[_stated(seen) for seen in wheel.seen[onset : last + 1]], strict=True)
    signal = np.concatenate(
        [d @ c / r for d, c, r in zip(design, change[onset:], roots, strict=True)]
    )
    found = []
    for kind in KINDS:
        signature = kind.signatures[0][:STATED]
        if kind.name == wheel.fault or kind.name not in GRADUAL:
            continue
        closest = np.inf
        for begin in range(last + 1 - onset):
            age = np.maximum(np.arange(last + 1 - onset) - begin + 0.5, 0.0)
            courses = [(age > 0.0).astype(float), np.minimum(age / RAMP, 1.0), age / RAMP]
            for course in courses if kind.ramps else courses[:1]:
                other = np.concatenate(
                    [d @ signature * c / r for d, c, r in zip(design, course, roots, strict=True)]
                )
                share = (signal @ other) ** 2 / max(other @ other, 1e-300)
                closest = min(closest, signal @ signal - share)
        if closest < APART**2:
            found.append(kind.name)
    return found


def _stated(seen):
    """Parts of the channels with a stated variance, (M, 5), and standard deviations, (M,)."""
    rows = np.any(seen.direction[:, :STATED] != 0.0, axis=1)
    return seen.direction[rows, :STATED], np.sqrt(seen.variance[rows])


def report_alike(fault, wheels):
    """Shares of wheels whose class could be found at best, and what it is confused with."""
    sets = [tuple(alike(w)) for w in wheels if judged(w) is not None]
    if not sets:
        return
    sizes = np.array([len(names) for names in sets])
    names = Counter(name for each in sets for name in each)
    right, pair, more = (np.mean(there) for there in (sizes == 0, sizes == 1, sizes > 1))
    print(
        f"    {'at best':30s} right {right:.3f}  in a pair {pair:.3f}  more alike {more:.3f}  "
        f"with {dict(names)}"
    )


def reliability(wheels):
    """Stated probability of each class against its frequency, ten days after the alarm.

    The probabilities hold for faults that come with the assumed rates: a wheel counts by the rate
    of its fault over the number of wheels with it. Shares with 95 % intervals, resampled by wheel.
    """
    rates, numbers = AlarmSettings().rates, Counter(w.fault for w in wheels)
    missing = sorted(set(rates) - set(numbers))
    if missing:
        print(f"  reliability: not judged without flights of {', '.join(missing)}")
        return
    stated, true, weights = [], [], []
    for wheel in wheels:
        if (verdict := answered(wheel)) is None:
            continue
        stated.append([verdict.probabilities[name] for name in rates])
        true.append([float(name == wheel.fault) for name in rates])
        weights.append(rates[wheel.fault] / numbers[wheel.fault])
    stated, true, weights = map(np.array, (stated, true, weights))
    print("  reliability: stated, found [95 %], cases, wheels")
    for low, high in ((0.0, 0.01), (0.01, 0.1), (0.1, 0.5), (0.5, 0.9), (0.9, 0.99), (0.99, 1.01)):
        there = (stated >= low) & (stated < high)
        cases = np.sum(there, axis=1)
        if np.any(there):
            mean = np.average(
                np.sum(stated * there, axis=1)[cases > 0] / cases[cases > 0],
                weights=(weights * cases)[cases > 0],
            )
            share = np.sum(true * there, axis=1) / np.maximum(cases, 1)
            counted = f"{cases.sum()}  {np.sum(cases > 0)}"
            print(f"    {mean:.4f}  {resampled(share, weights * cases)}  {counted}")


def peer_statistics(wheels):
    """Statistics of the peers for wheels of equal length."""
    groups = defaultdict(list)
    for wheel in wheels:
        groups[len(wheel.table), wheel.fault].append(wheel)
    for group in groups.values():
        size = len(group[0].table)
        numbers = {n: np.stack([w.peers[n][:size] for w in group]) for n in NUMBERS}
        for name, values in paths(numbers).items():
            for wheel, path in zip(group, values, strict=True):
                wheel.statistic[name] = path


def peers(tuning, healthy, faulty):
    """Peers with thresholds of the tuning flights."""
    peer_statistics([*tuning, *healthy, *[w for group in faulty.values() for w in group]])
    for name in tuning[0].statistic:
        highest = np.sort(np.concatenate([w.statistic[name] for w in tuning]))
        threshold = next(
            t
            for t in np.quantile(highest, np.linspace(0.9, 1.0, 400))
            if _rate(tuning, name, t) <= FALSE_ALARMS
        )
        count, years = false_alarms(healthy, lambda w: w.statistic[name] > threshold)  # noqa: B023
        print(f"  {name}: {count} false alarms in {years:.1f} wheel-years")
        for fault, group in faulty.items():
            report_delays(fault, [delay(w, w.statistic[name] > threshold) for w in group])


def _rate(wheels, name, threshold):
    count, years = false_alarms(wheels, lambda w: w.statistic[name] > threshold)
    # the first days of a wheel cannot raise an alarm
    return count / max(years - len(wheels) * FIRST / 365.25, 1e-9)


def main():
    """Judge all batches."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    arguments = parser.parse_args()
    cells = defaultdict(list)
    for path in sorted(arguments.folder.glob("*.parquet")):
        for wheel in wheels_of(path):
            cells[wheel.key].append(wheel)
    for key, wheels in cells.items():
        print(" ".join(map(str, key)), flush=True)
        for wheel in wheels:
            detect(wheel)
        tuning = [w for w in wheels if w.tuning and w.fault is None]
        healthy = [w for w in wheels if not w.tuning and w.fault is None]
        faulty = defaultdict(list)
        for wheel in wheels:
            if not wheel.tuning and wheel.onset is not None:
                faulty[wheel.fault].append(wheel)
        if healthy:
            intervals(healthy)
            count, years = false_alarms(healthy, lambda w: [v.alarm for v in w.verdicts])
            print(f"  monitor: {count} false alarms in {years:.1f} wheel-years ({len(healthy)})")
        for fault, group in sorted(faulty.items()):
            report_delays(fault, [delay(w, [v.alarm for v in w.verdicts]) for w in group])
            classes(fault, group)
            if fault in GRADUAL:
                report_alike(fault, group)
        if tuning and healthy:
            peers(tuning, healthy, faulty)
        reliability([w for group in faulty.values() for w in group])


if __name__ == "__main__":
    main()
