/* Internal interface of @app@. */
#ifndef @APP@_APP_H
#define @APP@_APP_H

#include "@app@_cfg.h"
#include "@app@_events.h"
#include "@app@_msg.h"
#include "@app@_msgids.h"
#include "@app@_tbl.h"
#include "cfe.h"

/* Status of parameters that cannot be used. */
#define @APP@_INVALID ((CFE_Status_t)-1)

/* Arguments of the flight module @app@. */
typedef struct
{
@values@
} @APP@_Values_t;

typedef struct
{
    CFE_SB_PipeId_t  WakeupPipe;
    CFE_SB_PipeId_t  CommandPipe;
    CFE_SB_PipeId_t  SensorPipe;
    CFE_TBL_Handle_t TableHandle;
    bool             HasTable; /* whether the table services have taken the table */

    @APP@_Values_t     Values;
    @APP@_Parameters_t Candidate; /* copy of a new table, until it is found valid */

    CFE_TIME_SysTime_t LastSampleTime; /* time of the last accepted sample */
    bool               HasSampleTime;  /* whether the next sample must be newer */
    bool               IsAwake;        /* whether the last wait gave a wake-up message */
    uint32             Tick;           /* ticks since the start of the application */
    uint32             TicksWithoutSample;

    @APP@_HkTlm_t      Housekeeping;
    @APP@_CommandTlm_t Command;
} @APP@_Data_t;

extern @APP@_Data_t @APP@_Data;

/* Entry point. */
void @APP@_Main(void);

/* Set the state of the controller before its first sample. */
bool @APP@_StartController(void);

/* A count as a field of a message. */
uint32 @APP@_Limited(int64_t Count);

/* Carry out the ground commands and requests that have arrived. */
void @APP@_ReadCommands(void);

/* Read the sensor messages that have arrived; returns whether a sample was accepted. */
bool @APP@_ReadSensors(void);

/* Whether a message has its message id, which is in a pipe for it; otherwise it is counted. */
bool @APP@_HasMessageId(const CFE_SB_Buffer_t *Buffer, CFE_SB_MsgId_Atom_t Expected);

/* Whether a message has its length; otherwise it is counted. */
bool @APP@_HasLength(const CFE_SB_Buffer_t *Buffer, size_t Expected);

/* A measurement that the guard rejects, for a tick without a valid sensor message. */
void @APP@_SetMissing(void);

/* Register the table and load it. On failure the parameters are the designed ones, because a
   controller without a table is better than none. */
void @APP@_InitTable(void);

/* Validate and activate a loaded table between two ticks. */
void @APP@_ManageTable(void);

/* Count a table load that has arrived during a tick; the next tick uses it. */
void @APP@_CheckTableInTick(void);

/* Validation function of the table. */
CFE_Status_t @APP@_ValidateTable(void *Table);

#endif
