/* @app@: @title@.
   Each wake-up message is one tick: ground commands, table, sensor messages, one step of the
   controller, command message. No dynamic memory. */
#include "@app@_app.h"

#include <string.h>

@APP@_Data_t @APP@_Data;

static CFE_Status_t CreatePipe(CFE_SB_PipeId_t *Pipe, const char *Name)
{
    return CFE_SB_CreatePipe(Pipe, @APP@_PIPE_DEPTH, Name);
}

static CFE_Status_t Subscribe(CFE_SB_PipeId_t Pipe, CFE_SB_MsgId_Atom_t Id)
{
    return CFE_SB_SubscribeEx(CFE_SB_ValueToMsgId(Id), Pipe, CFE_SB_DEFAULT_QOS, @APP@_PIPE_DEPTH);
}

static CFE_Status_t InitMessages(void)
{
    CFE_Status_t Status;

    Status = CFE_MSG_Init(CFE_MSG_PTR(@APP@_Data.Housekeeping.TelemetryHeader),
                          CFE_SB_ValueToMsgId(@APP@_HK_TLM_MID), sizeof(@APP@_Data.Housekeeping));
    if (Status == CFE_SUCCESS)
    {
        Status = CFE_MSG_Init(CFE_MSG_PTR(@APP@_Data.Command.TelemetryHeader),
                              CFE_SB_ValueToMsgId(@APP@_COMMAND_TLM_MID), sizeof(@APP@_Data.Command));
    }
    return Status;
}

static CFE_Status_t InitPipes(void)
{
    CFE_Status_t Status = CreatePipe(&@APP@_Data.WakeupPipe, "@APP@_WAK");

    if (Status == CFE_SUCCESS)
    {
        Status = CreatePipe(&@APP@_Data.CommandPipe, "@APP@_CMD");
    }
    if (Status == CFE_SUCCESS)
    {
        Status = CreatePipe(&@APP@_Data.SensorPipe, "@APP@_SEN");
    }
    if (Status == CFE_SUCCESS)
    {
        Status = Subscribe(@APP@_Data.CommandPipe, @APP@_CMD_MID);
    }
    if (Status == CFE_SUCCESS)
    {
        Status = Subscribe(@APP@_Data.CommandPipe, @APP@_SEND_HK_MID);
    }
    if (Status == CFE_SUCCESS)
    {
        Status = Subscribe(@APP@_Data.SensorPipe, @APP@_SENSOR_TLM_MID);
    }
    if (Status == CFE_SUCCESS) /* the last one, so that a tick finds everything ready */
    {
        Status = Subscribe(@APP@_Data.WakeupPipe, @APP@_WAKEUP_MID);
    }
    return Status;
}

bool @APP@_StartController(void)
{
    int Fault;

@start@
    return Fault == 0;
}

static CFE_Status_t Init(void)
{
    static const CFE_EVS_BinFilter_t Filters[] = {
@filters@
    };
    CFE_Status_t Status;
    int          Fault;

    (void)memset(&@APP@_Data, 0, sizeof(@APP@_Data));
@constants@
    @APP@_Data.IsAwake = true;
    Status = CFE_EVS_Register(Filters, (uint16)(sizeof(Filters) / sizeof(Filters[0])),
                              CFE_EVS_EventFilter_BINARY);
@parameters@
    if (Status == CFE_SUCCESS)
    {
        Status = InitMessages();
    }
    else
    {
        (void)CFE_ES_WriteToSysLog("@APP@: found status 0x%08x of the event services\n",
                                   (unsigned int)Status);
    }
    @APP@_InitTable();
    if ((Status == CFE_SUCCESS) && ((Fault != 0) || !@APP@_StartController()))
    {
        Status = @APP@_INVALID;
    }
    if (Status == CFE_SUCCESS)
    {
        Status = InitPipes();
    }
    if (Status == CFE_SUCCESS)
    {
        (void)CFE_EVS_SendEvent(@APP@_INIT_INF_EID, CFE_EVS_EventType_INFORMATION,
                                "@APP@ initialised");
    }
    else
    {
        (void)CFE_EVS_SendEvent(@APP@_INIT_ERR_EID, CFE_EVS_EventType_ERROR,
                                "@APP@ not initialised, status 0x%08x", (unsigned int)Status);
    }
    return Status;
}

/* One step of the controller. Without a valid sample the guard rejects the measurement, predicts
   the memory and gives the safe command. */
