/* Test application: flies the plant of a simulation in closed loop with the application @app@, in
   lock-step. It is the sensors, the scheduler, the wheels and the ground station.

   Files in the working folder: @app@.script (ticks, then lines "tick action argument"),
   @app@.noise (doubles, one row for each sample), @app@.rows (doubles, one row for each tick),
   @app@.events (texts), and at the end @app@.done or @app@.failed. */
#include "@app@_msg.h"
#include "@app@_msgids.h"
#include "plant.h"

#include "cfe.h"
#include "cfe_evs_msg.h"
#include "cfe_msgids.h"
#include "cfe_tbl_msg.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_ACTIONS 256
#define MOST_WAIT 20000 /* ms */

typedef struct
{
@ports@
} Plant_t;

typedef struct
{
    unsigned long Tick;
    char          Name[32];
    char          Argument[32];
} Action_t;

static Plant_t         Plant;
static Action_t        Actions[MOST_ACTIONS];
static unsigned        ActionCount;
static CFE_SB_PipeId_t CommandPipe, HousekeepingPipe, EventPipe;
static FILE           *Events;
static unsigned long   Ticks, Tick, Started;
static osal_id_t       Arm, Reached, Resume;
static bool            IsSent, IsShared;
static uint32          Seed = 1;
static double          Clock; /* s, of the sensors beside the simulated time */

static void Fail(const char *What)
{
    FILE *File = fopen("@app@.failed", "w");

    if (File != NULL)
    {
        fprintf(File, "tick %lu: %s\n", Tick, What);
        fclose(File);
    }
    fflush(NULL);
    CFE_ES_ExitApp(CFE_ES_RunStatus_APP_ERROR);
    OS_TaskExit();
}

static void Require(bool Holds, const char *What)
{
    if (!Holds)
    {
        Fail(What);
    }
}

static void DrainEvents(void)
{
    CFE_SB_Buffer_t *Buffer;

    while (CFE_SB_ReceiveBuffer(&Buffer, EventPipe, CFE_SB_POLL) == CFE_SUCCESS)
    {
        const CFE_EVS_LongEventTlm_t *Event = (const CFE_EVS_LongEventTlm_t *)Buffer;

        fprintf(Events, "%lu %s %u %s\n", Tick, Event->Payload.PacketID.AppName,
                (unsigned)Event->Payload.PacketID.EventID, Event->Payload.Message);
        if ((strcmp(Event->Payload.PacketID.AppName, "@APP@") == 0)
            && (strstr(Event->Payload.Message, "@APP@ initialised") != NULL))
        {
            ++Started;
        }
    }
}

/* Time stamps follow the simulated time; the applications accept them for an hour. */
static CFE_TIME_SysTime_t TimeOf(double Seconds)
{
    static CFE_TIME_SysTime_t Start;
    CFE_TIME_SysTime_t        Time;

    if (Start.Seconds == 0)
    {
        Start = CFE_TIME_GetMET();
    }
    Time.Seconds    = Start.Seconds + (uint32)(int32)floor(Seconds);
    Time.Subseconds = (uint32)((Seconds - floor(Seconds)) * 4294967296.0);
    return Time;
}

static void FillSample(@APP@_SensorTlm_t *Message, double Seconds)
{
    @APP@_SensorTlm_Payload_t *Payload = &Message->Payload;

    Require(CFE_MSG_Init(CFE_MSG_PTR(Message->TelemetryHeader), CFE_SB_ValueToMsgId(@APP@_SENSOR_TLM_MID),
                         sizeof(*Message)) == CFE_SUCCESS, "no sensor message");
    Payload->SampleTime = TimeOf(Seconds + Clock);
@sensor@
    Payload->Crc = @APP@_SensorCrc(Payload);
}

static void Send(void *Message)
{
    Require(CFE_SB_TransmitMsg((const CFE_MSG_Message_t *)Message, false) == CFE_SUCCESS, "not sent");
}

static void SendCommand(CFE_SB_MsgId_Atom_t Id, CFE_MSG_FcnCode_t Code, const void *Payload, size_t Size)
{
    union
    {
        CFE_MSG_CommandHeader_t Header;
        CFE_MSG_Message_t       Msg;
        uint8                   Bytes[256];
    } Message;

    CFE_MSG_Init(&Message.Msg, CFE_SB_ValueToMsgId(Id), sizeof(Message.Header) + Size);
    CFE_MSG_SetFcnCode(&Message.Msg, Code);
    if (Size > 0)
    {
        memcpy(&Message.Bytes[sizeof(Message.Header)], Payload, Size);
    }
    CFE_MSG_GenerateChecksum(&Message.Msg);
    Send(&Message);
}

