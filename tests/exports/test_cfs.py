"""The application folder for cFS as text: layouts, ranges, names, refusals."""

import re
import subprocess
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.control import AttitudePID, CurrentMode, FieldLimits, MeasurementGuard
from gyrostat.control.measurement_guard import UNLIMITED
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.exports import files, targets
from gyrostat.exports.cfs import application
from gyrostat.exports.cfs.parameters import parameters_of
from gyrostat.exports.target import STEPS, renamed
from gyrostat.exports.targets import flight_loop

WHEEL = gs.Wheel(1.5e-3, 0.02, gs.Stribeck(5e-6, 9e-4, 9.5e-4, 0.4))
LAW = CurrentMode(AttitudePID(1.0, 0.0, 3.0), 0.02)
PERIOD = 0.1
STUB = """
#include <stdbool.h>
#include <stdint.h>
typedef uint8_t uint8;
typedef uint32_t uint32;
typedef int64_t int64;
typedef struct { uint32 Seconds; uint32 Subseconds; } CFE_TIME_SysTime_t;
typedef struct { uint8 Bytes[8]; } CFE_MSG_CommandHeader_t;
typedef struct { uint8 Bytes[16]; } CFE_MSG_TelemetryHeader_t;
#define CompileTimeAssert(Condition, Message) typedef char Message[(Condition) ? 1 : -1]
#define CFE_MISSION_ES_DEFAULT_CRC 1
static inline uint32 CFE_ES_CalculateCRC(const void *Data, size_t Size, uint32 First, int Kind)
{
    (void)Data; (void)Size; (void)First; (void)Kind;
    return 0;
}
"""
"""What the messages need of cFE."""


class Sensed(NamedTuple):
    """Measurement with fields of all kinds.

    Attributes:
        attitude_measured: Whether the attitude is measured.
        attitude: Attitude quaternion, (4,).
        rate: Body rate, (3,), rad/s.
        works: Whether each wheel works, (2,).
        frame: Number of the frame.
    """

    attitude_measured: object
    attitude: object
    rate: object
    works: object
    frame: object


class Torque(NamedTuple):
    """Command.

    Attributes:
        torque: Motor torques, (2,), N·m.
        spin: Whether the wheels spin up.
    """

    torque: object
    spin: object


class Damper(NamedTuple):
    """Rate damper.

    Attributes:
        gain: Gain of each wheel, (2,), N·m·s/rad.
        bias: Torque without rate, N·m.
        count: Number of frames.
        limit: Torque limit, N·m.
        fine: Whether the fine mode is used.
    """

    gain: object
    bias: object
    count: object
    limit: object
    fine: object

    def start(self, period):
        return jnp.zeros(())

    def __call__(self, memory, sensed):
        torque = jnp.clip(-self.gain * sensed.rate[:2] + self.bias, -self.limit, self.limit)
        torque = jnp.where(sensed.works & self.fine, torque, 0.0)
        return memory + 1.0, Torque(torque, sensed.frame > self.count)


def damper():
    """Flight module of a damper with numbers of all kinds."""
    sample = Sensed(np.array(True), np.ones(4), np.ones(3), np.ones(2, bool), np.array(3))
    sample = Sensed(*map(jnp.asarray, sample))
    limits = {"rate": FieldLimits(-1.0, jnp.array([1.0, 2.0, 3.0]), 0.5)}
    guard = MeasurementGuard.of(sample, limits, "zero")
    part = Damper(np.array([0.1, -0.2]), 0.0, 7, np.inf, True)
    measured = Sensed(*(jnp.stack([leaf] * STEPS) for leaf in sample))
    return flight_loop("damper", "A damper", part, PERIOD, guard, measured)


@pytest.fixture(scope="module")
def folder():
    """Files of the application of the damper."""
    texts = application(damper(), "double", "Made by a test.")
    assert {name.partition("/")[0] for name in texts} == {"damper"}
    return {name.removeprefix("damper/"): text for name, text in texts.items()}


def test_the_flight_module_is_the_one_of_c(folder):
    flight = files(damper(), "double", "Made by a test.")
    assert {name: folder[f"flight/{name}"] for name in flight} == flight


def test_the_same_module_gives_the_same_files(folder):
    again = application(damper(), "double", "Made by a test.")
    assert {f"damper/{name}": text for name, text in folder.items()} == again


def table(readme, head):
    """Rows of the table below a head of the README, without the backquotes."""
    text = readme.partition(head)[2].partition("\n|---")[2].partition("\n\n")[0]
    return [[cell.strip(" `") for cell in line.split("|")[1:-1]] for line in text.splitlines()[1:]]


