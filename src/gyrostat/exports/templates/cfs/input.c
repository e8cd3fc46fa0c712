/* Messages that @app@ receives, and what is checked of each. */
#include "@app@_app.h"

#include <math.h>
#include <string.h>

bool @APP@_HasMessageId(const CFE_SB_Buffer_t *Buffer, CFE_SB_MsgId_Atom_t Expected)
{
    CFE_SB_MsgId_t     Id     = CFE_SB_INVALID_MSG_ID;
    const CFE_Status_t Status = CFE_MSG_GetMsgId(&Buffer->Msg, &Id);
    const bool         Fits   = (Status == CFE_SUCCESS) && (CFE_SB_MsgIdToValue(Id) == Expected);

    if (!Fits)
    {
        ++@APP@_Data.Housekeeping.Payload.MessageIdErrors;
        (void)CFE_EVS_SendEvent(@APP@_MESSAGE_ID_EID, CFE_EVS_EventType_ERROR,
                                "message: found id 0x%04lx, expected 0x%04lx",
                                (unsigned long)CFE_SB_MsgIdToValue(Id), (unsigned long)Expected);
    }
    return Fits;
}

bool @APP@_HasLength(const CFE_SB_Buffer_t *Buffer, size_t Expected)
{
    CFE_MSG_Size_t     Size   = 0;
    const CFE_Status_t Status = CFE_MSG_GetSize(&Buffer->Msg, &Size);
    const bool         Fits   = (Status == CFE_SUCCESS) && (Size == Expected);

    if (!Fits)
    {
        ++@APP@_Data.Housekeeping.Payload.LengthErrors;
        (void)CFE_EVS_SendEvent(@APP@_LENGTH_EID, CFE_EVS_EventType_ERROR,
                                "message: found %lu bytes, expected %lu",
                                (unsigned long)Size, (unsigned long)Expected);
    }
    return Fits;
}

static void CountChecksum(const char *What)
{
    ++@APP@_Data.Housekeeping.Payload.ChecksumErrors;
    (void)CFE_EVS_SendEvent(@APP@_CHECKSUM_EID, CFE_EVS_EventType_ERROR,
                            "%s: found a wrong checksum", What);
}

/* Whether a ground command has its cFE checksum. */
static bool HasChecksum(const CFE_SB_Buffer_t *Buffer)
{
    bool               IsValid = false;
    const CFE_Status_t Status  = CFE_MSG_ValidateChecksum(&Buffer->Msg, &IsValid);
    const bool         Fits    = (Status == CFE_SUCCESS) && IsValid;

    if (!Fits)
    {
        CountChecksum("command");
    }
    return Fits;
}

static void ResetCounters(void)
{
    (void)memset(&@APP@_Data.Housekeeping.Payload, 0, sizeof(@APP@_Data.Housekeeping.Payload));
    (void)CFE_EVS_ResetAllFilters();
}

/* Carry out a command; returns whether it could be. */
static bool Execute(CFE_MSG_FcnCode_t Code)
{
    const char *Name   = "no-op";
    bool        IsDone = true;

    switch (Code)
    {
        case @APP@_NOOP_CC:
            break;
        case @APP@_RESET_COUNTERS_CC:
            Name = "reset counters";
            ResetCounters();
            break;
        case @APP@_RESET_CONTROLLER_CC:
            Name   = "reset controller";
            IsDone = @APP@_StartController();
            ++@APP@_Data.Housekeeping.Payload.ControllerResets;
            break;
        default:
            IsDone = false;
            (void)CFE_EVS_SendEvent(@APP@_COMMAND_CODE_EID, CFE_EVS_EventType_ERROR,
                                    "command: found function code %u, expected 0 to 2",
                                    (unsigned int)Code);
            break;
    }
    if (IsDone)
    {
        (void)CFE_EVS_SendEvent(@APP@_COMMAND_INF_EID, CFE_EVS_EventType_INFORMATION,
                                "command: %s", Name);
    }
    return IsDone;
}

static void ReceiveCommand(const CFE_SB_Buffer_t *Buffer)
{
    CFE_MSG_FcnCode_t Code = 0;
    bool IsDone = @APP@_HasLength(Buffer, sizeof(@APP@_NoArgsCmd_t)) && HasChecksum(Buffer);

    IsDone = IsDone && (CFE_MSG_GetFcnCode(&Buffer->Msg, &Code) == CFE_SUCCESS) && Execute(Code);
    if (!IsDone)
    {
        ++@APP@_Data.Housekeeping.Payload.CommandErrorCounter;
    }
    else if (Code != @APP@_RESET_COUNTERS_CC)
    {
        ++@APP@_Data.Housekeeping.Payload.CommandCounter;
    }
    else
    {
        /* a reset of the counters is not counted */
    }
}

