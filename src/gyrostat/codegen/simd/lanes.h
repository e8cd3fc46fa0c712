/* SIMD vector types and mathematical functions for programs with one run in each lane.

   Real numbers, integers and bits are vectors of 64-bit elements. A logical value is a mask: one
   bit for each lane if the processor has mask registers, otherwise 0 or -1 in each lane. The
   result of a function in one lane does not depend on the values in the other lanes, so that the
   results of a run do not depend on its neighbours.

   Subnormal numbers are zero on x86-64, as they are in XLA.

   Largest errors against the exact value, over all arguments in the tests, in units in the last
   place: exp 1, expm1 2, tanh 3, log 1, log1p 2, sin and cos 1 (below 8e5; above it, those of the
   C library), atan2, asin and acos 3. For erf_inv: 1e-15 relative. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#if defined(__AVX512F__) && defined(__AVX512DQ__)
#define LANES 8
#else
#define LANES 4
#endif
#define EACH for (int lane = 0; lane < LANES; ++lane)

typedef double real __attribute__((vector_size(8 * LANES)));
typedef int64_t integer __attribute__((vector_size(8 * LANES)));
typedef uint64_t bits __attribute__((vector_size(8 * LANES)));
typedef uint32_t words __attribute__((vector_size(4 * LANES)));
/* the same types for unaligned memory */
typedef double real_memory __attribute__((vector_size(8 * LANES), aligned(8), may_alias));
typedef int64_t integer_memory __attribute__((vector_size(8 * LANES), aligned(8), may_alias));
typedef uint64_t bits_memory __attribute__((vector_size(8 * LANES), aligned(8), may_alias));

/* arithmetic with subnormal numbers would take a hundred times as long */
#ifdef __SSE2__
#define WITHOUT_SUBNORMALS(program)                                                               \
    {                                                                                             \
        const unsigned before = __builtin_ia32_stmxcsr();                                         \
        __builtin_ia32_ldmxcsr(before | 0x8040);                                                  \
        program;                                                                                  \
        __builtin_ia32_ldmxcsr(before);                                                           \
    }
#else
#define WITHOUT_SUBNORMALS(program) program;
#endif

#define FUNCTION static inline __attribute__((unused, always_inline))
#define SELDOM(test) __builtin_expect(test, 0)
/* Long functions are not inlined: a program calls them from hundreds of places. The compiler knows
   which registers they change, and keeps its values in the others. */
#define LONG_FUNCTION static __attribute__((unused, noinline))

/* not a loop over the lanes: the compiler would keep thousands of these until late */
#if LANES == 8
#define ALL(x) {x, x, x, x, x, x, x, x}
#else
#define ALL(x) {x, x, x, x}
#endif
FUNCTION real all_real(double x) { return (real)ALL(x); }
FUNCTION integer all_integer(int64_t x) { return (integer)ALL(x); }
FUNCTION bits all_bits(uint64_t x) { return (bits)ALL(x); }

#if LANES == 8
#if defined(__clang__) || __GNUC__ < 9 || __GNUC__ > 14
#include <immintrin.h>
#else
/* GCC needs as long for immintrin.h as for the rest of this file: the few intrinsics that are used,
   defined as in that header */
typedef double __m512d __attribute__((vector_size(64), may_alias));
typedef long long __m512i __attribute__((vector_size(64), may_alias));
typedef unsigned char __mmask8;
#define EVERY_LANE (__mmask8) - 1
#define CURRENT_ROUNDING 4
#define _MM_FROUND_TO_NEAREST_INT 0
#define _MM_FROUND_TO_NEG_INF 1
#define _MM_FROUND_TO_POS_INF 2
#define _MM_FROUND_NO_EXC 8
enum { _CMP_EQ_OQ, _CMP_NEQ_UQ = 4, _CMP_LT_OQ = 17, _CMP_LE_OQ, _CMP_GE_OQ = 29, _CMP_GT_OQ };
enum { _MM_CMPINT_EQ, _MM_CMPINT_LT, _MM_CMPINT_LE, _MM_CMPINT_NE = 4 };
enum { _MM_CMPINT_NLT = 5, _MM_CMPINT_NLE };
#define _mm512_cmp_pd_mask(a, b, sign)                                                            \
    __builtin_ia32_cmppd512_mask(a, b, sign, EVERY_LANE, CURRENT_ROUNDING)
