/* Program for Frama-C: the module as its README says, in an endless loop, with any bits in each
   input. Parameters and constants of the calling sequence are as exported. */
#include "../@name@.h"

#include <string.h>

extern volatile @bits@ any_bits;
extern volatile int64_t any_number;

static @real@ any_real(void)
{
    const @bits@ bits = any_bits;
    @real@ number;
    (void)memcpy(&number, &bits, sizeof number);
    return number;
}

static int64_t any_integer(void)
{
    return any_number;
}

static bool any_logical(void)
{
    return any_number != 0;
}

@contracts@
int main(void)
{
@declared@

@begin@
    while (true) {
@inputs@
@steps@
    }
}