static void SendHousekeeping(const CFE_SB_Buffer_t *Buffer)
{
    @APP@_HkTlm_Payload_t *Payload = &@APP@_Data.Housekeeping.Payload;

    if (@APP@_HasLength(Buffer, sizeof(@APP@_NoArgsCmd_t)))
    {
        CFE_Status_t Status;

        Payload->SampleStatus  = @APP@_Limited(@APP@_Data.Values.report.sample_status);
        Payload->SamplesMissed = @APP@_Limited(@APP@_Data.Values.report.samples_missed);
        CFE_SB_TimeStampMsg(CFE_MSG_PTR(@APP@_Data.Housekeeping.TelemetryHeader));
        Status = CFE_SB_TransmitMsg(CFE_MSG_PTR(@APP@_Data.Housekeeping.TelemetryHeader), true);
        if (Status != CFE_SUCCESS)
        {
            ++Payload->PublishErrors;
        }
    }
}

void @APP@_ReadCommands(void)
{
    CFE_SB_Buffer_t *Buffer = NULL;
    CFE_SB_MsgId_t   Id;
    uint32           Count;

    for (Count = 0U; Count < @APP@_PIPE_DEPTH; ++Count)
    {
        if (CFE_SB_ReceiveBuffer(&Buffer, @APP@_Data.CommandPipe, CFE_SB_POLL) != CFE_SUCCESS)
        {
            break; /* no more messages */
        }
        Id = CFE_SB_INVALID_MSG_ID;
        if ((CFE_MSG_GetMsgId(&Buffer->Msg, &Id) == CFE_SUCCESS)
            && (CFE_SB_MsgIdToValue(Id) == @APP@_SEND_HK_MID))
        {
            SendHousekeeping(Buffer);
        }
        else if (@APP@_HasMessageId(Buffer, @APP@_CMD_MID))
        {
            ReceiveCommand(Buffer);
        }
        else
        {
            /* counted by @APP@_HasMessageId */
        }
    }
}

/* Whether a sample is not older than allowed, not of the future, and newer than the last one. */
static bool IsTimely(CFE_TIME_SysTime_t Sample)
{
    @APP@_HkTlm_Payload_t   *Counters = &@APP@_Data.Housekeeping.Payload;
    const CFE_TIME_SysTime_t Now      = CFE_TIME_GetMET();
    const bool               IsAhead  = (CFE_TIME_Compare(Sample, Now) == CFE_TIME_A_GT_B);
    CFE_TIME_SysTime_t       Age      = CFE_TIME_Subtract(Now, Sample);
    CFE_TIME_Compare_t       Order    = CFE_TIME_A_GT_B;
    const char              *Fault    = NULL;
    CFE_TIME_SysTime_t       Oldest;

    if (IsAhead)
    {
        Age = CFE_TIME_Subtract(Sample, Now);
    }
    Oldest.Seconds    = @APP@_SENSOR_MAX_AGE_MS / 1000U;
    Oldest.Subseconds = CFE_TIME_Micro2SubSecs((@APP@_SENSOR_MAX_AGE_MS % 1000U) * 1000U);
    if (@APP@_Data.HasSampleTime)
    {
        Order = CFE_TIME_Compare(Sample, @APP@_Data.LastSampleTime);
    }
    if (Order == CFE_TIME_EQUAL)
    {
        Fault = "repeated";
        ++Counters->RepeatedSamples;
    }
    else if ((Order != CFE_TIME_A_GT_B) || (CFE_TIME_Compare(Age, Oldest) == CFE_TIME_A_GT_B))
    {
        Fault = IsAhead ? "future" : "stale";
        ++Counters->StaleSamples;
    }
    else
    {
        @APP@_Data.LastSampleTime = Sample;
        @APP@_Data.HasSampleTime  = true;
    }
    if (Fault != NULL)
    {
        (void)CFE_EVS_SendEvent(@APP@_SAMPLE_TIME_EID, CFE_EVS_EventType_ERROR,
                                "sensor: found a %s time stamp", Fault);
    }
    return Fault == NULL;
}

/* Use a sensor message if it is valid. It is copied first: what is checked cannot change any more. */
static bool Accept(const CFE_SB_Buffer_t *Buffer)
{
    @APP@_SensorTlm_t                Message;
    const @APP@_SensorTlm_Payload_t *Payload = &Message.Payload;
    bool IsGood = @APP@_HasMessageId(Buffer, @APP@_SENSOR_TLM_MID);

    IsGood = IsGood && @APP@_HasLength(Buffer, sizeof(Message));
    if (IsGood)
    {
        (void)memcpy(&Message, Buffer, sizeof(Message));
        if (Payload->Crc != @APP@_SensorCrc(Payload))
        {
            IsGood = false;
            CountChecksum("sensor");
        }
    }
    if (IsGood && IsTimely(Payload->SampleTime))
    {
@inputs@
    }
    else
    {
        IsGood = false;
    }
    return IsGood;
}

bool @APP@_ReadSensors(void)
{
    CFE_SB_Buffer_t *Buffer  = NULL;
    bool             IsFresh = false;
    uint32           Count;

    for (Count = 0U; Count < @APP@_PIPE_DEPTH; ++Count) /* the newest valid sample is used */
    {
        if (CFE_SB_ReceiveBuffer(&Buffer, @APP@_Data.SensorPipe, CFE_SB_POLL) != CFE_SUCCESS)
        {
            break; /* no more messages */
        }
        IsFresh = Accept(Buffer) || IsFresh;
    }
    return IsFresh;
}
@fill@
void @APP@_SetMissing(void)
{
@missing@
}