/* A sample that would disturb the flight if it were accepted: 10 mrad beside the true one. */
static void FillDisturbed(@APP@_SensorTlm_t *Message, double Seconds)
{
    double *Value = (double *)&Message->Payload.@disturbed@;

    FillSample(Message, Seconds);
    *Value += 0.01;
    Message->Payload.Crc = @APP@_SensorCrc(&Message->Payload);
}

static uint32 Random(void)
{
    Seed = (Seed * 1664525U) + 1013904223U;
    return Seed >> 8;
}

/* Messages of random length and content with the id of the sensor message. */
static void SendGarbage(unsigned Count)
{
    union
    {
        @APP@_SensorTlm_t Message;
        CFE_MSG_Message_t Msg;
        uint8             Bytes[2 * sizeof(@APP@_SensorTlm_t)];
    } Any;
    unsigned k, n;

    for (k = 0; k < Count; ++k)
    {
        size_t Size = 16 + Random() % (sizeof(Any.Bytes) - 16);

        if ((k % 2 == 0) || (Size == sizeof(Any.Message)))
        {
            Size = sizeof(Any.Message) - (k % 2); /* every second one has the length of a sample */
        }
        CFE_MSG_Init(&Any.Msg, CFE_SB_ValueToMsgId(@APP@_SENSOR_TLM_MID), Size);
        for (n = 16; n < Size; ++n)
        {
            Any.Bytes[n] = (uint8)Random();
        }
        Send(&Any);
    }
}

static CFE_TBL_Handle_t Shared;

static void ShareTable(void)
{
    if (!IsShared)
    {
        Require(CFE_TBL_Share(&Shared, "@APP@.Parameters") == CFE_SUCCESS, "table not shared");
        IsShared = true;
    }
}

static int32 TableStatus(void)
{
    ShareTable();
    return CFE_TBL_GetStatus(Shared);
}

static void WaitForTable(int32 Status, const char *What)
{
    int Wait;

    for (Wait = 0; (Wait < MOST_WAIT) && (TableStatus() != Status); ++Wait)
    {
        OS_TaskDelay(1);
    }
    Require(Wait < MOST_WAIT, What);
    DrainEvents();
}

/* Ground commands to the table services. */
static void LoadTable(const char *Name)
{
    CFE_TBL_LoadCmd_Payload_t     Load;
    CFE_TBL_ValidateCmd_Payload_t Validate;

    memset(&Load, 0, sizeof(Load));
    memset(&Validate, 0, sizeof(Validate));
    snprintf(Load.LoadFilename, sizeof(Load.LoadFilename), "/cf/%.20s.tbl", Name);
    Validate.ActiveTableFlag = CFE_TBL_BufferSelect_INACTIVE;
    strcpy(Validate.TableName, "@APP@.Parameters");
    SendCommand(CFE_TBL_CMD_MID, CFE_TBL_LOAD_CC, &Load, sizeof(Load));
    SendCommand(CFE_TBL_CMD_MID, CFE_TBL_VALIDATE_CC, &Validate, sizeof(Validate));
    WaitForTable(CFE_TBL_INFO_VALIDATION_PENDING, "no validation pending");
}

static void ActivateTable(void)
{
    CFE_TBL_ActivateCmd_Payload_t Activate;

    memset(&Activate, 0, sizeof(Activate));
    strcpy(Activate.TableName, "@APP@.Parameters");
    SendCommand(CFE_TBL_CMD_MID, CFE_TBL_ACTIVATE_CC, &Activate, sizeof(Activate));
}

static void AbortTable(void)
{
    CFE_TBL_AbortLoadCmd_Payload_t Abort;

    memset(&Abort, 0, sizeof(Abort));
    strcpy(Abort.TableName, "@APP@.Parameters");
    SendCommand(CFE_TBL_CMD_MID, CFE_TBL_ABORT_LOAD_CC, &Abort, sizeof(Abort));
}

/* Another application writes to the active table, past the validation. */
static void OverwriteTable(const char *Value)
{
    void *Address = NULL;

    ShareTable();
    Require(CFE_TBL_GetAddress(&Address, Shared) >= CFE_SUCCESS, "no address");
    *(double *)Address = atof(Value);
    CFE_TBL_ReleaseAddress(Shared);
    Require(CFE_TBL_Modified(Shared) == CFE_SUCCESS, "not modified");
}

static void Wake(size_t Extra)
{
    static const uint8 None[8];

    SendCommand(@APP@_WAKEUP_MID, 0, None, Extra);
}