#define _mm512_cmp_epi64_mask(a, b, sign) __builtin_ia32_cmpq512_mask(a, b, sign, EVERY_LANE)
#define _mm512_cmp_epu64_mask(a, b, sign) __builtin_ia32_ucmpq512_mask(a, b, sign, EVERY_LANE)
#define _mm512_mask_blend_pd(m, no, yes) __builtin_ia32_blendmpd_512_mask(no, yes, m)
#define _mm512_mask_blend_epi64(m, no, yes) __builtin_ia32_blendmq_512_mask(no, yes, m)
#define _mm512_max_pd(a, b) __builtin_ia32_maxpd512_mask(a, b, a, EVERY_LANE, CURRENT_ROUNDING)
#define _mm512_min_pd(a, b) __builtin_ia32_minpd512_mask(a, b, a, EVERY_LANE, CURRENT_ROUNDING)
#define _mm512_scalef_pd(a, b) __builtin_ia32_scalefpd512_mask(a, b, a, EVERY_LANE, CURRENT_ROUNDING)
#define _mm512_roundscale_pd(a, how)                                                              \
    __builtin_ia32_rndscalepd_mask(a, how, a, EVERY_LANE, CURRENT_ROUNDING)
#define _mm512_sqrt_pd(a) __builtin_ia32_sqrtpd512_mask(a, a, EVERY_LANE, CURRENT_ROUNDING)
#define _mm512_fpclass_pd_mask(a, kinds) __builtin_ia32_fpclasspd512_mask(a, kinds, EVERY_LANE)
#endif
typedef __mmask8 mask;
#define COMPARED(name, sign, real_sign, whole_sign)                                               \
    FUNCTION mask name##_real(real a, real b)                                                     \
    {                                                                                             \
        return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, real_sign);                             \
    }                                                                                             \
    FUNCTION mask name##_integer(integer a, integer b)                                            \
    {                                                                                             \
        return _mm512_cmp_epi64_mask((__m512i)a, (__m512i)b, whole_sign);                         \
    }                                                                                             \
    FUNCTION mask name##_bits(bits a, bits b)                                                     \
    {                                                                                             \
        return _mm512_cmp_epu64_mask((__m512i)a, (__m512i)b, whole_sign);                         \
    }
FUNCTION mask all_mask(bool x) { return x ? 0xff : 0; }
FUNCTION bool any(mask m) { return m != 0; }
FUNCTION bool lane_of(mask m, int lane) { return (m >> lane) & 1; }
FUNCTION mask with_lane(mask m, int lane, bool is)
{
    return (mask)((m & ~(1 << lane)) | (is << lane));
}
FUNCTION real select_real(mask m, real yes, real no)
{
    return (real)_mm512_mask_blend_pd(m, (__m512d)no, (__m512d)yes);
}
FUNCTION integer select_integer(mask m, integer yes, integer no)
{
    return (integer)_mm512_mask_blend_epi64(m, (__m512i)no, (__m512i)yes);
}
#else
typedef integer mask;
#define COMPARED(name, sign, real_sign, whole_sign)                                               \
    FUNCTION mask name##_real(real a, real b) { return a sign b; }                                \
    FUNCTION mask name##_integer(integer a, integer b) { return a sign b; }                       \
    FUNCTION mask name##_bits(bits a, bits b) { return a sign b; }
