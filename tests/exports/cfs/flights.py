"""Plants in C for the test application, with the noise of a simulation, and its texts."""

from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from gyrostat.codegen.flight import Entry, emit
from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.header import declaration
from gyrostat.codegen.flight.module import call, ports_of
from gyrostat.core.jax64 import jax, jnp
from gyrostat.exports.cfs.interface import COMMAND_HEAD, COUNTERS, SENSOR_HEAD, STATE, STATUSES
from gyrostat.exports.cfs.messages import Payload, read_lines, written_lines
from gyrostat.simulation.command_delay import delay_line, delayed

HERE = Path(__file__).parent
COUNTS = (
    *(counter.name for counter in COUNTERS),
    *(f"{STATUSES}[{k}]" for k in range(6)),
    *(field.name for field in STATE),
)
"""Numbers of housekeeping, in its order."""
HEAD = ("tick", "status", "missed", "without")
"""Numbers before those that a flight records."""
CMAKE = """\
project(CFE_FLYER C)
add_cfe_app(fly_{app} flyer.c plant.c)
target_link_libraries(fly_{app} m)
target_compile_options(fly_{app} PRIVATE -ffp-contract=off -Wno-cast-align)
add_cfe_app_dependency(fly_{app} {app})
"""
# What the exported application is built with: time stamps of a simulated hour, a wake-up time-out
# of a second, strict warnings, and a hook around its step.
BESIDE = """
target_compile_definitions({app} PUBLIC {APP}_SENSOR_MAX_AGE_MS=3600000U)
target_compile_definitions({app} PUBLIC {APP}_WAKEUP_TIMEOUT_MS=1000 {ids})
target_sources({app} PRIVATE hook.c)
target_link_libraries({app} -Wl,--wrap={app}_step)
"""
STRICT, LENIENT = "-Wall -Wextra -Wshadow -Werror", "-Wno-error"


class _Drawn:
    """Normal numbers: taken from a vector, or counted and kept."""

    def __init__(self, numbers=None):
        self.numbers, self.kept, self.used = numbers, [], 0
        self._normal = jax.random.normal

    def __call__(self, key, shape=(), *_):
        count = prod(shape)
        self.used += count
        if self.numbers is None:
            value = self._normal(key, shape)
            self.kept.append(jnp.ravel(value))
            return value
        return jnp.reshape(self.numbers[self.used - count : self.used], shape)


@contextmanager
def _drawing(drawn):
    keys = () if drawn.numbers is None else ("split", "fold_in")

    def no_key(_, count=2):
        return [None] * count

    with patch.object(jax.random, "normal", drawn):
        if not keys:
            yield
            return
        with patch.object(jax.random, "split", no_key), patch.object(jax.random, "fold_in", no_key):
            yield


class Sensed(NamedTuple):
    """Memory of the sensor; its class names the type in C."""

    memory: Any


class Line(NamedTuple):
    """Delay line of the commands."""

    queues: Any


