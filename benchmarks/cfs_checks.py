"""The exported cFS application with one check less at a time: its test must see each.

    python benchmarks/cfs_checks.py [--cache FOLDER] [--only TEXT]

Builds the application of tests/exports/test_cfs_flight.py with each change of `CHANGES`, flies the
script of faults in the core Flight System, and prints what differs from the expected flight. The
unchanged application must show no difference, every other one at least one. Exits with 1 otherwise.
Needs what that test needs; a change takes some 15 s on two cores.
"""

import argparse
import importlib.util
import shutil
import sys
import tempfile
from pathlib import Path

from gyrostat.exports.cfs import interface

TESTS = Path(__file__).resolve().parents[1] / "tests" / "exports" / "cfs"
APP, INPUT, TABLE = (f"fsw/src/compensator_{part}.c" for part in ("app", "input", "table"))
CONFIG, EVENTS = (f"fsw/mission_inc/compensator_{part}.h" for part in ("cfg", "events"))
LAW = "flight/compensator.c"
HAS_LENGTH = "COMPENSATOR_HasLength(Buffer, sizeof(COMPENSATOR_NoArgsCmd_t))"
AFTER_SILENCE = "    COMPENSATOR_ReadCommands();\n    COMPENSATOR_ManageTable();\n}\n"
LIMITED = [event.name for event in (*interface.FILTERED, *interface.LIMITED)]

CHANGES = (
    ("nothing", APP, "", ""),
    ("length of a message", INPUT, " && (Size == Expected)", ""),
    ("length of a command", INPUT, f"IsDone = {HAS_LENGTH}", "IsDone = true"),
    ("length of a wake-up", APP, f"\n                && {HAS_LENGTH}", ""),
    (
        "id of a sensor message",
        INPUT,
        "IsGood = COMPENSATOR_HasMessageId(Buffer, COMPENSATOR_SENSOR_TLM_MID)",
        "IsGood = true",
    ),
    (
        "checksum of a sensor message",
        INPUT,
        "Payload->Crc != COMPENSATOR_SensorCrc(Payload)",
        "0",
    ),
    ("checksum of a command", INPUT, " && HasChecksum(Buffer)", ""),
    ("order of time stamps", INPUT, "(Order != CFE_TIME_A_GT_B) || ", ""),
    ("age of a sample", INPUT, " || (CFE_TIME_Compare(Age, Oldest) == CFE_TIME_A_GT_B)", ""),
    ("repeated time stamp", INPUT, "if (Order == CFE_TIME_EQUAL)", "if (0)"),
    ("new time stamps after a time-out", APP, "COMPENSATOR_Data.HasSampleTime = false;", ""),
    ("NaN in a sample", LAW, "return (bits & exponent) != exponent;", "return bits == bits;"),
    ("NaN for a missing sample", APP, "COMPENSATOR_SetMissing();", ""),
    ("count of missing samples", APP, "++Counters->MissingSamples;", ""),
    ("time-out of the sensor", APP, "== COMPENSATOR_SENSOR_TIMEOUT_TICKS", "== 0xFFFFFFFFU"),
    ("count of samples by status", APP, "++Counters->Samples[Reason];", ""),
    ("ranges of a table", TABLE, "if (Fault != NULL)", "if (0)"),
    ("lower end of a range", TABLE, "(Values[k] >= Lower) && ", ""),
    ("upper end of a range", TABLE, " && (Values[k] <= Upper)", ""),
    (
        "check of the copy of a table",
        TABLE,
        "if (COMPENSATOR_ValidateTable(&COMPENSATOR_Data.Candidate) == CFE_SUCCESS)",
        "if (1)",
    ),
    ("copy of a table before the step", TABLE, "Adopt(&COMPENSATOR_Data.Candidate);", ""),
    (
        "release of the table",
        TABLE,
        "(void)CFE_TBL_ReleaseAddress(COMPENSATOR_Data.TableHandle);",
        "",
    ),
    ("table load during a tick", APP, "    COMPENSATOR_CheckTableInTick();\n", ""),
    ("start without a table", TABLE, "HasTable = (Status >= CFE_SUCCESS);", "HasTable = true;"),
    ("limit of the events", CONFIG, "COMPENSATOR_EVENT_MASK 0x003FU", "COMPENSATOR_EVENT_MASK 0U"),
    ("reset of the event filters", INPUT, "(void)CFE_EVS_ResetAllFilters();", ""),
    ("reset of the controller", INPUT, "IsDone = COMPENSATOR_StartController();", ""),
    ("commands without wake-ups", APP, AFTER_SILENCE, "}\n"),
    *((f"event {name}", EVENTS, f"{name} ", f"{name} 100U + ") for name in LIMITED),
)
"""Check, file, text of C, and the text without the check."""


def loaded(name: str):
    """Module of the test's folder."""
    spec = importlib.util.spec_from_file_location(name, TESTS / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def changed(texts: dict[str, str], file: str, old: str, new: str) -> dict[str, str]:
    """Files of the application with a change."""
    text = texts[file]
    assert old in text, f"{file}: found no {old!r}"
    return texts | {file: text.replace(old, new, 1)}


def main() -> int:
    """Fly every change; print a row for each."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--cache", type=Path, help="folder in which the flight system is built")
    parser.add_argument("--only", default="", help="text in the names of the changes to fly")
    options = parser.parse_args()
    mission, flights, faults = map(loaded, ("mission", "flights", "faults"))
    lacking = mission.missing()
    if lacking:
        print(lacking)
        return 1
    case = faults.Case.make()
    texts, flight, size = case.texts(), case.flight(flights), faults.table_size(case)
    wrong = 0
    with tempfile.TemporaryDirectory() as scratch:
        built = mission.Mission((options.cache or Path(scratch)) / "cfs")
        for number, (name, *change) in enumerate(CHANGES):
            if options.only not in name:
                continue
            app = flights.for_test("compensator", changed(texts, *change), strict=number == 0)
            apps = {"compensator": app, "fly_compensator": flight.flyer()}
            folder = Path(scratch) / f"cpu{number}"
            built.build(apps, f"{flight.startup()}!\n", folder)
            faults.write_tables(folder / "cf", size)
            found = flown(mission, faults, case, flight, folder, flights.COUNTS)
            wrong += bool(found) == (name == "nothing")
            print(f"| {name} | {'; '.join(found)[:160] or 'no difference'} |", flush=True)
            shutil.rmtree(folder)
    print(f"{wrong} wrong of {len(CHANGES)}")
    return int(wrong > 0)


def flown(mission, faults, case, flight, folder, names) -> list[str]:
    """What differs from the expected flight."""
    script, ticks = faults.SCRIPT, faults.TICKS
    try:
        result = faults.fly_case(mission, flight, folder, script, ticks)
    except AssertionError as error:
        return [f"the flight ended: {error}".replace("\n", " ")]
    return faults.differences(case, result, script, ticks, names)


if __name__ == "__main__":
    sys.exit(main())