FUNCTION mask all_mask(bool x) { return all_integer(-(int64_t)x); }
FUNCTION bool any(mask m)
{
    int64_t joined = 0;
    EACH joined |= m[lane];
    return joined != 0;
}
FUNCTION bool lane_of(mask m, int lane) { return m[lane] != 0; }
FUNCTION mask with_lane(mask m, int lane, bool is)
{
    m[lane] = -(int64_t)is;
    return m;
}
FUNCTION integer select_integer(mask m, integer yes, integer no) { return (m & yes) | (~m & no); }
FUNCTION real select_real(mask m, real yes, real no)
{
    return (real)((m & (integer)yes) | (~m & (integer)no));
}
#endif
COMPARED(lt, <, _CMP_LT_OQ, _MM_CMPINT_LT)
COMPARED(le, <=, _CMP_LE_OQ, _MM_CMPINT_LE)
COMPARED(gt, >, _CMP_GT_OQ, _MM_CMPINT_NLE)
COMPARED(ge, >=, _CMP_GE_OQ, _MM_CMPINT_NLT)
COMPARED(eq, ==, _CMP_EQ_OQ, _MM_CMPINT_EQ)
COMPARED(ne, !=, _CMP_NEQ_UQ, _MM_CMPINT_NE)
FUNCTION mask not_mask(mask m) { return ~m; }
FUNCTION mask and_mask(mask a, mask b) { return a & b; }
FUNCTION mask or_mask(mask a, mask b) { return a | b; }
FUNCTION mask xor_mask(mask a, mask b) { return a ^ b; }
FUNCTION mask lt_mask(mask a, mask b) { return and_mask(not_mask(a), b); }
FUNCTION mask le_mask(mask a, mask b) { return or_mask(not_mask(a), b); }
FUNCTION mask gt_mask(mask a, mask b) { return lt_mask(b, a); }
FUNCTION mask ge_mask(mask a, mask b) { return le_mask(b, a); }
FUNCTION mask eq_mask(mask a, mask b) { return not_mask(xor_mask(a, b)); }
FUNCTION mask ne_mask(mask a, mask b) { return xor_mask(a, b); }
FUNCTION mask select_mask(mask m, mask yes, mask no)
{
    return or_mask(and_mask(m, yes), and_mask(not_mask(m), no));
}
FUNCTION bits select_bits(mask m, bits yes, bits no)
{
    return (bits)select_integer(m, (integer)yes, (integer)no);
}
/* comparisons with a constant, and the test for NaN */
#define BELOW(x, number) lt_real(x, all_real(number))
#define ABOVE(x, number) gt_real(x, all_real(number))
#define IS(x, number) eq_real(x, all_real(number))
FUNCTION mask is_none(real x) { return ne_real(x, x); }

FUNCTION real real_of_integer(integer x) { return __builtin_convertvector(x, real); }
FUNCTION real real_of_bits(bits x) { return __builtin_convertvector(x, real); }
FUNCTION real real_of_mask(mask m) { return select_real(m, all_real(1.0), all_real(0.0)); }
FUNCTION integer integer_of_mask(mask m) { return select_integer(m, all_integer(1), all_integer(0)); }
FUNCTION mask mask_of_integer(integer x) { return ne_integer(x, all_integer(0)); }
/* rounds towards zero; NaN becomes 0 and values out of range saturate, as in XLA */
FUNCTION integer integer_of_real(real x)
{
    const mask high = ge_real(x, all_real(0x1p63)), low = BELOW(x, -0x1p63);
    const mask beyond = or_mask(high, low);
    const real inside = select_real(or_mask(beyond, is_none(x)), all_real(0.0), x);
    const integer most = select_integer(high, all_integer(INT64_MAX), all_integer(INT64_MIN));
    return select_integer(beyond, most, __builtin_convertvector(inside, integer));
}
FUNCTION int64_t one_integer_of_real(double x)
{
    return x != x ? 0 : x >= 0x1p63 ? INT64_MAX : x < -0x1p63 ? INT64_MIN : (int64_t)x;
}
/* the same for unsigned results, up to 2^64 */
FUNCTION bits bits_of_real(real x)
{
    const mask high = ge_real(x, all_real(0x1p63));
    const real low = select_real(ABOVE(x, 0.0), x, all_real(0.0));
    const integer top = select_integer(high, all_integer(INT64_MIN), all_integer(0));
    return (bits)(integer_of_real(select_real(high, low - 0x1p63, low)) ^ top);
}
FUNCTION uint64_t one_bits_of_real(double x)
{
    return x >= 0x1p63 ? (uint64_t)one_integer_of_real(x - 0x1p63) ^ (1ull << 63)
        : x > 0.0 ? (uint64_t)x : 0;
}
/* reinterpret the 64 bits of a number as another type */
#define ONE_AS(type, number)                                                                      \
    ({                                                                                            \
        const __typeof__(number) before = (number);                                               \
        type after;                                                                               \
        memcpy(&after, &before, 8);                                                               \
        after;                                                                                    \
    })
/* words at an index of each lane, from a first word on: in memory with one word for all lanes, and
   with one word for each lane. Gather instructions were slower than these reads (AVX2). */
