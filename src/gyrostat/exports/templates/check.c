/* @title@: @rows@ steps compared with the results of Python. */
#include "@name@_vectors.h"

#include <float.h>
#include <stdio.h>

enum { OUTPUTS = @count@ };

@expected@
@scale@
static const char *const name[OUTPUTS] = {
@names@
};

/* first element of the array that an output is in */
static const int first[OUTPUTS] = {
@first@
};

/* Errors of a step, relative to the output, to its largest value in the test run and, since it may be
   nothing but their rounding error, to a share of the other elements of its array. */
static void add_errors(int row, const double *seen, double *worst)
{
    double whole[OUTPUTS] = {0.0};
    for (int n = 0; n < OUTPUTS; ++n) {
        const double size = fabs(expected[row][n]);
        if ((size > whole[first[n]]) && (size <= DBL_MAX)) { whole[first[n]] = size; }
    }
    for (int n = 0; n < OUTPUTS; ++n) {
        const double wanted = expected[row][n];
        const double least = fmax(scale[0][n], @share@ * whole[first[n]]);
        const double difference = fabs(seen[n] - wanted) / fmax(fabs(wanted), least);
        const int alike = (seen[n] == wanted) || ((seen[n] != seen[n]) && (wanted != wanted));
        const double error = alike ? 0.0 : difference;
        if (!(error <= worst[n])) { worst[n] = error; } /* NaN counts as the worst */
    }
}

int main(int arguments, char **argument)
{
    double worst[OUTPUTS] = {0.0};
    int status = 0;
    (void)argument;
    for (int k = 0; k < VECTOR_ROWS; ++k) {
        status |= vector_prepare(k);
        status |= vector_step();
        const double seen[OUTPUTS] = {
@seen@
        };
        add_errors(k, seen, worst);
    }
    for (int n = 0; n < OUTPUTS; ++n) {
        const int fine = worst[n] <= @tolerance@;
        status |= !fine;
        if (arguments > 1) {
            printf("%s %.1e\n", name[n], worst[n]);
        } else {
            printf("%s: %s\n", name[n], fine ? "as in Python" : "not as in Python");
        }
    }
    return status;
}
