/* Helper functions of flight code. A function is emitted if it is used. NaN propagates. Integers wrap
   around; their division and the conversion from real numbers follow XLA. No behaviour is undefined. */

static @real@ largest(@real@ a, @real@ b)
{
    return ((a >= b) || (a != a)) ? a : b;
}

static @real@ smallest(@real@ a, @real@ b)
{
    return ((a <= b) || (a != a)) ? a : b;
}

/* The same of a number that is not NaN. */
static @real@ at_least(@real@ least, @real@ b)
{
    return (least >= b) ? least : b;
}

static @real@ at_most(@real@ most, @real@ b)
{
    return (most <= b) ? most : b;
}

static @real@ sense(@real@ a)
{
    return (a > @zero@) ? @one@ : ((a < @zero@) ? -@one@ : a);
}

/* Of an infinite number or NaN, the difference to itself is NaN. A compiler that assumes finite
   numbers, as with -ffast-math, would leave out this test: then the bits of the exponent are tested,
   of a volatile copy, because the copy of a number can be left out too. */
static bool is_finite(@real@ a)
{
#if defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0)
    const volatile @real@ copy = a;
    const @real@ number = copy;
    const @bits@ exponent = @exponent@;
    @bits@ bits;
    const void *from = &number;
    void *to = &bits;
    (void)memcpy(to, from, sizeof bits);
    return (bits & exponent) != exponent;
#else
    return (a - a) == @zero@;
#endif
}

/* Adds a term to a sum that is tested to be finite. The annotations tell Frama-C to analyse finite,
   infinite and NaN terms separately, because a term that is not finite makes the sum not finite. */
static @real@ plus(@real@ sum, @real@ term)
{
    /*@ ghost
        if (sum >= -@largest@) {
            if (sum <= @largest@) {
                /@ split \is_NaN(sum); @/
                /@ split \is_NaN(term); @/
                /@ split term > @largest@; @/
                /@ split term < -@largest@; @/
                ;
            }
        }
    */
    return sum + term;
}

static int64_t integer_of(@real@ a)
{
    int64_t whole = 0;
    if (a >= @limit@) {
        whole = INT64_MAX;
    } else if (a < -@limit@) {
        whole = -INT64_MAX - 1;
    } else {
        whole = (a == a) ? (int64_t)a : 0;
    }
    return whole;
}

static int64_t integer_sum(int64_t a, int64_t b)
{
    const uint64_t sum = (uint64_t)a + (uint64_t)b;
    return (int64_t)sum;
}

static int64_t integer_difference(int64_t a, int64_t b)
{
    const uint64_t difference = (uint64_t)a - (uint64_t)b;
    return (int64_t)difference;
}

static int64_t integer_product(int64_t a, int64_t b)
{
    const uint64_t product = (uint64_t)a * (uint64_t)b;
    return (int64_t)product;
}

static int64_t integer_opposite(int64_t a)
{
    const uint64_t opposite = UINT64_C(0) - (uint64_t)a;
    return (int64_t)opposite;
}

static int64_t integer_quotient(int64_t a, int64_t b)
{
    const uint64_t opposite = UINT64_C(0) - (uint64_t)a;
    return (b == 0) ? -1 : ((b == -1) ? (int64_t)opposite : (a / b));
}

static int64_t integer_rest(int64_t a, int64_t b)
{
    return (b == 0) ? a : ((b == -1) ? 0 : (a % b));
}

static int64_t integer_left(int64_t a, int64_t by)
{
    const bool is_within = (by >= 0) && (by < 64);
    const uint64_t shifted = is_within ? ((uint64_t)a << (uint64_t)by) : UINT64_C(0);
    return (int64_t)shifted;
}

static int64_t integer_right(int64_t a, int64_t by)
{
    const bool is_within = (by >= 0) && (by < 64);
    const uint64_t shifted = is_within ? ((uint64_t)a >> (uint64_t)by) : UINT64_C(0);
    return (int64_t)shifted;
}

/* The bits of a number of double precision. */
static int64_t bits_of_real(@real@ a)
{
    const double number = (double)a;
    int64_t bits;
    const void *from = &number;
    void *to = &bits;
    (void)memcpy(to, from, sizeof bits);
    return bits;
}

static @real@ real_of_bits(int64_t a)
{
    double number;
    const void *from = &a;
    void *to = &number;
    (void)memcpy(to, from, sizeof number);
    return (@real@)number;
}