LONG_FUNCTION bits shared_words(const uint64_t *memory, int64_t first, integer index)
{
    bits r;
    EACH r[lane] = memory[first + index[lane]];
    return r;
}
LONG_FUNCTION bits own_words(const uint64_t *memory, int64_t first, integer index)
{
    bits r;
    EACH r[lane] = memory[(first + index[lane]) * LANES + lane];
    return r;
}
/* elements at an index of each lane: of a table with one number for all lanes, and of a table with
   one number for each lane */
#define ELEMENTS(kind, one)                                                                       \
    LONG_FUNCTION kind shared_##kind(const one *table, integer index)                             \
    {                                                                                             \
        kind r;                                                                                   \
        EACH r[lane] = table[index[lane]];                                                        \
        return r;                                                                                 \
    }                                                                                             \
    LONG_FUNCTION kind own_##kind(const kind *table, integer index)                               \
    {                                                                                             \
        kind r;                                                                                   \
        EACH r[lane] = table[index[lane]][lane];                                                  \
        return r;                                                                                 \
    }
ELEMENTS(real, double)
ELEMENTS(integer, int64_t)
ELEMENTS(bits, uint64_t)
LONG_FUNCTION mask shared_mask(const bool *table, integer index)
{
    mask r = all_mask(false);
    EACH r = with_lane(r, lane, table[index[lane]]);
    return r;
}
LONG_FUNCTION mask own_mask(const mask *table, integer index)
{
    mask r = all_mask(false);
    EACH r = with_lane(r, lane, lane_of(table[index[lane]], lane));
    return r;
}

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
#define DIVIDED(name, kind)                                                                       \
    LONG_FUNCTION kind name##_##kind(kind a, kind b)                                              \
    {                                                                                             \
        kind r;                                                                                   \
        EACH r[lane] = one_##name##_##kind(a[lane], b[lane]);                                     \
        return r;                                                                                 \
    }
DIVIDED(quotient, integer)
DIVIDED(remainder, integer)
DIVIDED(quotient, bits)
DIVIDED(remainder, bits)

/* minimum and maximum that propagate NaN; first those with a constant that is not NaN */
#if LANES == 8
FUNCTION real at_least(double a, real b) { return (real)_mm512_max_pd((__m512d)all_real(a), (__m512d)b); }
FUNCTION real at_most(double a, real b) { return (real)_mm512_min_pd((__m512d)all_real(a), (__m512d)b); }
#else
FUNCTION real at_least(double a, real b) { return select_real(BELOW(b, a), all_real(a), b); }
FUNCTION real at_most(double a, real b) { return select_real(ABOVE(b, a), all_real(a), b); }
#endif
FUNCTION real max_real(real a, real b) { return select_real(or_mask(ge_real(a, b), is_none(a)), a, b); }
FUNCTION real min_real(real a, real b) { return select_real(or_mask(le_real(a, b), is_none(a)), a, b); }
FUNCTION double one_max_real(double a, double b) { return ((a >= b) || (a != a)) ? a : b; }
FUNCTION double one_min_real(double a, double b) { return ((a <= b) || (a != a)) ? a : b; }

FUNCTION real abs_real(real x) { return (real)((integer)x & INT64_MAX); }
FUNCTION real sign_real(real x)
{
    const real one = (real)(((integer)x & INT64_MIN) | (integer)all_real(1.0));
    return select_real(ABOVE(abs_real(x), 0.0), one, x);
}
FUNCTION double one_sign_real(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : x; }
#if LANES == 8
FUNCTION real sqrt_real(real x) { return (real)_mm512_sqrt_pd((__m512d)x); }
/* neither NaN (quiet or signalling) nor infinite */
FUNCTION mask finite_real(real x) { return not_mask(_mm512_fpclass_pd_mask((__m512d)x, 0x99)); }
#define ROUNDED(way) (real)_mm512_roundscale_pd((__m512d)x, (way) | _MM_FROUND_NO_EXC)
FUNCTION real floor_real(real x) { return ROUNDED(_MM_FROUND_TO_NEG_INF); }
FUNCTION real ceil_real(real x) { return ROUNDED(_MM_FROUND_TO_POS_INF); }
FUNCTION real rint_real(real x) { return ROUNDED(_MM_FROUND_TO_NEAREST_INT); }
#else
FUNCTION real sqrt_real(real x) { real r; EACH r[lane] = sqrt(x[lane]); return r; }
FUNCTION mask finite_real(real x) { return BELOW(abs_real(x), INFINITY); }
FUNCTION real floor_real(real x) { real r; EACH r[lane] = floor(x[lane]); return r; }
FUNCTION real ceil_real(real x) { real r; EACH r[lane] = ceil(x[lane]); return r; }
FUNCTION real rint_real(real x) { real r; EACH r[lane] = rint(x[lane]); return r; }
#endif

