/* Stops the step of @app@ where the test application wants to act during a tick. */
#include "@app@.h"
#include "cfe.h"

int __real_@app@_step(@parameters@);
int __wrap_@app@_step(@parameters@);

int __wrap_@app@_step(@parameters@)
{
    osal_id_t Arm, Reached, Resume;

    if ((OS_BinSemGetIdByName(&Arm, "@APP@_ARM") == OS_SUCCESS) && (OS_BinSemTimedWait(Arm, 0) == OS_SUCCESS))
    {
        OS_BinSemGetIdByName(&Reached, "@APP@_REA");
        OS_BinSemGetIdByName(&Resume, "@APP@_RES");
        OS_BinSemGive(Reached);
        OS_BinSemTimedWait(Resume, 60000);
    }
    return __real_@app@_step(@arguments@);
}
