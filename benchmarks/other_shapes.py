"""Coverage of 95 % intervals over records whose effects have other shapes than those averaged over.

    python benchmarks/other_shapes.py [--case quantised] [--records 40] [--seed 200000] [--jobs 2]
        [--keep DIR]

The records are those of `record_shapes.py`. Seeds below 200000 served development; `jump`, `bursts`
and `warm-up` were invented after it. Each case has random numbers of its own. For each parameter:
coverage of value ± 1.96 sigma in % (in brackets by plain least squares), rms error in % of the
truth, w = median width over 3.92 rms errors. Records without a valid result are counted apart, with
the reason. A stopped run goes on from the answers in DIR.
"""

import argparse
import json
import time
import zlib
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np
from record_shapes import CASES, INERTIA, NAMES, STRIBECK_SPEED, simulate

from gyrostat.core.errors import InputError
from gyrostat.identification import identify
from gyrostat.telemetry import Record

HALF_WIDTH = 1.959964
TOGETHER = 40
"""Records that are simulated together."""


class Answer(NamedTuple):
    """What identification says of a record; errors and sigmas over the truth, by parameter.

    Attributes:
        error: Error.
        plain: Error of plain least squares.
        sigma: Sigma.
        white: Sigma of plain least squares in white noise.
        why: Reason why there is no valid result, or empty.
    """

    error: np.ndarray
    plain: np.ndarray
    sigma: np.ndarray
    white: np.ndarray
    why: str = ""


NONE = np.zeros(0)


def answers(case: str, seed: int, batch: int, count: int, keep: Path | None) -> list[Answer]:
    """Identify records of a case.

    Args:
        case: Name of the case.
        seed: Seed; a case and a batch have random numbers of their own.
        batch: Number of the batch.
        count: Number of records.
        keep: Folder of the answers of earlier runs, to which these are added.
    """
    file = None if keep is None else keep / f"{case}-{seed}-{batch}-{count}.json"
    if file is not None and file.exists():
        parts = json.loads(file.read_text(encoding="utf-8"))
        return [Answer(*map(np.array, numbers), why) for *numbers, why in parts]
    own = [seed, zlib.crc32(case.encode()), batch]
    found = [answer(record, truth, case) for record, truth in simulate(own, count, CASES[case])]
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        parts = [[*(numbers.tolist() for numbers in each[:-1]), each.why] for each in found]
        unfinished = file.with_suffix(".part")
        unfinished.write_text(json.dumps(parts), encoding="utf-8")
        unfinished.replace(file)
    return found


def answer(record: Record, truth: dict[str, float], case: str) -> Answer:
    """Identify a record."""
    true = np.array([truth[name] for name in NAMES])
    hold = "linear" if CASES[case].smooth else "zero-order"
    given = {"inertia": INERTIA, "hold": {"stribeck_speed": STRIBECK_SPEED}, "current_hold": hold}
    try:
        fit, plain = (identify(record, **given, white_noise=white) for white in (False, True))
    except InputError as refusal:
        return Answer(NONE, NONE, NONE, NONE, str(refusal).split(": ", 1)[-1][:60])
    if not fit.converged or fit.impossible:
        why = fit.impossible[0][:60] if fit.impossible else "not converged"
        return Answer(NONE, NONE, NONE, NONE, why)
    places = [fit.names.index(name) for name in NAMES]
    return Answer(
        (fit.values[places] - true) / true,
        (plain.values[places] - true) / true,
        fit.sigma[places] / true,
        plain.sigma[places] / true,
    )


def row(case: str, found: list[Answer]) -> str:
    """Row of the table, with a line for each reason of a refusal."""
    good = [each for each in found if not each.why]
    text = f"{case:22s}"
    if good:
        error, plain, sigma, white = (np.array(part) for part in list(zip(*good, strict=True))[:4])
        rms = np.sqrt(np.mean(error**2, axis=0))
        shares = 100.0 * np.mean(np.abs(error) <= HALF_WIDTH * sigma, axis=0)
        least = 100.0 * np.mean(np.abs(plain) <= HALF_WIDTH * white, axis=0)
        w = np.median(sigma, axis=0) / rms
        for share, before, size, width in zip(shares, least, 100.0 * rms, w, strict=True):
            text += f"{f'{share:.0f} [{before:.0f}] {size:.2g} % w{width:.2f}':>26s}"
    text += f"  {len(good)} of {len(found)}"
    why = Counter(each.why for each in found if each.why)
    return "\n".join([text, *(f"    {number} x {reason}" for reason, number in why.most_common())])


def main() -> None:
    """Print the table of one case or several."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case", nargs="+", choices=[*CASES, "every"], default=["quantised"])
    parser.add_argument("--records", type=int, default=40)
    parser.add_argument("--seed", type=int, default=200000)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--keep", type=Path)
    arguments = parser.parse_args()
    cases = list(CASES) if "every" in arguments.case else arguments.case
    started = time.perf_counter()
    sizes = [
        min(TOGETHER, arguments.records - start) for start in range(0, arguments.records, TOGETHER)
    ]
    print(f"{'':22s}" + "".join(f"{name:>26s}" for name in NAMES))
    with ProcessPoolExecutor(arguments.jobs, mp_context=get_context("spawn")) as pool:
        waiting = {
            case: [
                pool.submit(answers, case, arguments.seed, batch, size, arguments.keep)
                for batch, size in enumerate(sizes)
            ]
            for case in cases
        }
        for case, parts in waiting.items():
            found = [each for part in parts for each in part.result()]
            seconds = time.perf_counter() - started
            print(f"{row(case, found)}  after {seconds:.0f} s", flush=True)


if __name__ == "__main__":
    main()
