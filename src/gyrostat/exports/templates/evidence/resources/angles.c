/* Calls tan for angles whose reduction by pi/2 takes long. */
#include "angles.h"

#include <math.h>

int main(void)
{
    volatile @real@ tangent;
    for (unsigned k = 0u; k < sizeof angles / sizeof *angles; ++k) { tangent = @tangent@(angles[k]); }
    (void)tangent;
    return 0;
}
