/* Messages of @app@. SI units and radians, in the byte order and alignment of the processor; the
   README lists the fields with units and offsets. */
#ifndef @APP@_MSG_H
#define @APP@_MSG_H

#include "cfe.h"

#include <stddef.h>

/* Function codes of @APP@_CMD_MID. No command has a payload. */
@codes@

/* Number of values of SampleStatus. */
@statuses@

/* Ground command, wake-up and request of housekeeping: a command header without payload. */
typedef struct
{
    CFE_MSG_CommandHeader_t CommandHeader;
} @APP@_NoArgsCmd_t;

/* Sensor message: one sample of all measurements, with the mission elapsed time of the sample and
   @APP@_SensorCrc of the payload. */
typedef struct
{
@sensor_fields@
} @APP@_SensorTlm_Payload_t;

typedef struct
{
    CFE_MSG_TelemetryHeader_t TelemetryHeader;
    @APP@_SensorTlm_Payload_t Payload;
} @APP@_SensorTlm_t;

/* Command message, sent once in every tick, with @APP@_CommandCrc of the payload. */
typedef struct
{
@command_fields@
} @APP@_CommandTlm_Payload_t;

typedef struct
{
    CFE_MSG_TelemetryHeader_t TelemetryHeader;
    @APP@_CommandTlm_Payload_t Payload;
} @APP@_CommandTlm_t;

/* Housekeeping. Counters are those since the start or the last reset, modulo 2^32. */
typedef struct
{
@housekeeping@
} @APP@_HkTlm_Payload_t;

typedef struct
{
    CFE_MSG_TelemetryHeader_t TelemetryHeader;
    @APP@_HkTlm_Payload_t Payload;
} @APP@_HkTlm_t;

/* The layouts that the README lists. */
CompileTimeAssert(sizeof(@APP@_SensorTlm_Payload_t) == @sensor_size@U, @APP@_SensorTlmSize);
CompileTimeAssert(offsetof(@APP@_SensorTlm_Payload_t, Crc) == @sensor_crc@U, @APP@_SensorTlmLayout);
CompileTimeAssert(sizeof(@APP@_CommandTlm_Payload_t) == @command_size@U, @APP@_CommandTlmSize);
CompileTimeAssert(offsetof(@APP@_CommandTlm_Payload_t, Crc) == @command_crc@U, @APP@_CommandTlmLayout);

/* CRC of everything before the field Crc. The sender of a sensor message fills in the result. */
static inline uint32 @APP@_SensorCrc(const @APP@_SensorTlm_Payload_t *Payload)
{
    return CFE_ES_CalculateCRC(
        Payload, offsetof(@APP@_SensorTlm_Payload_t, Crc), 0, CFE_MISSION_ES_DEFAULT_CRC);
}

static inline uint32 @APP@_CommandCrc(const @APP@_CommandTlm_Payload_t *Payload)
{
    return CFE_ES_CalculateCRC(
        Payload, offsetof(@APP@_CommandTlm_Payload_t, Crc), 0, CFE_MISSION_ES_DEFAULT_CRC);
}

#endif