class Flight:
    """Plant, sensor and delay of a closed loop, as C and as the noise of a simulation.

    Args:
        app: Name of the application.
        plant: Plant.
        sensor: Its sensor.
        controller: Controller, for the shapes of its command.
        start: State at time 0.
        period: Control period, s.
        delay: Control periods from a sample to its command.
        disturbed: First element of the measurement that faults disturb, C.
        recorded: C expressions, in the plant's state, of what is recorded.
    """

    def __init__(self, app, plant, sensor, controller, start, period, delay, disturbed, recorded):
        self.app, self.period, self.recorded = app, period, recorded
        self._sensor, self._start, self._disturbed = sensor, start, disturbed
        memory = sensor.start(start, period)
        first = _Drawn()
        with _drawing(first):
            measurement = sensor(memory, start, jax.random.key(0))[1]
        self.noise_count = max(1, first.used)
        command = jax.eval_shape(controller, controller.start(period), measurement)[1]
        command = jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), command)
        line = delay_line(plant, start, command, period, delay) if delay else ()

        def begin():
            """State at time 0."""
            return start, Sensed(memory), Line(line)

        def sense(state, sensed, noise):
            """Measure."""
            with _drawing(_Drawn(noise)):
                memory, measurement = sensor(sensed.memory, state, None)
                return Sensed(memory), measurement

        def move(state, line, command, time):
            """Integrate over a control period."""
            queues, acting = delayed(line.queues, command)
            state, resolved = plant(state, acting, time, jnp.asarray(period))
            return state, Line(queues), resolved

        noise = np.zeros(self.noise_count)
        moved = {"state": start, "line": Line(line), "command": command, "time": 0.0}
        sensed = {"state": start, "sensed": Sensed(memory), "noise": noise}
        self.module = emit(
            "plant",
            [
                Entry("plant_begin", begin, {}, ("state", "sensed", "line")),
                Entry("plant_sense", sense, sensed, ("sensed", "measurement")),
                Entry("plant_move", move, moved, ("state", "line", "resolved")),
            ],
        )

    def noise(self, key, count):
        """Normal numbers of each sample of a run, (count, numbers), from its random key."""

        def draws(k):
            drawn = _Drawn()
            with _drawing(drawn):
                self._sensor(
                    self._sensor.start(self._start, self.period),
                    self._start,
                    jax.random.fold_in(key, k),
                )
            return jnp.concatenate([*drawn.kept, jnp.zeros(self.noise_count - drawn.used)])

        return np.asarray(jax.vmap(draws)(jnp.arange(count)))

    def flyer(self):
        """Files of the test application."""
        ports = ports_of(self.module)
        payloads = {
            name: Payload.of(ports[name].content, name, head, "double")
            for name, head in (("measurement", SENSOR_HEAD), ("command", COMMAND_HEAD))
        }
        lines = {
            "ports": [f"    {declaration(p.content, p.name, Dialect())};" for p in ports.values()],
            "sensor": written_lines(payloads["measurement"].fields, "Payload", "Plant.measurement"),
            "command": read_lines(payloads["command"].fields, "Payload", "Plant.command"),
        }
        gaps = {name: "\n".join(text) for name, text in lines.items()}
        gaps |= {
            "app": self.app,
            "APP": self.app.upper(),
            "period": repr(float(self.period)),
            "disturbed": self._disturbed,
            "recorded": ", ".join(f"(double)Plant.{text}" for text in self.recorded),
            "noise_count": str(self.noise_count),
            "begin": call(self.module, "plant_begin", "Plant."),
            "sense": call(self.module, "plant_sense", "Plant."),
            "move": call(self.module, "plant_move", "Plant."),
        }
        return {
            "CMakeLists.txt": CMAKE.format(app=self.app),
            "flyer.c": _filled("flyer.c", gaps),
            "plant.c": self.module.source,
            "plant.h": self.module.header,
        }

    def startup(self):
        """Lines of the startup script."""
        app, name = self.app, self.app.upper()
        return (
            f"CFE_APP, {app}, {name}_Main, {name}, 50, 65536, 0x0, 0;\n"
            f"CFE_APP, fly_{app}, FLYER_Main, FLY_{name}, 60, 65536, 0x0, 0;\n"
        )

    def rows(self, folder, ticks):
        """Recorded numbers: name -> values over the ticks; and the last housekeeping."""
        names = [*HEAD, *self.recorded, *COUNTS]
        numbers = np.fromfile(folder / f"{self.app}.rows")
        last = dict(zip(COUNTS, numbers[-len(COUNTS) :].astype(int), strict=True))
        table = numbers[: -len(COUNTS)].reshape(ticks, len(names))
        return {name: table[:, k] for k, name in enumerate(names)}, last

    def events(self, folder):
        """Event id -> number of events that the application sent."""
        lines = (folder / f"{self.app}.events").read_text(encoding="utf-8").splitlines()
        ids = [int(line.split()[2]) for line in lines if line.split()[1] == self.app.upper()]
        return {number: ids.count(number) for number in sorted({*ids})}


def for_test(app, texts, ids="", strict=True):
    """Texts of an exported application, built as a test needs it."""
    header = texts[f"flight/{app}.h"]
    start = header.index(f"int {app}_step(") + len(f"int {app}_step(")
    parameters = header[start : header.index(");", start)]
    arguments = ", ".join(part.split("*")[-1].split()[-1] for part in parameters.split(","))
    gaps = {"app": app, "APP": app.upper(), "parameters": parameters, "arguments": arguments}
    beside = BESIDE.format(**gaps, ids=ids)
    names = [name for name in texts if name[:8] == "fsw/src/" and name[-2:] == ".c"]
    sources = " ".join([*names, f"flight/{app}.c"])
    options = (STRICT if strict else LENIENT).replace(" ", ";")
    beside += f'set_property(SOURCE {sources} APPEND PROPERTY COMPILE_OPTIONS "{options}")\n'
    return texts | {
        "hook.c": _filled("hook.c", gaps),
        "CMakeLists.txt": texts["CMakeLists.txt"] + beside,
    }


def other_ids(prefix):
    """Message ids of a second application in a mission, as options of its build."""
    names = ("CMD_MID", "SEND_HK_MID", "WAKEUP_MID")
    ids = [f"{prefix}_{name}={0x18F0 + k}" for k, name in enumerate(names)]
    names = ("SENSOR_TLM_MID", "COMMAND_TLM_MID", "HK_TLM_MID")
    return " ".join([*ids, *(f"{prefix}_{name}={0x08F0 + k}" for k, name in enumerate(names))])


def _filled(name, gaps):
    text = (HERE / name).read_text(encoding="utf-8")
    for gap, value in gaps.items():
        text = text.replace(f"@{gap}@", value)
    return text.replace("@APP@", gaps["APP"]).replace("@app@", gaps["app"])