/* A table that another application shares cannot be registered again. */
static void Restart(bool IsShare)
{
    CFE_ES_AppId_t      Id;
    const unsigned long Before = Started;
    int                 Wait;

    Require(CFE_ES_GetAppIDByName(&Id, "@APP@") == CFE_SUCCESS, "no application");
    if (IsShare)
    {
        ShareTable();
    }
    else if (IsShared)
    {
        CFE_TBL_Unregister(Shared);
        IsShared = false;
    }
    Require(CFE_ES_RestartApp(Id) == CFE_SUCCESS, "not restarted");
    Wake(8); /* of another length: the application wakes without a tick, and ends */
    for (Wait = 0; (Wait < MOST_WAIT) && (Started == Before); ++Wait)
    {
        OS_TaskDelay(1);
        DrainEvents();
    }
    Require(Wait < MOST_WAIT, "did not come back");
}

/* Faults of the sensor message; without one, the sample is sent. */
static void SampleFault(const char *Name, double Now)
{
    struct
    {
        @APP@_SensorTlm_t Message;
        uint8             Extra[8];
    } Long;
    @APP@_SensorTlm_t *Message = &Long.Message;
    CFE_SB_Buffer_t   *Buffer;

    memset(&Long, 0, sizeof(Long));
    FillDisturbed(Message, Now);
    IsSent = true;
    if (strcmp(Name, "lost") == 0)
    {
        return;
    }
    if (strcmp(Name, "short") == 0)
    {
        CFE_MSG_SetSize(CFE_MSG_PTR(Message->TelemetryHeader), sizeof(*Message) - 8);
    }
    else if (strcmp(Name, "long") == 0)
    {
        CFE_MSG_SetSize(CFE_MSG_PTR(Message->TelemetryHeader), sizeof(Long));
    }
    else if (strcmp(Name, "checksum") == 0)
    {
        FillSample(Message, Now);
        *(double *)&Message->Payload.@disturbed@ += 0.01;
    }
    else if (strcmp(Name, "nan") == 0)
    {
        *(double *)&Message->Payload.@disturbed@ = NAN;
        Message->Payload.Crc = @APP@_SensorCrc(&Message->Payload);
    }
    else if (strcmp(Name, "stale") == 0)
    {
        FillDisturbed(Message, Now - 7200.0);
    }
    else if (strcmp(Name, "ahead") == 0)
    {
        FillDisturbed(Message, Now + 7200.0);
    }
    else if (strcmp(Name, "order") == 0)
    {
        FillDisturbed(Message, Now - 1.5 * @period@);
    }
    else if (strcmp(Name, "repeated") == 0)
    {
        FillDisturbed(Message, (double)Tick * @period@); /* that of the last tick */
    }
    else if (strcmp(Name, "id") == 0)
    {
        Buffer = CFE_SB_AllocateMessageBuffer(sizeof(*Message));
        Require(Buffer != NULL, "no buffer");
        memcpy(Buffer, Message, sizeof(*Message));
        Require(CFE_SB_TransmitBuffer(Buffer, false) == CFE_SUCCESS, "not sent");
        CFE_MSG_SetMsgId(&Buffer->Msg, CFE_SB_ValueToMsgId(@APP@_COMMAND_TLM_MID));
        return;
    }
    else
    {
        IsSent = false;
        return;
    }
    Send(Message);
}

static void BadCommand(const char *Name)
{
    @APP@_NoArgsCmd_t Command;
    CFE_MSG_Message_t *Msg = CFE_MSG_PTR(Command.CommandHeader);
    static const uint8 None[8];

    if (strcmp(Name, "command_length") == 0)
    {
        SendCommand(@APP@_CMD_MID, @APP@_RESET_CONTROLLER_CC, None, 8);
    }
    else if (strcmp(Name, "command_code") == 0)
    {
        SendCommand(@APP@_CMD_MID, 77, None, 0);
    }
    else
    {
        CFE_MSG_Init(Msg, CFE_SB_ValueToMsgId(@APP@_CMD_MID), sizeof(Command));
        CFE_MSG_SetFcnCode(Msg, @APP@_RESET_CONTROLLER_CC);
        CFE_MSG_GenerateChecksum(Msg);
        CFE_MSG_SetFcnCode(Msg, @APP@_NOOP_CC); /* the checksum is that of another code */
        Send(&Command);
    }
}

static const char *InTick(void)
{
    unsigned k;

    for (k = 0; k < ActionCount; ++k)
    {
        if ((Actions[k].Tick == Tick) && (strncmp(Actions[k].Name, "in_tick_", 8) == 0))
        {
            return Actions[k].Name + 8;
        }
    }
    return NULL;
}

