/* SIMD vector types and their operations, for programs with one run in each lane.

   Real numbers, integers and bits are vectors of 64-bit elements. A logical value is a mask: one
   bit for each lane if the processor has mask registers, otherwise 0 or -1 in each lane. The
   result of a function in one lane does not depend on the values in the other lanes, so that the
   results of a run do not depend on its neighbours.

   Subnormal numbers are zero on x86-64, as they are in XLA. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#if defined(__AVX512F__) && defined(__AVX512DQ__)
#define LANES 8
#elif defined(__wasm__)
#define LANES 2 /* its vectors have 128 bits */
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
#define MIDDLE_FUNCTION FUNCTION
#define SELDOM(test) __builtin_expect(test, 0)
/* Long functions are not inlined: a program calls them from hundreds of places. The compiler knows
   which registers they change, and keeps its values in the others. */
#define LONG_FUNCTION static __attribute__((unused, noinline))

/* reinterpret the 64 bits of a number as another type */
FUNCTION double one_as_real(uint64_t x)
{
    double y;
    memcpy(&y, &x, 8);
    return y;
}
FUNCTION int64_t one_as_integer(double x)
{
    int64_t y;
    memcpy(&y, &x, 8);
    return y;
}
FUNCTION real as_real(integer x) { return (real)x; }
FUNCTION integer as_integer(real x) { return (integer)x; }
#include "numbers.h"

/* memory of the inputs and results */
#define SHARED(index) shared[index]
#define OWN(kind, index) ((const kind##_memory *)own)[index]
#define PUT(kind, memory, index, value) ((kind##_memory *)memory)[index] = value
#define COMMON(type, name, value) const type name = value
#define ALIGN
#define TABLE static const
#define TABLE_OF(type) const type *

/* not a loop over the lanes: the compiler would keep thousands of these until late */
#if LANES == 8
#define ALL(x) {x, x, x, x, x, x, x, x}
#elif LANES == 2
#define ALL(x) {x, x}
#else
#define ALL(x) {x, x, x, x}
#endif
FUNCTION real all_real(double x) { return (real)ALL(x); }
FUNCTION integer all_integer(int64_t x) { return (integer)ALL(x); }
FUNCTION bits all_bits(uint64_t x) { return (bits)ALL(x); }
FUNCTION double one_of_real(real x) { return x[0]; }
FUNCTION uint64_t one_of_bits(bits x) { return x[0]; }
/* Weak, so that the compiler reads them from memory: otherwise it would rebuild them at each use and
   keep them on the stack. */
#define SHARES const real __attribute__((weak, visibility("hidden")))
FUNCTION words words_of_bits(bits x) { return __builtin_convertvector(x, words); }
FUNCTION bits bits_of_words(words x) { return __builtin_convertvector(x, bits); }

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
FUNCTION bits select_bits(mask m, bits yes, bits no)
{
    return (bits)select_integer(m, (integer)yes, (integer)no);
}
FUNCTION real real_of_integer(integer x) { return __builtin_convertvector(x, real); }
FUNCTION real real_of_bits(bits x) { return __builtin_convertvector(x, real); }
/* rounds towards zero; NaN becomes 0 and values out of range saturate, as in XLA */
FUNCTION integer integer_of_real(real x)
{
    const mask high = ge_real(x, all_real(0x1p63)), low = lt_real(x, all_real(-0x1p63));
    const mask beyond = or_mask(high, low);
    const real inside = select_real(or_mask(beyond, ne_real(x, x)), all_real(0.0), x);
    const integer most = select_integer(high, all_integer(INT64_MAX), all_integer(INT64_MIN));
    return select_integer(beyond, most, __builtin_convertvector(inside, integer));
}
/* the same for unsigned results, up to 2^64 */
FUNCTION bits bits_of_real(real x)
{
    const mask high = ge_real(x, all_real(0x1p63));
    const real low = select_real(gt_real(x, all_real(0.0)), x, all_real(0.0));
    const integer top = select_integer(high, all_integer(INT64_MIN), all_integer(0));
    return (bits)(integer_of_real(select_real(high, low - 0x1p63, low)) ^ top);
}
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
   one number for each lane, which is also set in the active lanes */
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
    }                                                                                             \
    FUNCTION void set_##kind(kind *table, integer index, kind value, mask active)                 \
    {                                                                                             \
        EACH if (lane_of(active, lane)) table[index[lane]][lane] = value[lane];                   \
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
FUNCTION void set_mask(mask *table, integer index, mask value, mask active)
{
    EACH if (lane_of(active, lane))
    {
        table[index[lane]] = with_lane(table[index[lane]], lane, lane_of(value, lane));
    }
}

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

/* minimum and maximum with a constant that is not NaN; NaN propagates */
#if LANES == 8
FUNCTION real at_least(double a, real b) { return (real)_mm512_max_pd((__m512d)all_real(a), (__m512d)b); }
FUNCTION real at_most(double a, real b) { return (real)_mm512_min_pd((__m512d)all_real(a), (__m512d)b); }
#else
FUNCTION real at_least(double a, real b) { return select_real(lt_real(b, all_real(a)), all_real(a), b); }
FUNCTION real at_most(double a, real b) { return select_real(gt_real(b, all_real(a)), all_real(a), b); }
#endif
FUNCTION real abs_real(real x) { return (real)((integer)x & INT64_MAX); }
FUNCTION real sign_real(real x)
{
    const real one = (real)(((integer)x & INT64_MIN) | (integer)all_real(1.0));
    return select_real(gt_real(abs_real(x), all_real(0.0)), one, x);
}
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
FUNCTION mask finite_real(real x) { return lt_real(abs_real(x), all_real(INFINITY)); }
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
/* result = function(x) in some lanes */
#define WHERE(some, result, function, x)                                                          \
    if (any(some)) { EACH if (lane_of(some, lane)) { result[lane] = function(x[lane]); } }

#include "functions.h"

/* function of a group of runs, and that of all groups */
#define PROGRAM                                                                                   \
    static void fly(const uint64_t *shared, const uint64_t *own, uint64_t *made, uint64_t *every, \
        uint64_t *asked)
#define ALL_RUNS(own_words, made_words, every_words, asked_words)                                 \
    int lanes(void) { return LANES; }                                                             \
    void fly_all(int64_t groups, int64_t threads, const uint64_t *shared, const uint64_t *own,    \
        uint64_t *made, uint64_t *every, uint64_t *asked, const int64_t *place)                   \
    {                                                                                             \
        _Pragma("omp parallel for schedule(dynamic, 1) num_threads(threads)")                     \
        for (int64_t group = 0; group < groups; ++group) {                                        \
            const int64_t first = group * LANES;                                                  \
            WITHOUT_SUBNORMALS(fly(shared, own + first * (own_words),                             \
                made + first * (made_words), every + first * (every_words),                       \
                place[group] < 0 ? 0 : asked + place[group] * LANES * (asked_words)))             \
        }                                                                                         \
    }
