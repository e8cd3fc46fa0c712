"""Hostile sequences of samples against the emitted compensator, compiled.

    python benchmarks/soak_flight_code.py [--count 1000000]

Each sequence mixes good samples with NaN, infinities of both signs, huge, subnormal and repeated
values and values outside the limits, and ends with five good samples. Beside it flies the same
sequence with NaN in place of every sample that is not finite or outside its limits. At each step
both memories must be equal byte by byte and finite, and the command finite; the status must be good
within the five samples. Flown once with a rate limit and once without, held and zero commands, by
every compiler found, also with -O3 -ffast-math. Exits with 1 on any failure.
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from gyrostat.codegen.flight import emit
from gyrostat.control import AttitudePID, EstimatingCompensator, FieldLimits
from gyrostat.exports import targets
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Stribeck

PERIOD = 0.1
WHEEL = Wheel(1.5e-3, 0.0228, Stribeck(4.83e-6, 0.8795e-3, 0.9055e-3, 0.418879))
LAW = AttitudePID(0.0571, 0.00234, 0.3126)
RANGES = {"attitude": 0.5, "rate": 0.2, "speed": 600.0}
STRICT = ("-std=c99", "-ffp-contract=off", "-O2")
FAST = ("-std=c99", "-O3", "-ffast-math", "-U__FAST_MATH__")
"""The emitted code refuses -ffast-math; here it must not get the chance to."""

PROGRAM = """
#include "compensator.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t state = 88172645463325252u;
static uint64_t word(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state;
}
static double uniform(void) { return (double)(word() >> 11) / 9007199254740992.0; }
static double from_bits(uint64_t bits)
{
    double made;
    memcpy(&made, &bits, sizeof made);
    return made;
}
static bool finite_bits(const double *value)
{
    uint64_t bits;
    memcpy(&bits, value, sizeof bits);
    return (bits & 0x7ff0000000000000u) != 0x7ff0000000000000u;
}
static bool all_finite(const void *from, size_t size)
{
    for (size_t k = 0; k < size / sizeof(double); ++k) {
        double value;
        memcpy(&value, (const char *)from + k * sizeof value, sizeof value);
        if (!finite_bits(&value)) { return false; }
    }
    return true;
}
/* A value, and whether it is within the limit. */
static bool drawn(double limit, bool hostile, double *value)
{
    *value = limit * (2.0 * uniform() - 1.0);
    if (!hostile) { return true; }
    switch (word() % 8) {
    case 0: *value = from_bits(0x7ff8000000000000u | (word() >> 13)); return false;
    case 1: *value = from_bits(0x7ff0000000000000u | (word() & 0x8000000000000000u)); return false;
    case 2: *value = from_bits((word() & 0x800fffffffffffffu) | 0x7fe0000000000000u); return false;
    case 3: *value = from_bits(word() & 0x800fffffffffffffu); return true;
    case 4: *value = limit * (1.0 + 1e-9 + uniform()); return false;
    case 5: *value = -limit * (1.0 + 1e-9 + uniform()); return false;
    case 6: *value = from_bits(0x7ff0000000000001u | (word() >> 13)); return false;
    default: return true;
    }
}

int main(int count, char **argument)
{
    const long sequences = atol(argument[1]);
    EstimatingCompensator controller;
    MeasurementGuard guard;
    long differ = 0, not_finite = 0, not_good = 0, samples = 0, rejected = 0;
    (void)count;
    compensator_parameters(&controller, &guard);
    for (long n = 0; n < sequences; ++n) {
        GuardedMemory own, other;
        const uint64_t length = 1 + word() % 12;
        const uint64_t often = 1 + word() % 4;
        bool good = false;
        compensator_start(&controller, PERIOD, &own);
        memcpy(&other, &own, sizeof own);
        for (uint64_t k = 0; k < length + 5; ++k) {
            TableMeasurement seen, missing;
            EstimatingCommand command, beside;
            SampleReport report, told;
            bool inside = true;
            const bool hostile = k < length && word() % 4 < often;
            inside = drawn(0.5, hostile && word() % 2, &seen.attitude) && inside;
            inside = drawn(0.2, hostile && word() % 2, &seen.rate) && inside;
            inside = drawn(600.0, hostile && word() % 2, &seen.speed) && inside;
            missing = seen;
            if (!inside) {
                missing.attitude = missing.rate = missing.speed = from_bits(0x7ff8000000000000u);
            }
            compensator_step(&controller, &guard, &own, &seen, &command, &report);
            compensator_step(&controller, &guard, &other, &missing, &beside, &told);
            differ += memcmp(&own, &other, sizeof own) != 0;
            differ += memcmp(&command, &beside, sizeof command) != 0;
            differ += (report.sample_status == 0) && !inside;
            not_finite += !all_finite(&own, sizeof own) || !all_finite(&command, sizeof command);
            good = (k < length) ? false : (good || report.sample_status == 0);
            rejected += report.sample_status != 0;
            ++samples;
        }
        not_good += !good;
    }
    printf("%ld %ld %ld %ld %ld\\n", samples, rejected, differ, not_finite, not_good);
    return (differ + not_finite + not_good) != 0;
}
"""


def sources(rate_limit, on_bad):
    """File name -> text of the compensator and the program that attacks it."""
    limits = {
        name: FieldLimits(-limit, limit, 5.0 * limit if rate_limit else None)
        for name, limit in RANGES.items()
    }
    tuned = EstimatingCompensator.tune(LAW, WHEEL, 0.495, 0.5, PERIOD, delay=1)
    target = targets.compensator(tuned, PERIOD, limits, on_bad)
    module = emit(target.name, target.entries)
    program = PROGRAM.replace("PERIOD", repr(PERIOD))
    return {"compensator.h": module.header, "compensator.c": module.source, "attack.c": program}


def attack(texts, compiler, flags, count):
    """Compile and fly.

    Returns:
        Samples, rejected ones, steps at which the two differ, steps that were not finite, and
        sequences whose status did not become good.
    """
    with tempfile.TemporaryDirectory() as folder:
        for name, text in texts.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        command = [compiler, *flags, "-w", "compensator.c", "attack.c", "-lm", "-o", "attack"]
        subprocess.run(command, cwd=folder, check=True)
        done = subprocess.run([f"{folder}/attack", str(count)], capture_output=True, text=True)
    return tuple(map(int, done.stdout.split()))


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=1_000_000)
    count = parser.parse_args().count
    compilers = [name for name in ("gcc", "clang") if shutil.which(name)]
    if not compilers:
        print("found no gcc or clang: nothing flown")
        return 1
    cases = [(c, f) for c in compilers for f in (STRICT, FAST)]
    variants = [sources(limited, on_bad) for limited, on_bad in ((True, "hold"), (False, "zero"))]
    failed = False
    print("compiler options                      sequences  samples  rejected  differ  not finite")
    for compiler, flags in cases:
        for texts in variants:
            own = count // (len(cases) * len(variants)) or 1
            begin = time.perf_counter()
            samples, rejected, *bad = attack(texts, compiler, flags, own)
            failed |= any(bad)
            spent = time.perf_counter() - begin
            print(
                f"{compiler:8} {' '.join(flags[1:3]):28} {own:9} {samples:9} {rejected:9} "
                f"{bad[0]:7} {bad[1]:7} not good again: {bad[2]}  ({spent:.0f} s)",
                flush=True,
            )
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