static void Step(bool IsFresh)
{
    static @last_memory@;
    static @last_command@;
    @APP@_HkTlm_Payload_t *Counters = &@APP@_Data.Housekeeping.Payload;
    int64_t Reason;
    int     Fault;

    if (IsFresh)
    {
        @APP@_Data.TicksWithoutSample = 0U;
    }
    else
    {
        @APP@_SetMissing();
        ++Counters->MissingSamples;
        ++@APP@_Data.TicksWithoutSample;
        if (@APP@_Data.TicksWithoutSample == @APP@_SENSOR_TIMEOUT_TICKS)
        {
            ++Counters->SensorTimeouts;
            @APP@_Data.HasSampleTime = false; /* the clock of the sensors may have been set */
            (void)CFE_EVS_SendEvent(@APP@_SENSOR_TIMEOUT_EID, CFE_EVS_EventType_ERROR,
                                    "sensor: found no valid message for %u ticks",
                                    (unsigned int)@APP@_SENSOR_TIMEOUT_TICKS);
        }
    }
    (void)memcpy(&LastMemory, &@APP@_Data.Values.memory, sizeof(LastMemory));
    (void)memcpy(&LastCommand, &@APP@_Data.Values.command, sizeof(LastCommand));
@step@
    if (Fault != 0)
    {
        /* a loop has reached its bound: the memory is the last one, the command the safe one */
        ++Counters->StepErrors;
        (void)memcpy(&@APP@_Data.Values.memory, &LastMemory, sizeof(LastMemory));
        @safe@
        @APP@_Data.Values.report.sample_status = SAMPLE_STATUS_NOT_COMPUTED;
    }
    Reason = @APP@_Data.Values.report.sample_status;
    if (IsFresh && (Reason >= 0) && (Reason < (int64_t)@APP@_SAMPLE_STATUSES))
    {
        ++Counters->Samples[Reason];
        if (Reason != SAMPLE_STATUS_GOOD)
        {
            (void)CFE_EVS_SendEvent(@APP@_SAMPLE_REJECTED_EID, CFE_EVS_EventType_ERROR,
                                    "sensor: found a sample of status %d, expected 0", (int)Reason);
        }
    }
}

uint32 @APP@_Limited(int64_t Count)
{
    return (Count > (int64_t)UINT32_MAX) ? UINT32_MAX : (uint32)Count;
}

/* Send the command of this tick. */
static void Publish(void)
{
    @APP@_CommandTlm_Payload_t *Payload = &@APP@_Data.Command.Payload;
    CFE_Status_t Status;

    Payload->SampleTime         = @APP@_Data.LastSampleTime;
    Payload->Tick               = @APP@_Data.Tick;
    Payload->SampleStatus       = @APP@_Limited(@APP@_Data.Values.report.sample_status);
    Payload->SamplesMissed      = @APP@_Limited(@APP@_Data.Values.report.samples_missed);
    Payload->TicksWithoutSample = @APP@_Data.TicksWithoutSample;
@outputs@
    Payload->Crc = @APP@_CommandCrc(Payload);
    Status = CFE_SB_TransmitMsg(CFE_MSG_PTR(@APP@_Data.Command.TelemetryHeader), true);
    if (Status != CFE_SUCCESS)
    {
        ++@APP@_Data.Housekeeping.Payload.PublishErrors;
    }
}

/* One control period. The table changes before the step only: a tick has one set of parameters. */
static void Tick(void)
{
    bool IsFresh;

    @APP@_ReadCommands();
    @APP@_ManageTable();
    ++@APP@_Data.Tick;
    ++@APP@_Data.Housekeeping.Payload.Ticks;
    IsFresh = @APP@_ReadSensors();
    Step(IsFresh);
    @APP@_CheckTableInTick();
    Publish();
}

/* A scheduler that does not send wake-up messages stops the controller, not the commands. */
static void NoWakeup(void)
{
    ++@APP@_Data.Housekeeping.Payload.WakeupTimeouts;
    if (@APP@_Data.IsAwake)
    {
        @APP@_Data.IsAwake = false;
        (void)CFE_EVS_SendEvent(@APP@_WAKEUP_TIMEOUT_EID, CFE_EVS_EventType_ERROR,
                                "scheduler: found no wake-up message for %u ms",
                                (unsigned int)@APP@_WAKEUP_TIMEOUT_MS);
    }
    @APP@_ReadCommands();
    @APP@_ManageTable();
}

void @APP@_Main(void)
{
    CFE_SB_Buffer_t *Buffer    = NULL;
    uint32           RunStatus = CFE_ES_RunStatus_APP_RUN;

    CFE_ES_PerfLogEntry(@APP@_PERF_ID);
    if (Init() != CFE_SUCCESS)
    {
        RunStatus = CFE_ES_RunStatus_APP_ERROR;
    }
    while (CFE_ES_RunLoop(&RunStatus) == true)
    {
        CFE_Status_t Status;

        CFE_ES_PerfLogExit(@APP@_PERF_ID);
        Status = CFE_SB_ReceiveBuffer(&Buffer, @APP@_Data.WakeupPipe, @APP@_WAKEUP_TIMEOUT_MS);
        CFE_ES_PerfLogEntry(@APP@_PERF_ID);
        if (Status == CFE_SUCCESS)
        {
            @APP@_Data.IsAwake = true;
            if (@APP@_HasMessageId(Buffer, @APP@_WAKEUP_MID)
                && @APP@_HasLength(Buffer, sizeof(@APP@_NoArgsCmd_t)))
            {
                Tick();
            }
        }
        else if (Status == CFE_SB_TIME_OUT)
        {
            NoWakeup();
        }
        else
        {
            (void)CFE_EVS_SendEvent(@APP@_PIPE_ERR_EID, CFE_EVS_EventType_CRITICAL,
                                    "wake-up pipe: found status 0x%08x", (unsigned int)Status);
            RunStatus = CFE_ES_RunStatus_APP_ERROR;
        }
    }
    CFE_ES_ExitApp(RunStatus);
}
