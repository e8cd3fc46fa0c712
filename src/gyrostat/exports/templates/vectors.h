/* @title@: test vectors, steps of the functions with their inputs. vector_prepare sets the inputs of a
   row, in ascending order of rows; vector_step calls the functions. */
#ifndef GYROSTAT_@guard@_VECTORS_H
#define GYROSTAT_@guard@_VECTORS_H

#include "@name@.h"

#include <math.h>

enum { VECTOR_ROWS = @rows@, VECTOR_INPUTS = @count@ };

/* arguments of the functions */
static struct {
@declared@
} vector;

/* rows in which parameters and state are set anew, by the functions that are called once */
static const unsigned char vector_begins[VECTOR_ROWS] = {
@begins@
};

@given@

/* further changes: before row, field = value */
static const struct {
    int row;
    int field;
    @real@ value;
} vector_change[@changes@] = {
@change@
};

@whole@static void vector_set(int field, @real@ value)
{
    switch (field) {
@cases@
    default: (void)value; break;
    }
}

static int vector_prepare(int row)
{
    static int next = 0;
    int status = 0;
    if (row == 0) { next = 0; }
    if (vector_begins[row] != 0) {
        status |= @parameters@;
@constants@
    }
    while ((next < @changes@) && (vector_change[next].row == row)) {
        vector_set(vector_change[next].field, vector_change[next].value);
        ++next;
    }
    if (vector_begins[row] != 0) {
@begin@
    }
@inputs@
    return status;
}

static int vector_step(void)
{
    int status = 0;
@calls@
    return status;
}

#endif