@pytest.mark.parametrize(("head", "payload"), [("Sensor", "SensorTlm"), ("Command", "CommandTlm")])
def test_the_compiler_places_the_fields_where_the_readme_says(
    folder, head, payload, tools, tmp_path
):
    rows = table(folder["README.md"], f"### {head} message")
    offsets = {name: int(offset) for name, _, _, offset, _ in rows}
    assert next(iter(offsets)) == "SampleTime"
    assert [*offsets][-2:] == ["Crc", "Reserved"]
    (tmp_path / "cfe.h").write_text(f"#include <stddef.h>\n{STUB}", encoding="utf-8")
    (tmp_path / "damper_msg.h").write_text(folder["fsw/mission_inc/damper_msg.h"], encoding="utf-8")
    lines = (
        f'    printf("{name} %zu\\n", offsetof(DAMPER_{payload}_Payload_t, {name}));'
        for name in offsets
    )
    text = ['#include "damper_msg.h"', "#include <stdio.h>", "int main(void)", "{", *lines, "}"]
    (tmp_path / "main.c").write_text("\n".join([*text, ""]), encoding="utf-8")
    subprocess.run([tools.compiler(), "main.c", "-o", "main"], cwd=tmp_path, check=True)
    printed = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True).stdout
    found = {name: int(offset) for name, offset in map(str.split, printed.splitlines())}
    assert found == offsets


def test_logical_values_are_bytes_and_have_no_other_value_than_0_and_1(folder):
    source = folder["fsw/src/damper_input.c"]
    assert "DAMPER_Data.Values.measurement.works[1] = (Payload->works[1] != 0U);" in source
    assert (
        "Payload->spin = (uint8)(DAMPER_Data.Values.command.spin ? 1U : 0U);"
        in (folder["fsw/src/damper_app.c"])
    )


def test_a_missing_sample_is_not_a_number_and_has_its_flags_set(folder):
    _, _, body = folder["fsw/src/damper_input.c"].partition("void DAMPER_SetMissing(void)")
    place = "DAMPER_Data.Values.measurement."
    assert f"SetNotANumber(&{place}attitude[0], 4U);" in body
    assert f"SetNotANumber(&{place}rate[0], 3U);" in body
    assert f"{place}attitude_measured = true;" in body
    assert "frame" not in body


def test_the_safe_command_of_a_failed_step_is_that_of_the_guard(folder):
    assert (
        "memset(&DAMPER_Data.Values.command, 0, sizeof(LastCommand))"
        in (folder["fsw/src/damper_app.c"])
    )
    held = application(targets.controller(LAW, PERIOD), "double", "")
    assert (
        "memcpy(&CONTROLLER_Data.Values.command, &LastCommand"
        in (held["controller/fsw/src/controller_app.c"])
    )


def test_the_ranges_of_the_parameters_are_those_of_their_kind():
    target = damper()
    ports = {port.name: port for port in module_ports(target)}
    values = target.designed()
    ranges = {p.name: (p.lower, p.upper, p.above) for p in parameters_of(ports, values)}
    assert ranges == {
        "controller.gain": (-2.0, 2.0, ""),  # of both signs: ten times the largest
        "controller.bias": (0.0, 0.0, ""),
        "controller.count": (7.0, 7.0, ""),
        "controller.limit": (1e-30, np.inf, ""),  # any limit in place of none
        "controller.fine": (0.0, 1.0, ""),
        "guard.limits.attitude.lower": (-UNLIMITED, UNLIMITED, ""),
        "guard.limits.attitude.upper": (-UNLIMITED, UNLIMITED, "guard.limits.attitude.lower"),
        "guard.limits.rate.lower": (-UNLIMITED, UNLIMITED, ""),
        "guard.limits.rate.upper": (-UNLIMITED, UNLIMITED, "guard.limits.rate.lower"),
        "guard.limits.rate.rate": (1e-30, UNLIMITED, ""),
    }


def module_ports(target):
    from gyrostat.codegen.flight import emit

    return emit(target.name, target.entries).ports[target.begin[0].name]


