/* Operations on one number: for values that are the same in all runs, and for runs one by one. The
   including header defines FUNCTION, the integer types and `one_as_real`, `one_as_integer`, which
   reinterpret 64 bits. */

/* logical shifts; a shift by 64 or more gives 0, as in XLA */
FUNCTION uint64_t one_shift_left(uint64_t x, uint64_t by) { return by < 64 ? x << by : 0; }
FUNCTION uint64_t one_shift_right(uint64_t x, uint64_t by) { return by < 64 ? x >> by : 0; }

/* integer division, rounded towards zero; division by 0 gives a quotient with all bits set and the
   dividend as remainder, as in XLA */
FUNCTION int64_t one_quotient_integer(int64_t a, int64_t b)
{
    return b == 0 ? -1 : b == -1 ? (int64_t)(0 - (uint64_t)a) : a / b;
}
FUNCTION int64_t one_remainder_integer(int64_t a, int64_t b) { return b == 0 ? a : b == -1 ? 0 : a % b; }
FUNCTION uint64_t one_quotient_bits(uint64_t a, uint64_t b) { return b == 0 ? UINT64_MAX : a / b; }
FUNCTION uint64_t one_remainder_bits(uint64_t a, uint64_t b) { return b == 0 ? a : a % b; }

/* rounds towards zero; NaN becomes 0 and values out of range saturate, as in XLA */
FUNCTION int64_t one_integer_of_real(double x)
{
    return x != x ? 0 : x >= 0x1p63 ? INT64_MAX : x < -0x1p63 ? INT64_MIN : (int64_t)x;
}
FUNCTION uint64_t one_bits_of_real(double x)
{
    return x >= 0x1p63 ? (uint64_t)one_integer_of_real(x - 0x1p63) ^ (UINT64_C(1) << 63)
        : x > 0.0 ? (uint64_t)x : 0;
}

/* minimum and maximum that propagate NaN */
FUNCTION double one_max_real(double a, double b) { return ((a >= b) || (a != a)) ? a : b; }
FUNCTION double one_min_real(double a, double b) { return ((a <= b) || (a != a)) ? a : b; }
FUNCTION double one_sign_real(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : x; }