/* one lane after the other through the C library: rarely used */
#define LANE_BY_LANE(name)                                                                        \
    LONG_FUNCTION real name##_real(real x) { real r; EACH r[lane] = name(x[lane]); return r; }
#define LANE_BY_LANE_2(name)                                                                      \
    LONG_FUNCTION real name##_real(real x, real y)                                                \
    {                                                                                             \
        real r;                                                                                   \
        EACH r[lane] = name(x[lane], y[lane]);                                                    \
        return r;                                                                                 \
    }
LANE_BY_LANE(round)
LANE_BY_LANE(exp2)
LANE_BY_LANE(tan)
LANE_BY_LANE(atan)
LANE_BY_LANE(sinh)
LANE_BY_LANE(cosh)
LANE_BY_LANE(asinh)
LANE_BY_LANE(acosh)
LANE_BY_LANE(atanh)
LANE_BY_LANE(erf)
LANE_BY_LANE(erfc)
LANE_BY_LANE(cbrt)
LANE_BY_LANE_2(pow)
LANE_BY_LANE_2(fmod)

/* an integer-valued real below 2^51 as an integer: in 1.5 * 2^52 + number, it is the last bits */
FUNCTION integer integer_near(real number)
{
    return (integer)(number + 0x1.8p52) - (integer)all_real(0x1.8p52);
}

/* 1 / n! from n = 2 on. Weak, so that the compiler reads them from memory: otherwise it would
   rebuild them at each use and keep them on the stack. */
const real shares[] __attribute__((weak, visibility("hidden"))) = {
    ALL(1.0 / 2.0), ALL(1.0 / 6.0), ALL(1.0 / 24.0), ALL(1.0 / 120.0), ALL(1.0 / 720.0),
    ALL(1.0 / 5040.0), ALL(1.0 / 40320.0), ALL(1.0 / 362880.0), ALL(1.0 / 3628800.0),
    ALL(1.0 / 39916800.0), ALL(1.0 / 479001600.0), ALL(1.0 / 6227020800.0),
};

/* exp(r) - 1 for |r| <= ln(2)/2, by the Taylor series up to r^13 / 13!, with terms in pairs to
   shorten the chain of dependent operations */
FUNCTION real expm1_near_zero(real r)
{
    const real r2 = r * r, r4 = r2 * r2;
    const real low = (shares[0] + r * shares[1]) + r2 * (shares[2] + r * shares[3]);
    const real middle = (shares[4] + r * shares[5]) + r2 * (shares[6] + r * shares[7]);
    const real high = (shares[8] + r * shares[9]) + r2 * (shares[10] + r * shares[11]);
    return r + r2 * (low + r4 * (middle + r4 * high));
}

/* x - number ln(2); ln(2) is split in two parts, the first of 32 bits so that its product with
   number is exact */
FUNCTION real rest_of_ln2(real x, real number)
{
    return (x - number * 0.6931471803691238) - number * 1.9082149292705877e-10;
}

FUNCTION real power_of_two(integer k) { return (real)((k + 1023) << 52); }

/* short enough to be inlined: a call would spill the registers to memory */
FUNCTION real exp_real(real x)
{
    x = at_least(-760.0, at_most(720.0, x));
    const real number = rint_real(x * 1.4426950408889634);
    const real p = 1.0 + expm1_near_zero(rest_of_ln2(x, number));
#if LANES == 8
    return (real)_mm512_scalef_pd((__m512d)p, (__m512d)number);
#else
    /* two factors: a subnormal result is rounded once, and overflow gives infinity */
    const integer k = integer_near(number), half = k >> 1;
    return p * power_of_two(half) * power_of_two(k - half);
#endif
}

LONG_FUNCTION real expm1_real(real x)
{
    const mask far = ABOVE(abs_real(x), 40.0);
    const real near = select_real(far, all_real(0.0), x);
    const real number = rint_real(near * 1.4426950408889634);
    const real p = expm1_near_zero(rest_of_ln2(near, number));
    const real scale = power_of_two(integer_near(number));
    const real made = scale * p + (scale - 1.0);
    real result = select_real(IS(number, 0.0), p, made);
    if (any(far)) { result = select_real(far, exp_real(x) - 1.0, result); }
    return result;
}

