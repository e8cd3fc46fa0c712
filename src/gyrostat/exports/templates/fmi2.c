/* FMI 2.0 for co-simulation around @name@.c. Unlike @name@.c, this file allocates memory, for
   instances and their saved states, with the functions provided by the simulator. */
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

typedef enum { FINE, WARNING, DISCARD, FAULT, FATAL, PENDING } Status;
typedef void (*Log)(void *, const char *, Status, const char *, const char *, ...);
typedef struct {
    Log log;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, Status);
    void *environment;
} Callbacks;

typedef struct {
    double time;
@members@
} Values;

typedef struct {
    const Callbacks *callbacks;
    Values values;
} Instance;

static double *real_at(Values *v, unsigned int reference)
{
    switch (reference) {
@reals@
    default: return NULL;
    }
}

static bool *logical_at(Values *v, unsigned int reference)
{
    switch (reference) {
@logicals@
    default: (void)v; return NULL;
    }
}

static int64_t *integer_at(Values *v, unsigned int reference)
{
    switch (reference) {
@integers@
    default: (void)v; return NULL;
    }
}

static void first_values(Values *v)
{
    memset(v, 0, sizeof *v);
@first@
}

static Status begin(Values *v)
{
    int status = 0;
@begin@
    return (status == 0) ? FINE : FAULT;
}

static Status step(Values *v, double duration)
{
    int status = 0;
@step@
    v->time += duration;
    return (status == 0) ? FINE : FAULT;
}

static Instance *own(void *c) { return (Instance *)c; }

EXPORTED const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORTED const char *fmi2GetVersion(void) { return "2.0"; }
EXPORTED Status fmi2SetDebugLogging(void *c, int on, size_t n, const char *const category[])
{
    (void)c; (void)on; (void)n; (void)category;
    return FINE;
}

EXPORTED void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources,
    const Callbacks *callbacks, int visible, int logging)
{
    Instance *made = NULL;
    (void)name; (void)resources; (void)visible; (void)logging;
    if ((kind == 1) && (guid != NULL) && (strcmp(guid, "@guid@") == 0)) {
        made = (Instance *)callbacks->allocate(1, sizeof *made);
    }
    if (made != NULL) {
        made->callbacks = callbacks;
        first_values(&made->values);
    }
    return made;
}

EXPORTED void fmi2FreeInstance(void *c)
{
    if (c != NULL) { own(c)->callbacks->release(c); }
}

EXPORTED Status fmi2SetupExperiment(void *c, int tolerant, double tolerance, double start, int ends,
    double stop)
{
    (void)tolerant; (void)tolerance; (void)ends; (void)stop;
    own(c)->values.time = start;
    return FINE;
}

EXPORTED Status fmi2EnterInitializationMode(void *c) { (void)c; return FINE; }
EXPORTED Status fmi2ExitInitializationMode(void *c) { return begin(&own(c)->values); }
EXPORTED Status fmi2Terminate(void *c) { (void)c; return FINE; }
EXPORTED Status fmi2Reset(void *c) { first_values(&own(c)->values); return FINE; }

EXPORTED Status fmi2GetReal(void *c, const unsigned int reference[], size_t n, double value[])
{
    for (size_t k = 0; k < n; ++k) {
        const double *place = real_at(&own(c)->values, reference[k]);
        if (place == NULL) { return FAULT; }
        value[k] = *place;
    }
    return FINE;
}

EXPORTED Status fmi2SetReal(void *c, const unsigned int reference[], size_t n, const double value[])
{
    for (size_t k = 0; k < n; ++k) {
        double *place = real_at(&own(c)->values, reference[k]);
        if (place == NULL) { return FAULT; }
        *place = value[k];
    }
    return FINE;
}

EXPORTED Status fmi2GetInteger(void *c, const unsigned int reference[], size_t n, int value[])
{
    for (size_t k = 0; k < n; ++k) {
        const int64_t *place = integer_at(&own(c)->values, reference[k]);
        if (place == NULL) { return FAULT; }
        value[k] = (*place > INT_MAX) ? INT_MAX : ((*place < INT_MIN) ? INT_MIN : (int)*place);
    }
    return FINE;
}

EXPORTED Status fmi2SetInteger(void *c, const unsigned int reference[], size_t n, const int value[])
{
    for (size_t k = 0; k < n; ++k) {
        int64_t *place = integer_at(&own(c)->values, reference[k]);
        if (place == NULL) { return FAULT; }
        *place = value[k];
    }
    return FINE;
}