static const char *Argument(const char *Name)
{
    unsigned k;

    for (k = 0; k < ActionCount; ++k)
    {
        if ((Actions[k].Tick == Tick) && (strcmp(Actions[k].Name, Name) == 0))
        {
            return Actions[k].Argument;
        }
    }
    return NULL;
}

static void Before(const Action_t *Action, double Now)
{
    const char *Name = Action->Name;

    if (strcmp(Name, "garbage") == 0)
    {
        SendGarbage((unsigned)atoi(Action->Argument));
    }
    else if (strcmp(Name, "clock") == 0)
    {
        Clock = atof(Action->Argument);
    }
    else if (strcmp(Name, "load") == 0)
    {
        LoadTable(Action->Argument);
    }
    else if (strcmp(Name, "activate") == 0)
    {
        ActivateTable();
        WaitForTable(CFE_TBL_INFO_UPDATE_PENDING, "no update pending");
    }
    else if (strcmp(Name, "refused") == 0) /* the table services must not activate it */
    {
        ActivateTable();
        AbortTable();
    }
    else if (strcmp(Name, "overwrite") == 0)
    {
        OverwriteTable(Action->Argument);
    }
    else if (strcmp(Name, "noop") == 0)
    {
        SendCommand(@APP@_CMD_MID, @APP@_NOOP_CC, NULL, 0);
    }
    else if (strcmp(Name, "reset_counters") == 0)
    {
        SendCommand(@APP@_CMD_MID, @APP@_RESET_COUNTERS_CC, NULL, 0);
    }
    else if (strcmp(Name, "reset_controller") == 0)
    {
        SendCommand(@APP@_CMD_MID, @APP@_RESET_CONTROLLER_CC, NULL, 0);
    }
    else if (strncmp(Name, "command_", 8) == 0)
    {
        BadCommand(Name);
    }
    else if (strcmp(Name, "wakeup_length") == 0)
    {
        Wake(8);
    }
    else if (strncmp(Name, "restart", 7) == 0)
    {
        Restart(strcmp(Name, "restart_shared") == 0);
    }
    else if (strncmp(Name, "in_tick_", 8) != 0)
    {
        SampleFault(Name, Now);
        Require(IsSent, "unknown action");
    }
}

/* What happens while the application computes its step: the hook around its step has stopped it. */
static void During(void)
{
    const char *Name = InTick();

    if (Name == NULL)
    {
        return;
    }
    Require(OS_BinSemTimedWait(Reached, MOST_WAIT) == OS_SUCCESS, "no step");
    if (strcmp(Name, "load") == 0)
    {
        LoadTable(Argument("in_tick_load"));
    }
    else if (strcmp(Name, "activate") == 0)
    {
        ActivateTable();
        WaitForTable(CFE_TBL_INFO_UPDATE_PENDING, "no update pending");
    }
    else
    {
        OverwriteTable(Argument("in_tick_overwrite"));
    }
    Require(OS_BinSemGive(Resume) == OS_SUCCESS, "no semaphore");
}

static void Write(FILE *Rows, const double *Numbers, size_t Count)
{
    Require(fwrite(Numbers, sizeof(double), Count, Rows) == Count, "row not written");
}

static void WriteHousekeeping(FILE *Rows, int32 Wait)
{
    CFE_SB_Buffer_t *Buffer;
    uint32           Counts[sizeof(@APP@_HkTlm_Payload_t) / sizeof(uint32)];
    size_t           k;

    Require(CFE_SB_ReceiveBuffer(&Buffer, HousekeepingPipe, Wait) == CFE_SUCCESS, "no housekeeping");
    memcpy(Counts, &((const @APP@_HkTlm_t *)Buffer)->Payload, sizeof(Counts));
    for (k = 0; k < sizeof(Counts) / sizeof(Counts[0]); ++k)
    {
        const double Count = Counts[k];

        Write(Rows, &Count, 1);
    }
}

