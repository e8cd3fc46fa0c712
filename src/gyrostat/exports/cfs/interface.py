"""Interface of every cFS application: message ids, commands, counters, events, settings."""

from dataclasses import dataclass

from gyrostat.exports.message_fields import Field


@dataclass(frozen=True)
class Named:
    """Constant or counter of the interface.

    Attributes:
        name: Name in C, without the prefix of the application.
        value: Value, as text of C.
        meaning: Description.
    """

    name: str
    value: str
    meaning: str


SENSOR_HEAD = (Field("SampleTime", "", "time", (), "time of the sample, mission elapsed time"),)
"""Fields of a sensor message before those of the measurement."""
COMMAND_HEAD = (
    Field("SampleTime", "", "time", (), "time of the last accepted sample"),
    Field("Tick", "", "count", (), "number of this tick; the first is 1", 8),
    Field("SampleStatus", "", "count", (), "status of the sample, see `SampleStatus`", 12),
    Field("SamplesMissed", "", "count", (), "samples since the last one that gave a command", 16),
    Field("TicksWithoutSample", "", "count", (), "ticks since the last valid sensor message", 20),
)
"""Fields of a command message before those of the command."""

IDS = (
    Named("CMD_MID", "0x18E0U", "ground commands"),
    Named("SEND_HK_MID", "0x18E1U", "request of housekeeping"),
    Named("WAKEUP_MID", "0x18E2U", "wake-up: one tick of the controller"),
    Named("SENSOR_TLM_MID", "0x08E0U", "sensor message, which the application receives"),
    Named("COMMAND_TLM_MID", "0x08E1U", "command message, which the application sends"),
    Named("HK_TLM_MID", "0x08E2U", "housekeeping"),
)
"""Message ids."""

COMMANDS = (
    Named("NOOP_CC", "0", "No-op: counted, with an event."),
    Named("RESET_COUNTERS_CC", "1", "Set all counters to zero and reset the event filters."),
    Named("RESET_CONTROLLER_CC", "2", "Set the controller to its state before the first sample."),
)
"""Ground commands."""

COUNTERS = (
    Named("CommandCounter", "", "ground commands carried out"),
    Named("CommandErrorCounter", "", "ground commands rejected"),
    Named("Ticks", "", "ticks of the controller"),
    Named("LengthErrors", "", "messages of another length"),
    Named("MessageIdErrors", "", "messages with another id than that of their pipe"),
    Named("ChecksumErrors", "", "ground commands and sensor messages with a wrong checksum"),
    Named("StaleSamples", "", "samples that were too old, of the future or out of order"),
    Named("RepeatedSamples", "", "samples with the time stamp of the last one"),
    Named("MissingSamples", "", "ticks without a valid sensor message"),
    Named("StepErrors", "", "steps of the controller that failed; the command is the safe one"),
    Named("SensorTimeouts", "", "times that SENSOR_TIMEOUT_TICKS ticks in a row had none"),
    Named("WakeupTimeouts", "", "times that no wake-up message came for WAKEUP_TIMEOUT_MS"),
    Named("PublishErrors", "", "messages that the software bus did not take"),
    Named("ControllerResets", "", "resets of the controller by command"),
    Named("TableLoads", "", "tables taken into use, with that of the start"),
    Named("TableErrors", "", "tables with a value out of its range; the last valid one stays"),
    Named("TableLoadsInTick", "", "table loads during a tick, used from the next one"),
    Named("TableServiceErrors", "", "errors of the table services"),
)
"""Counters in housekeeping."""

STATUSES = "Samples"
"""Name of the counters of valid sensor messages, one for each `SampleStatus`."""

STATE = (
    Named("SampleStatus", "", "status of the last sample, see SampleStatus"),
    Named("SamplesMissed", "", "samples since the last one that gave a command"),
)
"""Fields of housekeeping that are no counters."""

FILTERED = (
    Named("LENGTH_EID", "1", "A message has another length."),
    Named("MESSAGE_ID_EID", "2", "A message has another id than that of its pipe."),
    Named("CHECKSUM_EID", "3", "The checksum of a command or sensor message is wrong."),
    Named("SAMPLE_TIME_EID", "4", "The time stamp of a sample is stale, repeated or ahead."),
    Named("SAMPLE_REJECTED_EID", "5", "The guard rejected a sample, or values of it."),
    Named("SENSOR_TIMEOUT_EID", "6", "No valid sensor message for SENSOR_TIMEOUT_TICKS ticks."),
    Named("TABLE_EID", "7", "A table has a value out of its range."),
)
"""Events with a filter of the event services, which have less than 8 for an application."""

LIMITED = (Named("TABLE_IN_TICK_EID", "8", "A table was loaded during a tick."),)
"""Events that the application limits as a filter would."""

EVENTS = (
    Named("INIT_INF_EID", "9", "The application has started."),
    Named("INIT_ERR_EID", "10", "The application could not start."),
    Named("COMMAND_INF_EID", "11", "A ground command was carried out."),
    Named("COMMAND_CODE_EID", "12", "A ground command has an unknown function code."),
    Named("WAKEUP_TIMEOUT_EID", "13", "No wake-up message; once until the next one."),
    Named("PIPE_ERR_EID", "14", "The pipe of wake-up messages failed; the application ends."),
    Named("TABLE_START_EID", "15", "No table or no valid file at the start: designed parameters."),
)
"""Events that are not filtered."""

ALL_EVENTS = (*FILTERED, *LIMITED, *EVENTS)
"""Events, in the order of their ids."""


def settings(period: float) -> tuple[Named, ...]:
    """Settings of an application with a control period, s."""
    milliseconds = 1e3 * period

    def whole(periods: float) -> str:
        return f"{max(1, round(periods * milliseconds))}"

    return (
        Named("PERF_ID", "96", "id of the performance log"),
        Named("PIPE_DEPTH", "8U", "messages in each pipe, and most that a tick reads of one"),
        Named("SENSOR_MAX_AGE_MS", f"{whole(2.0)}U", "oldest sample that is used, ms"),
        Named("SENSOR_TIMEOUT_TICKS", "5U", "ticks without a valid message until the time-out"),
        Named("WAKEUP_TIMEOUT_MS", whole(5.0), "longest wait for a wake-up message, ms"),
        Named("EVENT_MASK", "0x003FU", "filter of events: the first of every 64 is sent"),
    )
