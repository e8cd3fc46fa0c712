/* FMI 2.0 for co-simulation around @name@.c. Unlike @name@.c, this file allocates memory, for
   instances and their saved states, with the functions provided by the simulator. All of its names
   begin with fmi2, so that none is that of a struct. */
#include "@name@.h"

#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#else
#define EXPORTED __attribute__((visibility("default")))
#endif

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef void (*fmi2CallbackLogger)(void *, const char *, fmi2Status, const char *, const char *, ...);
typedef struct {
    fmi2CallbackLogger log;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, fmi2Status);
    void *environment;
} fmi2CallbackFunctions;

typedef struct {
    double time;
@members@
} fmi2Values;

typedef struct {
    const fmi2CallbackFunctions *callbacks;
    fmi2Values values;
} fmi2Instance;

static double *fmi2RealAt(fmi2Values *v, unsigned int reference)
{
    switch (reference) {
@reals@
    default: return NULL;
    }
}

static bool *fmi2LogicalAt(fmi2Values *v, unsigned int reference)
{
    switch (reference) {
@logicals@
    default: (void)v; return NULL;
    }
}

static int64_t *fmi2IntegerAt(fmi2Values *v, unsigned int reference)
{
    switch (reference) {
@integers@
    default: (void)v; return NULL;
    }
}

static void fmi2FirstValues(fmi2Values *v)
{
    memset(v, 0, sizeof *v);
@first@
}

static fmi2Status fmi2Begin(fmi2Values *v)
{
    int status = 0;
@begin@
    return (status == 0) ? fmi2OK : fmi2Error;
}

static fmi2Status fmi2Step(fmi2Values *v, double duration)
{
    int status = 0;
@step@
    v->time += duration;
    return (status == 0) ? fmi2OK : fmi2Error;
}

static fmi2Instance *fmi2Own(void *c) { return (fmi2Instance *)c; }

EXPORTED const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORTED const char *fmi2GetVersion(void) { return "2.0"; }
EXPORTED fmi2Status fmi2SetDebugLogging(void *c, int on, size_t n, const char *const category[])
{
    (void)c; (void)on; (void)n; (void)category;
    return fmi2OK;
}

EXPORTED void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources,
    const fmi2CallbackFunctions *callbacks, int visible, int logging)
{
    fmi2Instance *made = NULL;
    (void)name; (void)resources; (void)visible; (void)logging;
    if ((kind == 1) && (guid != NULL) && (strcmp(guid, "@guid@") == 0)) {
        made = (fmi2Instance *)callbacks->allocate(1, sizeof *made);
    }
    if (made != NULL) {
        made->callbacks = callbacks;
        fmi2FirstValues(&made->values);
    }
    return made;
}

EXPORTED void fmi2FreeInstance(void *c)
{
    if (c != NULL) { fmi2Own(c)->callbacks->release(c); }
}