static void Step(FILE *Noise, FILE *Rows)
{
    const double                      Now = (double)(Tick + 1) * @period@;
    @APP@_SensorTlm_t                 Message;
    const @APP@_CommandTlm_Payload_t *Payload;
    CFE_SB_Buffer_t                  *Buffer;
    unsigned                          k;

    IsSent = false;
    for (k = 0; k < ActionCount; ++k)
    {
        if (Actions[k].Tick == Tick)
        {
            Before(&Actions[k], Now);
        }
    }
    if (!IsSent)
    {
        FillSample(&Message, Now);
        Send(&Message);
    }
    if (InTick() != NULL)
    {
        Require(OS_BinSemGive(Arm) == OS_SUCCESS, "no semaphore");
    }
    SendCommand(@APP@_SEND_HK_MID, 0, NULL, 0);
    Wake(0);
    During();
    Require(CFE_SB_ReceiveBuffer(&Buffer, CommandPipe, MOST_WAIT) == CFE_SUCCESS, "no command");
    Payload = &((const @APP@_CommandTlm_t *)Buffer)->Payload;
    Require(Payload->Crc == @APP@_CommandCrc(Payload), "wrong checksum of the command");
@command@
    {
        const double Numbers[] = {(double)Payload->Tick, (double)Payload->SampleStatus,
                                  (double)Payload->SamplesMissed, (double)Payload->TicksWithoutSample, @recorded@};

        Write(Rows, Numbers, sizeof(Numbers) / sizeof(Numbers[0]));
    }
    WriteHousekeeping(Rows, CFE_SB_POLL);
    DrainEvents();
    Plant.time = (double)Tick * @period@;
    Require((@move@) == 0, "plant failed");
    Require(Plant.resolved, "plant not resolved");
    Require(fread(Plant.noise, sizeof(double), @noise_count@, Noise) == @noise_count@, "no noise");
    Require((@sense@) == 0, "sensor failed");
}

static void ReadScript(void)
{
    FILE *Script = fopen("@app@.script", "r");

    Require(Script != NULL, "no script");
    Require(fscanf(Script, "%lu", &Ticks) == 1, "no ticks");
    while ((ActionCount < MOST_ACTIONS)
           && (fscanf(Script, "%lu %31s %31s", &Actions[ActionCount].Tick, Actions[ActionCount].Name,
                      Actions[ActionCount].Argument) == 3))
    {
        ++ActionCount;
    }
    fclose(Script);
}

/* Without wake-ups, the application still answers. */
static void Silence(FILE *Rows)
{
    OS_TaskDelay(1500);
    SendCommand(@APP@_SEND_HK_MID, 0, NULL, 0);
    WriteHousekeeping(Rows, MOST_WAIT);
    DrainEvents();
}

static void OpenPipes(void)
{
    Require(CFE_SB_CreatePipe(&CommandPipe, 8, "@APP@_F1") == CFE_SUCCESS, "no pipe");
    Require(CFE_SB_CreatePipe(&HousekeepingPipe, 8, "@APP@_F2") == CFE_SUCCESS, "no pipe");
    Require(CFE_SB_CreatePipe(&EventPipe, 10, "@APP@_F3") == CFE_SUCCESS, "no pipe");
    CFE_SB_Subscribe(CFE_SB_ValueToMsgId(@APP@_COMMAND_TLM_MID), CommandPipe);
    CFE_SB_Subscribe(CFE_SB_ValueToMsgId(@APP@_HK_TLM_MID), HousekeepingPipe);
    CFE_SB_SubscribeEx(CFE_SB_ValueToMsgId(CFE_EVS_LONG_EVENT_MSG_MID), EventPipe, CFE_SB_DEFAULT_QOS, 10);
    Require(OS_BinSemCreate(&Arm, "@APP@_ARM", 0, 0) == OS_SUCCESS, "no semaphore");
    Require(OS_BinSemCreate(&Reached, "@APP@_REA", 0, 0) == OS_SUCCESS, "no semaphore");
    Require(OS_BinSemCreate(&Resume, "@APP@_RES", 0, 0) == OS_SUCCESS, "no semaphore");
}

void FLYER_Main(void)
{
    FILE *Noise = fopen("@app@.noise", "rb");
    FILE *Rows  = fopen("@app@.rows", "wb");
    FILE *Done;

    Events = fopen("@app@.events", "w");
    Require((Noise != NULL) && (Rows != NULL) && (Events != NULL), "files not opened");
    ReadScript();
    OpenPipes();
    CFE_EVS_Register(NULL, 0, CFE_EVS_EventFilter_BINARY);
    Require(CFE_ES_WaitForSystemState(CFE_ES_SystemState_OPERATIONAL, MOST_WAIT) == CFE_SUCCESS, "not operational");
    memset(&Plant, 0, sizeof(Plant));
    Require((@begin@) == 0, "plant not started");
    Require(fread(Plant.noise, sizeof(double), @noise_count@, Noise) == @noise_count@, "no noise");
    Require((@sense@) == 0, "sensor failed");
    for (Tick = 0; Tick < Ticks; ++Tick)
    {
        Step(Noise, Rows);
    }
    Silence(Rows);
    fclose(Rows);
    fclose(Events);
    Done = fopen("@app@.done", "w");
    if (Done != NULL)
    {
        fclose(Done);
    }
    CFE_ES_ExitApp(CFE_ES_RunStatus_APP_EXIT);
}
