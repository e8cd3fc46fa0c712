/* Parameters of @app@: validation, and the last valid ones. */
#include "@app@_app.h"

#include <math.h>
#include <string.h>

/* Name of the first parameter that is wrong; NULL if all are right. NaN is within no range. */
static const char *Within(const char *Fault, const char *Name, const @real@ *Values, size_t Count, @real@ Lower,
                          @real@ Upper)
{
    const char *Result = Fault;
    size_t      k;

    for (k = 0U; k < Count; ++k)
    {
        if ((Result == NULL) && !((Values[k] >= Lower) && (Values[k] <= Upper)))
        {
            Result = Name;
        }
    }
    return Result;
}
@helpers@
/* Ranges of the parameters; edit them here. */
static const char *FaultOf(const @APP@_Parameters_t *Table)
{
    const char *Fault = NULL;

@ranges@
    return Fault;
}

static void Adopt(const @APP@_Parameters_t *Table)
{
    @APP@_Values_t *Values = &@APP@_Data.Values;

@adopted@
}

CFE_Status_t @APP@_ValidateTable(void *Table)
{
    const char  *Fault  = FaultOf((const @APP@_Parameters_t *)Table);
    CFE_Status_t Status = CFE_SUCCESS;

    if (Fault != NULL)
    {
        Status = @APP@_INVALID;
        ++@APP@_Data.Housekeeping.Payload.TableErrors;
        (void)CFE_EVS_SendEvent(@APP@_TABLE_EID, CFE_EVS_EventType_ERROR,
                                "table: found %.80s out of its range", Fault);
    }
    return Status;
}

/* Use a new table from the next step on, if it is valid. The copy is checked, because another
   application that shares the table can write to it without a validation. */
static void Take(void)
{
    void        *Address = NULL;
    CFE_Status_t Status  = CFE_TBL_GetAddress(&Address, @APP@_Data.TableHandle);

    if ((Status == CFE_TBL_INFO_UPDATED) && (Address != NULL))
    {
        (void)memcpy(&@APP@_Data.Candidate, Address, sizeof(@APP@_Data.Candidate));
        if (@APP@_ValidateTable(&@APP@_Data.Candidate) == CFE_SUCCESS)
        {
            Adopt(&@APP@_Data.Candidate);
            ++@APP@_Data.Housekeeping.Payload.TableLoads;
        }
    }
    if (Address != NULL)
    {
        (void)CFE_TBL_ReleaseAddress(@APP@_Data.TableHandle);
    }
}

void @APP@_InitTable(void)
{
    const @APP@_Values_t *Values = &@APP@_Data.Values;
    @APP@_Parameters_t   *Table  = &@APP@_Data.Candidate;
    CFE_Status_t          Status;

    Status = CFE_TBL_Register(&@APP@_Data.TableHandle, @APP@_TABLE_NAME, sizeof(@APP@_Parameters_t),
                              CFE_TBL_OPT_DEFAULT, &@APP@_ValidateTable);
    @APP@_Data.HasTable = (Status >= CFE_SUCCESS);
    if (@APP@_Data.HasTable)
    {
        Status = CFE_TBL_Load(@APP@_Data.TableHandle, CFE_TBL_SRC_FILE, @APP@_TABLE_FILE);
    }
    if (Status < CFE_SUCCESS)
    {
        ++@APP@_Data.Housekeeping.Payload.TableServiceErrors;
        (void)CFE_EVS_SendEvent(@APP@_TABLE_START_EID, CFE_EVS_EventType_ERROR,
                                "table: found status 0x%08x at the start, used the designed parameters",
                                (unsigned int)Status);
        if (@APP@_Data.HasTable)
        {
@designed@
            Status = CFE_TBL_Load(@APP@_Data.TableHandle, CFE_TBL_SRC_ADDRESS, Table);
        }
    }
    if (Status >= CFE_SUCCESS)
    {
        Take();
    }
}

void @APP@_ManageTable(void)
{
    if (@APP@_Data.HasTable)
    {
        if (CFE_TBL_Manage(@APP@_Data.TableHandle) < CFE_SUCCESS)
        {
            ++@APP@_Data.Housekeeping.Payload.TableServiceErrors;
        }
        Take();
    }
}

void @APP@_CheckTableInTick(void)
{
    @APP@_HkTlm_Payload_t *Counters = &@APP@_Data.Housekeeping.Payload;
    CFE_Status_t           Status   = CFE_SUCCESS;

    if (@APP@_Data.HasTable)
    {
        Status = CFE_TBL_GetStatus(@APP@_Data.TableHandle);
    }
    if ((Status == CFE_TBL_INFO_VALIDATION_PENDING) || (Status == CFE_TBL_INFO_UPDATE_PENDING))
    {
        ++Counters->TableLoadsInTick;
        if (((Counters->TableLoadsInTick - 1U) & @APP@_EVENT_MASK) == 0U)
        {
            (void)CFE_EVS_SendEvent(@APP@_TABLE_IN_TICK_EID, CFE_EVS_EventType_INFORMATION,
                                    "table: found a load during tick %lu, used from the next one",
                                    (unsigned long)@APP@_Data.Tick);
        }
    }
}