EXPORTED Status fmi2GetBoolean(void *c, const unsigned int reference[], size_t n, int value[])
{
    for (size_t k = 0; k < n; ++k) {
        const bool *place = logical_at(&own(c)->values, reference[k]);
        if (place == NULL) { return FAULT; }
        value[k] = *place ? 1 : 0;
    }
    return FINE;
}

EXPORTED Status fmi2SetBoolean(void *c, const unsigned int reference[], size_t n, const int value[])
{
    for (size_t k = 0; k < n; ++k) {
        bool *place = logical_at(&own(c)->values, reference[k]);
        if (place == NULL) { return FAULT; }
        *place = (value[k] != 0);
    }
    return FINE;
}

EXPORTED Status fmi2DoStep(void *c, double now, double duration, int no_way_back)
{
    (void)now; (void)no_way_back;
    return step(&own(c)->values, duration);
}

EXPORTED Status fmi2GetFMUstate(void *c, void **state)
{
    if (*state == NULL) { *state = own(c)->callbacks->allocate(1, sizeof(Values)); }
    if (*state == NULL) { return FAULT; }
    memcpy(*state, &own(c)->values, sizeof(Values));
    return FINE;
}

EXPORTED Status fmi2SetFMUstate(void *c, void *state)
{
    memcpy(&own(c)->values, state, sizeof(Values));
    return FINE;
}

EXPORTED Status fmi2FreeFMUstate(void *c, void **state)
{
    if (*state != NULL) { own(c)->callbacks->release(*state); }
    *state = NULL;
    return FINE;
}

EXPORTED Status fmi2SerializedFMUstateSize(void *c, void *state, size_t *size)
{
    (void)c; (void)state;
    *size = sizeof(Values);
    return FINE;
}

EXPORTED Status fmi2SerializeFMUstate(void *c, void *state, char bytes[], size_t size)
{
    (void)c;
    if (size < sizeof(Values)) { return FAULT; }
    memcpy(bytes, state, sizeof(Values));
    return FINE;
}

EXPORTED Status fmi2DeSerializeFMUstate(void *c, const char bytes[], size_t size, void **state)
{
    if (size != sizeof(Values)) { return FAULT; }
    if (*state == NULL) { *state = own(c)->callbacks->allocate(1, sizeof(Values)); }
    if (*state == NULL) { return FAULT; }
    memcpy(*state, bytes, sizeof(Values));
    return FINE;
}

/* Functions that the standard requires and this unit does not need. */

#define REFERENCES void *c, const unsigned int r[], size_t n
EXPORTED Status fmi2GetString(REFERENCES, const char *v[])
{ (void)c; (void)r; (void)v; return n ? FAULT : FINE; }
EXPORTED Status fmi2SetString(REFERENCES, const char *const v[])
{ (void)c; (void)r; (void)v; return n ? FAULT : FINE; }
EXPORTED Status fmi2GetDirectionalDerivative(void *c, const unsigned int of[], size_t n,
    const unsigned int by[], size_t m, const double seed[], double found[])
{ (void)c; (void)of; (void)n; (void)by; (void)m; (void)seed; (void)found; return FAULT; }
EXPORTED Status fmi2SetRealInputDerivatives(REFERENCES, const int order[], const double v[])
{ (void)c; (void)r; (void)n; (void)order; (void)v; return FAULT; }
EXPORTED Status fmi2GetRealOutputDerivatives(REFERENCES, const int order[], double v[])
{ (void)c; (void)r; (void)n; (void)order; (void)v; return FAULT; }
EXPORTED Status fmi2CancelStep(void *c) { (void)c; return FAULT; }
EXPORTED Status fmi2GetStatus(void *c, int kind, Status *v)
{ (void)c; (void)kind; (void)v; return DISCARD; }
EXPORTED Status fmi2GetRealStatus(void *c, int kind, double *v)
{
    if (kind != 2) { return DISCARD; }
    *v = own(c)->values.time; /* end of the last completed step */
    return FINE;
}
EXPORTED Status fmi2GetIntegerStatus(void *c, int kind, int *v)
{ (void)c; (void)kind; (void)v; return DISCARD; }
EXPORTED Status fmi2GetBooleanStatus(void *c, int kind, int *v)
{ (void)c; (void)kind; (void)v; return DISCARD; }
EXPORTED Status fmi2GetStringStatus(void *c, int kind, const char **v)
{ (void)c; (void)kind; (void)v; return DISCARD; }
