/* @title@: @steps@ steps compared with the results of Python. */
#include "@name@.h"

#include <math.h>
#include <stdio.h>

@given@
@expected@
@scale@
static const char *const name[@count@] = {
@names@
};

int main(int arguments, char **argument)
{
    double worst[@count@] = {0.0};
    int status = 0;
@declared@
    (void)argument;
@begin@
    for (int k = 0; k < @steps@; ++k) {
@inputs@
@calls@
        const double seen[@count@] = {
@seen@
        };
        for (int n = 0; n < @count@; ++n) {
            const double error = fabs(seen[n] - expected[k][n]) / scale[0][n];
            if (!(error <= worst[n])) { worst[n] = error; } /* NaN counts as the worst */
        }
    }
    for (int n = 0; n < @count@; ++n) {
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