EXPORTED fmi2Status fmi2SetupExperiment(void *c, int tolerant, double tolerance, double start,
    int ends, double stop)
{
    (void)tolerant; (void)tolerance; (void)ends; (void)stop;
    fmi2Own(c)->values.time = start;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2EnterInitializationMode(void *c) { (void)c; return fmi2OK; }
EXPORTED fmi2Status fmi2ExitInitializationMode(void *c) { return fmi2Begin(&fmi2Own(c)->values); }
EXPORTED fmi2Status fmi2Terminate(void *c) { (void)c; return fmi2OK; }
EXPORTED fmi2Status fmi2Reset(void *c) { fmi2FirstValues(&fmi2Own(c)->values); return fmi2OK; }

EXPORTED fmi2Status fmi2GetReal(void *c, const unsigned int reference[], size_t n, double value[])
{
    for (size_t k = 0; k < n; ++k) {
        const double *place = fmi2RealAt(&fmi2Own(c)->values, reference[k]);
        if (place == NULL) { return fmi2Error; }
        value[k] = *place;
    }
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetReal(void *c, const unsigned int reference[], size_t n, const double value[])
{
    for (size_t k = 0; k < n; ++k) {
        double *place = fmi2RealAt(&fmi2Own(c)->values, reference[k]);
        if (place == NULL) { return fmi2Error; }
        *place = value[k];
    }
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetInteger(void *c, const unsigned int reference[], size_t n, int value[])
{
    for (size_t k = 0; k < n; ++k) {
        const int64_t *place = fmi2IntegerAt(&fmi2Own(c)->values, reference[k]);
        if (place == NULL) { return fmi2Error; }
        value[k] = (*place > INT_MAX) ? INT_MAX : ((*place < INT_MIN) ? INT_MIN : (int)*place);
    }
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetInteger(void *c, const unsigned int reference[], size_t n, const int value[])
{
    for (size_t k = 0; k < n; ++k) {
        int64_t *place = fmi2IntegerAt(&fmi2Own(c)->values, reference[k]);
        if (place == NULL) { return fmi2Error; }
        *place = value[k];
    }
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetBoolean(void *c, const unsigned int reference[], size_t n, int value[])
{
    for (size_t k = 0; k < n; ++k) {
        const bool *place = fmi2LogicalAt(&fmi2Own(c)->values, reference[k]);
        if (place == NULL) { return fmi2Error; }
        value[k] = *place ? 1 : 0;
    }
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetBoolean(void *c, const unsigned int reference[], size_t n, const int value[])
{
    for (size_t k = 0; k < n; ++k) {
        bool *place = fmi2LogicalAt(&fmi2Own(c)->values, reference[k]);
        if (place == NULL) { return fmi2Error; }
        *place = (value[k] != 0);
    }
    return fmi2OK;
}

EXPORTED fmi2Status fmi2DoStep(void *c, double now, double duration, int no_way_back)
{
    (void)now; (void)no_way_back;
    return fmi2Step(&fmi2Own(c)->values, duration);
}

EXPORTED fmi2Status fmi2GetFMUstate(void *c, void **state)
{
    if (*state == NULL) { *state = fmi2Own(c)->callbacks->allocate(1, sizeof(fmi2Values)); }
    if (*state == NULL) { return fmi2Error; }
    memcpy(*state, &fmi2Own(c)->values, sizeof(fmi2Values));
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetFMUstate(void *c, void *state)
{
    memcpy(&fmi2Own(c)->values, state, sizeof(fmi2Values));
    return fmi2OK;
}

EXPORTED fmi2Status fmi2FreeFMUstate(void *c, void **state)
{
    if (*state != NULL) { fmi2Own(c)->callbacks->release(*state); }
    *state = NULL;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SerializedFMUstateSize(void *c, void *state, size_t *size)
{
    (void)c; (void)state;
    *size = sizeof(fmi2Values);
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SerializeFMUstate(void *c, void *state, char bytes[], size_t size)
{
    (void)c;
    if (size < sizeof(fmi2Values)) { return fmi2Error; }
    memcpy(bytes, state, sizeof(fmi2Values));
    return fmi2OK;
}

EXPORTED fmi2Status fmi2DeSerializeFMUstate(void *c, const char bytes[], size_t size, void **state)
{
    if (size != sizeof(fmi2Values)) { return fmi2Error; }
    if (*state == NULL) { *state = fmi2Own(c)->callbacks->allocate(1, sizeof(fmi2Values)); }
    if (*state == NULL) { return fmi2Error; }
    memcpy(*state, bytes, sizeof(fmi2Values));
    return fmi2OK;
}

/* Functions that the standard requires and this unit does not need. */

#define REFERENCES void *c, const unsigned int r[], size_t n
EXPORTED fmi2Status fmi2GetString(REFERENCES, const char *v[])
{ (void)c; (void)r; (void)v; return n ? fmi2Error : fmi2OK; }
EXPORTED fmi2Status fmi2SetString(REFERENCES, const char *const v[])
{ (void)c; (void)r; (void)v; return n ? fmi2Error : fmi2OK; }
EXPORTED fmi2Status fmi2GetDirectionalDerivative(void *c, const unsigned int of[], size_t n,
    const unsigned int by[], size_t m, const double seed[], double found[])
{ (void)c; (void)of; (void)n; (void)by; (void)m; (void)seed; (void)found; return fmi2Error; }
EXPORTED fmi2Status fmi2SetRealInputDerivatives(REFERENCES, const int order[], const double v[])
{ (void)c; (void)r; (void)n; (void)order; (void)v; return fmi2Error; }
EXPORTED fmi2Status fmi2GetRealOutputDerivatives(REFERENCES, const int order[], double v[])
{ (void)c; (void)r; (void)n; (void)order; (void)v; return fmi2Error; }
EXPORTED fmi2Status fmi2CancelStep(void *c) { (void)c; return fmi2Error; }
EXPORTED fmi2Status fmi2GetStatus(void *c, int kind, fmi2Status *v)
{ (void)c; (void)kind; (void)v; return fmi2Discard; }
EXPORTED fmi2Status fmi2GetRealStatus(void *c, int kind, double *v)
{
    if (kind != 2) { return fmi2Discard; }
    *v = fmi2Own(c)->values.time; /* end of the last completed step */
    return fmi2OK;
}
EXPORTED fmi2Status fmi2GetIntegerStatus(void *c, int kind, int *v)
{ (void)c; (void)kind; (void)v; return fmi2Discard; }
EXPORTED fmi2Status fmi2GetBooleanStatus(void *c, int kind, int *v)
{ (void)c; (void)kind; (void)v; return fmi2Discard; }
EXPORTED fmi2Status fmi2GetStringStatus(void *c, int kind, const char **v)
{ (void)c; (void)kind; (void)v; return fmi2Discard; }