CHECKS = """
#include "damper_tbl.h"
#include <stdio.h>
#include <string.h>
#include <math.h>
typedef uint8_t uint8;
@CHECKS@
int main(void)
{
    DAMPER_Parameters_t designed, table;
    const uint8 two = 2;
    memset(&designed, 0, sizeof designed);
    damper_parameters(&designed.controller, &designed.guard);
#define FAULT (FaultOf(&table) ? FaultOf(&table) : "right")
#define TRY(change) table = designed; change; printf("%s\\n", FAULT)
    TRY((void)0);
    TRY(table.controller.gain[1] = 2.0);
    TRY(table.controller.gain[1] = -2.1);
    TRY(table.controller.gain[0] = NAN);
    TRY(table.controller.bias = 1e-9);
    TRY(table.controller.count = 8);
    TRY(table.controller.limit = 0.5);
    TRY(table.controller.limit = -0.5);
    TRY(table.controller.fine = false);
    TRY(memcpy(&table.controller.fine, &two, 1));
    TRY(table.guard.limits.rate.upper[2] = -1.0);
    TRY(table.guard.limits.rate.rate = 0.0);
    return 0;
}
"""
FOUND = """right
right
controller.gain
controller.gain
controller.bias
controller.count
right
controller.limit
right
controller.fine
guard.limits.rate.upper
guard.limits.rate.rate
"""


def test_the_validation_of_a_table_names_the_parameter_that_is_out_of_range(
    folder, tools, tmp_path
):
    source = folder["fsw/src/damper_table.c"]
    checks = source[source.index("/* Name of the first") : source.index("static void Adopt")]
    for name in ("fsw/mission_inc/damper_tbl.h", "flight/damper.h", "flight/damper.c"):
        (tmp_path / Path(name).name).write_text(folder[name], encoding="utf-8")
    text = CHECKS.replace("@CHECKS@", checks)
    (tmp_path / "main.c").write_text(text, encoding="utf-8")
    command = [tools.compiler(), "main.c", "damper.c", "-lm", "-o", "main"]
    subprocess.run(command, cwd=tmp_path, check=True)
    done = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True)
    assert done.stdout == FOUND


def test_the_table_has_the_designed_values(folder):
    text = folder["fsw/tables/damper.c"]
    for line in (".gain = {0.1, -0.2},", ".bias = 0.0,", ".count = 7,", ".limit = INFINITY,"):
        assert line in text
    assert ".fine = true," in text
    assert ".upper = {1.0, 2.0, 3.0}," in text


def test_two_applications_have_no_name_in_common(folder):
    other = application(renamed(damper(), "wheel_x"), "double", "")
    assert {name.partition("/")[0] for name in other} == {"wheel_x"}
    text = "".join(text for name, text in other.items() if not name.endswith(".txt"))
    assert not re.search(r"\bdamper_\w+\(|DAMPER", text)


def test_numbers_of_single_precision_are_float(folder):
    single = application(damper(), "float", "")
    assert "double" not in single["damper/fsw/mission_inc/damper_msg.h"]
    assert "float rate[3];" in single["damper/fsw/mission_inc/damper_msg.h"]
    assert "double" not in single["damper/fsw/src/damper_table.c"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--what", "wheel"), "found wheel, expected a controller"),
        (("--what", "estimator", "--speed-sigma", "1", "--scale-drift", "1"), "found estimator"),
        (("--what", "controller", "--gains", "1,0,0", "--name", "a_long_name_here"), "14 char"),
        (("--what", "controller", "--gains", "1,0,0", "--name", "X"), "found 'X', expected lower"),
        (("--what", "controller", "--gains", "1,0,0", "--name", "cfe_acs"), "one of cFE's own"),
        (("--what", "controller", "--gains", "1,0,0", "--name", "vector"), "function vector_step"),
        (("--what", "controller", "--gains", "1,0,0", "--name", "math"), "a header of C"),
    ],
)
def test_what_cannot_be_an_application_is_refused_in_one_line(words, told, run, tmp_path):
    model = tmp_path / "model.toml"
    lines = ("[wheel]", "inertia = 1e-3", "motor_constant = 0.02", "[friction]")
    lines = (*lines, 'model = "viscous-coulomb"', "viscous = 1e-6", "coulomb = 1e-3", "")
    model.write_text("\n".join(lines), encoding="utf-8")
    out = tmp_path / "apps"
    code, _, said = run("export", model, "--to", "cfs", "--period", "0.1", *words, "--out", out)
    assert code == 2
    assert told in said
    assert said.count("\n") == 1
    assert not out.exists()


def test_the_verb_writes_a_folder_with_the_name(tmp_path):
    written = gs.export(LAW, tmp_path / "apps", to="cfs", period=PERIOD, name="yaw")
    assert tmp_path / "apps" / "yaw" / "CMakeLists.txt" in written
    assert "yaw_step" in (tmp_path / "apps" / "yaw" / "flight" / "yaw.h").read_text(
        encoding="utf-8"
    )
    with pytest.raises(InputError, match="to json: found name"):
        gs.export(WHEEL, tmp_path / "sheet", to="json", name="yaw")