LONG_FUNCTION real tanh_real(real x)
{
    const real size = abs_real(x);
    const real e = expm1_real(2.0 * select_real(ABOVE(size, 20.0), all_real(20.0), size));
    const real made = e / (e + 2.0);
    return (real)((integer)made | ((integer)x & INT64_MIN));
}

/* m 2^k with m between sqrt(1/2) and sqrt(2); ln(m) = 2 artanh(s), s = (m - 1)/(m + 1) */
LONG_FUNCTION real log_real(real x)
{
    const mask small = BELOW(x, 0x1p-1022);
    const real scaled = select_real(small, x * 0x1p54, x);
    const integer offset = (integer)scaled - 0x3fe6a09e667f3bcd;
    const integer k = offset >> 52;
    const real m = (real)((integer)scaled - (k << 52));
    const real number = real_of_integer(k) - select_real(small, all_real(54.0), all_real(0.0));
    const real f = m - 1.0;
    const real s = f / (m + 1.0);
    const real z = s * s;
    real p = z * (2.0 / 23.0) + 2.0 / 21.0;
    p = p * z + 2.0 / 19.0;
    p = p * z + 2.0 / 17.0;
    p = p * z + 2.0 / 15.0;
    p = p * z + 2.0 / 13.0;
    p = p * z + 2.0 / 11.0;
    p = p * z + 2.0 / 9.0;
    p = p * z + 2.0 / 7.0;
    p = p * z + 2.0 / 5.0;
    p = p * z + 2.0 / 3.0;
    /* 2 s = f - s f, which reduces the effect of the rounding of s */
    const real rest = s * (z * p - f);
    real made = number * 0.6931471803691238 + (f + (rest + number * 1.9082149292705877e-10));
    made = select_real(IS(x, INFINITY), x, made);
    made = select_real(IS(x, 0.0), all_real(-INFINITY), made);
    return select_real(or_mask(BELOW(x, 0.0), is_none(x)), all_real(NAN), made);
}

LONG_FUNCTION real log1p_real(real x)
{
    const real u = 1.0 + x;
    const real lost = (x - (u - 1.0)) / u;
    const real made = log_real(u) + lost;
    const real ends = select_real(IS(u, 0.0), all_real(-INFINITY), select_real(IS(u, INFINITY), u, made));
    return select_real(BELOW(abs_real(x), 0x1p-54), x, ends);
}

/* x = n pi/2 + r; pi/2 in three parts, the first two of 33 bits */
FUNCTION real quartered(real x, integer *n)
{
    const real number = rint_real(x * 0.6366197723675814);
    *n = integer_near(number);
    return ((x - number * 1.5707963267341256) - number * 6.077100506303966e-11)
        - number * 2.0222662487959506e-21;
}

/* Taylor series for |r| <= pi/4, up to r^17 and r^18 */
FUNCTION real sin_near_zero(real r)
{
    const real z = r * r;
    real p = z * (1.0 / 355687428096000.0) - 1.0 / 1307674368000.0;
    p = p * z + 1.0 / 6227020800.0;
    p = p * z - 1.0 / 39916800.0;
    p = p * z + 1.0 / 362880.0;
    p = p * z - 1.0 / 5040.0;
    p = p * z + 1.0 / 120.0;
    p = p * z - 1.0 / 6.0;
    return r + r * z * p;
}

FUNCTION real cos_near_zero(real r)
{
    const real z = r * r;
    real p = z * (-1.0 / 6402373705728000.0) + 1.0 / 20922789888000.0;
    p = p * z - 1.0 / 87178291200.0;
    p = p * z + 1.0 / 479001600.0;
    p = p * z - 1.0 / 3628800.0;
    p = p * z + 1.0 / 40320.0;
    p = p * z - 1.0 / 720.0;
    p = p * z + 1.0 / 24.0;
    /* 1 - z/2, compensated for its rounding error */
    const real half = 0.5 * z, near = 1.0 - half;
    return near + (((1.0 - near) - half) + z * z * p);
}

#define LARGEST_ANGLE 8e5

LONG_FUNCTION real sin_real(real x)
{
    integer n;
    const real r = quartered(x, &n);
    const real made = select_real(mask_of_integer(n & 1), cos_near_zero(r), sin_near_zero(r));
    real result = (real)((integer)made ^ ((n & 2) << 62));
    const mask far = not_mask(BELOW(abs_real(x), LARGEST_ANGLE));
    if (any(far)) { EACH if (lane_of(far, lane)) { result[lane] = sin(x[lane]); } }
    return select_real(IS(x, 0.0), x, result);
}

LONG_FUNCTION real cos_real(real x)
{
    integer n;
    const real r = quartered(x, &n);
    const real made = select_real(mask_of_integer(n & 1), sin_near_zero(r), cos_near_zero(r));
    real result = (real)((integer)made ^ (((n + 1) & 2) << 62));
    const mask far = not_mask(BELOW(abs_real(x), LARGEST_ANGLE));
    if (any(far)) { EACH if (lane_of(far, lane)) { result[lane] = cos(x[lane]); } }
    return result;
}

/* (atan(q)/q - 1)/q^2 for |q| <= tan(pi/8), interpolated at Chebyshev points; error 5e-18 */
FUNCTION real atan_near_zero(real q)
{
    const real z = q * q;
    real p = z * -0.019176887119048774 + 0.039231658295576184;
    p = p * z - 0.05085449737939879;
    p = p * z + 0.05858148912802137;
    p = p * z - 0.06664511447381939;
    p = p * z + 0.07692183190826087;
    p = p * z - 0.09090904578123901;
    p = p * z + 0.11111111015256361;
    p = p * z - 0.14285714284666542;
    p = p * z + 0.1999999999999552;
    p = p * z - 0.3333333333333333;
    return q + q * z * p;
}

LONG_FUNCTION real atan2_real(real y, real x)
{
    const integer sign_bit = all_integer(INT64_MIN);
    real a = abs_real(y), b = abs_real(x);
    const mask steep = gt_real(a, b);
    real low = select_real(steep, b, a), high = select_real(steep, a, b);
    const mask endless = IS(high, INFINITY), both = and_mask(endless, IS(low, INFINITY));
    low = select_real(both, all_real(1.0), select_real(endless, all_real(0.0), low));
    high = select_real(endless, all_real(1.0), high);
    /* scale to avoid overflow and underflow */
    const real smaller = select_real(ABOVE(high, 0x1p500), all_real(0x1p-500), all_real(1.0));
    const real scale = select_real(BELOW(high, 0x1p-500), all_real(0x1p500), smaller);
    low *= scale;
    high *= scale;
    const mask wide = gt_real(low, 0.41421356237309503 * high);
    const real top = select_real(wide, low - high, low);
    const real bottom = select_real(wide, low + high, high);
    const real q = select_real(IS(bottom, 0.0), all_real(0.0), top / bottom);
    real angle = atan_near_zero(q);
    angle = select_real(wide, 0x1.921fb54442d18p-1 + (angle + 0x1.1a62633145c07p-55), angle);
    angle = select_real(steep, 0x1.921fb54442d18p0 - (angle - 0x1.1a62633145c07p-54), angle);
    const mask left = mask_of_integer((integer)x & sign_bit);
    angle = select_real(left, 0x1.921fb54442d18p1 - (angle - 0x1.1a62633145c07p-53), angle);
    angle = (real)((integer)angle | ((integer)y & sign_bit));
    return select_real(or_mask(is_none(x), is_none(y)), x + y, angle);
}

FUNCTION real asin_real(real x) { return atan2_real(x, sqrt_real((1.0 - x) * (1.0 + x))); }
FUNCTION real acos_real(real x) { return atan2_real(sqrt_real((1.0 - x) * (1.0 + x)), x); }

#define HORNER(count, table, w)                                                                   \
    ({                                                                                            \
        real sum = all_real((table)[0]);                                                          \
        for (int term = 1; term < (count); ++term) { sum = sum * (w) + (table)[term]; }           \
        sum;                                                                                      \
    })

/* M. Giles, "Approximating the erfinv function", GPU Computing Gems, Jade ed., 2011, table 10.4 */
static const double giles_near[] = {
    -3.6444120640178196996e-21, -1.685059138182016589e-19, 1.2858480715256400167e-18,
    1.115787767802518096e-17, -1.333171662854620906e-16, 2.0972767875968561637e-17,
    6.6376381343583238325e-15, -4.0545662729752068639e-14, -8.1519341976054721522e-14,
    2.6335093153082322977e-12, -1.2975133253453532498e-11, -5.4154120542946279317e-11,
    1.051212273321532285e-09, -4.1126339803469836976e-09, -2.9070369957882005086e-08,
    4.2347877827932403518e-07, -1.3654692000834678645e-06, -1.3882523362786468719e-05,
    0.0001867342080340571352, -0.00074070253416626697512, -0.0060336708714301490533,
    0.24015818242558961693, 1.6536545626831027356,
};
static const double giles_middle[] = {
    2.2137376921775787049e-09, 9.0756561938885390979e-08, -2.7517406297064545428e-07,
    1.8239629214389227755e-08, 1.5027403968909827627e-06, -4.013867526981545969e-06,
    2.9234449089955446044e-06, 1.2475304481671778723e-05, -4.7318229009055733981e-05,
    6.8284851459573175448e-05, 2.4031110387097893999e-05, -0.0003550375203628474796,
    0.00095328937973738049703, -0.0016882755560235047313, 0.0024914420961078508066,
    -0.0037512085075692412107, 0.005370914553590063617, 1.0052589676941592334,
    3.0838856104922207635,
};
static const double giles_far[] = {
    -2.7109920616438573243e-11, -2.5556418169965252055e-10, 1.5076572693500548083e-09,
    -3.7894654401267369937e-09, 7.6157012080783393804e-09, -1.4960026627149240478e-08,
    2.9147953450901080826e-08, -6.7711997758452339498e-08, 2.2900482026654717e-07,
    -9.9298272942317002539e-07, 4.5260625972231537039e-06, -1.9681778105531670567e-05,
    7.5995277030017761139e-05, -0.00021503011930044477347, -0.00013871931833623122026,
    1.0103004648645343977, 4.8499064014085844221,
};

LONG_FUNCTION real erf_inv_real(real x)
{
    const real w = -log1p_real(-(x * x));
    const real near = w - 3.125;
    real p = HORNER(23, giles_near, near);
    const mask beyond = ge_real(w, all_real(6.25));
    if (any(beyond)) {
        const real root = sqrt_real(w);
        const real middle = root - 3.25, far = root - 5.0;
        const real near_one = HORNER(17, giles_far, far);
        const real made = select_real(BELOW(w, 16.0), HORNER(19, giles_middle, middle), near_one);
        p = select_real(beyond, made, p);
    }
    return select_real(IS(abs_real(x), 1.0), x * INFINITY, p * x);
}

/* Threefry-2x32 with 20 rounds: J. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3",
   2011. Both key and counter are two words, the first in the upper half. */
#define ROTATED(x, r) (((x) << (r)) | ((x) >> (32 - (r))))
#define FOUR_ROUNDS(a, b, c, d)                                                                   \
    x0 += x1; x1 = ROTATED(x1, a) ^ x0; x0 += x1; x1 = ROTATED(x1, b) ^ x0;                       \
    x0 += x1; x1 = ROTATED(x1, c) ^ x0; x0 += x1; x1 = ROTATED(x1, d) ^ x0;

LONG_FUNCTION bits threefry_bits(bits key, bits counter)
{
    const words k0 = __builtin_convertvector(key >> 32, words);
    const words k1 = __builtin_convertvector(key & 0xffffffffu, words);
    const words k2 = k0 ^ k1 ^ 0x1bd11bdau;
    words x0 = __builtin_convertvector(counter >> 32, words) + k0;
    words x1 = __builtin_convertvector(counter & 0xffffffffu, words) + k1;
    FOUR_ROUNDS(13, 15, 26, 6) x0 += k1; x1 += k2 + 1u;
    FOUR_ROUNDS(17, 29, 16, 24) x0 += k2; x1 += k0 + 2u;
    FOUR_ROUNDS(13, 15, 26, 6) x0 += k0; x1 += k1 + 3u;
    FOUR_ROUNDS(17, 29, 16, 24) x0 += k1; x1 += k2 + 4u;
    FOUR_ROUNDS(13, 15, 26, 6) x0 += k2; x1 += k0 + 5u;
    return (__builtin_convertvector(x0, bits) << 32) | __builtin_convertvector(x1, bits);
}
