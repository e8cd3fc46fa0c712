/* Operations for programs with one run in each work item of an accelerator: OpenCL C, CUDA C++, or C
   whose caller counts `work_item`. They are those of `lanes.h` for a single lane.

   Words of the inputs and results lie one run beside the other, so that neighbouring work items read
   and write neighbouring words. */
#ifdef __OPENCL_VERSION__
#pragma OPENCL FP_CONTRACT OFF
#define FUNCTION static inline __attribute__((always_inline))
#define LONG_FUNCTION static
#define MIDDLE_FUNCTION FUNCTION
#define GLOBAL __global
#define TABLE __constant const
#define TABLE_OF(type) __constant const type *
#define KERNEL __kernel
#define WORK_ITEM get_global_id(0)
typedef long int64_t;
typedef ulong uint64_t;
typedef int int32_t;
typedef uint uint32_t;
#define INT64_C(x) x##L
#define UINT64_C(x) x##UL
FUNCTION double one_as_real(uint64_t x) { return as_double(x); }
FUNCTION int64_t one_as_integer(double x) { return as_long(x); }
#elif defined(__CUDACC__)
#define FUNCTION static __device__ __forceinline__
#define LONG_FUNCTION static __device__ __noinline__
#define MIDDLE_FUNCTION LONG_FUNCTION
#define GLOBAL
#define TABLE static __device__ const
#define TABLE_OF(type) const type *
#define KERNEL extern "C" __global__ __launch_bounds__(WORK_GROUP)
#define WORK_ITEM (int64_t)blockIdx.x * blockDim.x + threadIdx.x
#ifdef __CUDACC_RTC__
typedef long long int64_t;
typedef unsigned long long uint64_t;
typedef int int32_t;
typedef unsigned uint32_t;
#define INT64_C(x) x##LL
#define UINT64_C(x) x##ULL
#define INFINITY __builtin_bit_cast(double, 0x7ff0000000000000)
#define NAN __builtin_bit_cast(double, 0x7ff8000000000000)
#else
#include <math.h>
#include <stdint.h>
#endif
FUNCTION double one_as_real(uint64_t x) { return __longlong_as_double((int64_t)x); }
FUNCTION int64_t one_as_integer(double x) { return __double_as_longlong(x); }
#else
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#define FUNCTION static inline __attribute__((unused))
#define LONG_FUNCTION static __attribute__((unused))
#define MIDDLE_FUNCTION FUNCTION
#define KERNEL
#define WORK_ITEM work_item
int64_t work_item;
#define GLOBAL
#define TABLE static const
#define TABLE_OF(type) const type *
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
#endif
#undef INT64_MIN
#undef INT64_MAX
#undef UINT64_MAX
#define INT64_MAX INT64_C(0x7fffffffffffffff)
#define INT64_MIN (-INT64_MAX - 1)
#define UINT64_MAX UINT64_C(0xffffffffffffffff)
#include "numbers.h"

#define LANES 1
#define ALL(x) x
#define SELDOM(test) test
#define any(m) (m)
#define SHARES TABLE double
#define WHERE(some, result, function, x)                                                          \
    if (some) { result = function(x); }
typedef double real;
typedef int64_t integer;
typedef uint64_t bits;
typedef uint32_t words;
typedef bool mask;

FUNCTION real as_real(integer x) { return one_as_real((uint64_t)x); }
FUNCTION integer as_integer(real x) { return one_as_integer(x); }
FUNCTION real all_real(double x) { return x; }
FUNCTION integer all_integer(int64_t x) { return x; }
FUNCTION bits all_bits(uint64_t x) { return x; }
FUNCTION mask all_mask(bool x) { return x; }
FUNCTION double one_of_real(real x) { return x; }
FUNCTION uint64_t one_of_bits(bits x) { return x; }
FUNCTION words words_of_bits(bits x) { return (words)x; }
FUNCTION bits bits_of_words(words x) { return x; }

#define COMPARED(name, sign)                                                                      \
    FUNCTION mask name##_real(real a, real b) { return a sign b; }                                \
    FUNCTION mask name##_integer(integer a, integer b) { return a sign b; }                       \
    FUNCTION mask name##_bits(bits a, bits b) { return a sign b; }
COMPARED(lt, <)
COMPARED(le, <=)
COMPARED(gt, >)
COMPARED(ge, >=)
COMPARED(eq, ==)
COMPARED(ne, !=)
FUNCTION mask not_mask(mask m) { return !m; }
FUNCTION mask and_mask(mask a, mask b) { return a && b; }
FUNCTION mask or_mask(mask a, mask b) { return a || b; }
FUNCTION mask xor_mask(mask a, mask b) { return a != b; }
FUNCTION real select_real(mask m, real yes, real no) { return m ? yes : no; }
FUNCTION integer select_integer(mask m, integer yes, integer no) { return m ? yes : no; }
FUNCTION bits select_bits(mask m, bits yes, bits no) { return m ? yes : no; }

FUNCTION real real_of_integer(integer x) { return (real)x; }
FUNCTION real real_of_bits(bits x) { return (real)x; }
FUNCTION integer integer_of_real(real x) { return one_integer_of_real(x); }
FUNCTION bits bits_of_real(real x) { return one_bits_of_real(x); }
FUNCTION integer quotient_integer(integer a, integer b) { return one_quotient_integer(a, b); }
FUNCTION integer remainder_integer(integer a, integer b) { return one_remainder_integer(a, b); }
FUNCTION bits quotient_bits(bits a, bits b) { return one_quotient_bits(a, b); }
FUNCTION bits remainder_bits(bits a, bits b) { return one_remainder_bits(a, b); }

FUNCTION real at_least(double a, real b) { return b < a ? a : b; }
FUNCTION real at_most(double a, real b) { return b > a ? a : b; }
FUNCTION real abs_real(real x) { return fabs(x); }
FUNCTION real sign_real(real x) { return one_sign_real(x); }
FUNCTION real sqrt_real(real x) { return sqrt(x); }
FUNCTION mask finite_real(real x) { return fabs(x) < INFINITY; }
FUNCTION real floor_real(real x) { return floor(x); }
FUNCTION real ceil_real(real x) { return ceil(x); }
FUNCTION real rint_real(real x) { return rint(x); }
#define LANE_BY_LANE(name) LONG_FUNCTION real name##_real(real x) { return name(x); }
#define LANE_BY_LANE_2(name)                                                                      \
    LONG_FUNCTION real name##_real(real x, real y) { return name(x, y); }

/* Memory of the inputs and results, from the first word of this run on. In CUDA, what all runs share
   is an argument of SHARED_WORDS words if it is small: operands without a register. */
#if defined(__CUDACC__) && defined(SHARED_WORDS)
struct Shared {
    uint64_t words[SHARED_WORDS];
};
#define SHARED(index) shared.words[index]
#define SHARED_ARGUMENT const __grid_constant__ Shared shared
#define SHARED_MEMORY const Shared &shared
#else
#define SHARED(index) shared[index]
#define SHARED_ARGUMENT GLOBAL const uint64_t *shared
#define SHARED_MEMORY SHARED_ARGUMENT
#endif
FUNCTION uint64_t word_of_real(real x) { return (uint64_t)as_integer(x); }
FUNCTION uint64_t word_of_integer(integer x) { return (uint64_t)x; }
FUNCTION uint64_t word_of_bits(bits x) { return x; }
FUNCTION real real_of_word(uint64_t x) { return one_as_real(x); }
FUNCTION integer integer_of_word(uint64_t x) { return (integer)x; }
FUNCTION bits bits_of_word(uint64_t x) { return x; }
#define OWN(kind, index) kind##_of_word(own[(index) * runs])
#define PUT(kind, memory, index, value) memory[(index) * runs_in_##memory] = word_of_##kind(value)
#define runs_in_made runs
#define runs_in_every runs
#define runs_in_asked kept

/* tables in memory, and those of a run, at an index that differs between runs */
#define shared_words(memory, first, index) SHARED((first) + (index))
#define own_words(memory, first, index) own[((first) + (index)) * runs]
#define shared_real(table, index) (table)[index]
#define shared_integer(table, index) (table)[index]
#define shared_bits(table, index) (table)[index]
#define shared_mask(table, index) (table)[index]
#define own_real(table, index) (table)[index]
#define own_integer(table, index) (table)[index]
#define own_bits(table, index) (table)[index]
#define own_mask(table, index) (table)[index]
#define SET(table, index, value, active)                                                          \
    if (active) { (table)[index] = value; }
#define set_real SET
#define set_integer SET
#define set_bits SET
#define set_mask SET

#include "functions.h"

/* A program is larger than the memory of a processor for instructions. In CUDA, the runs of a work group
   therefore begin each pass of an outer loop together, so that they share what is fetched; a work item
   without a run repeats the last one. Numbers that all runs compute alike are in the memory of the work
   group, where the compiler also puts some of what the registers cannot hold. */
#ifdef __CUDACC__
#define ALIGN __syncthreads()
#define COMMON(type, name, value)                                                                 \
    __shared__ type name;                                                                         \
    name = value
#define OWN_RUN(item) ((item) < runs ? (item) : runs - 1)
#define IS_RUN(item) true
#if __CUDACC_VER_MAJOR__ >= 13
#define SPILLING asm volatile(".pragma \"enable_smem_spilling\";")
#else
#define SPILLING
#endif
#else
#define ALIGN
#define COMMON(type, name, value) const type name = value
#define OWN_RUN(item) (item)
#define IS_RUN(item) ((item) < runs)
#define SPILLING
#endif

/* Function of one run, and that of all runs. The words of `own` begin with word `first`. RECORDS says
   whether rows on demand are written, for the runs with a `place` of 0 or above among the `kept`. */
#define MEMORY                                                                                    \
    GLOBAL const uint64_t *own, GLOBAL uint64_t *made, GLOBAL uint64_t *every,                    \
        GLOBAL uint64_t *asked
#define PROGRAM FUNCTION void fly(SHARED_MEMORY, MEMORY, const int64_t runs, const int64_t kept)
#define ARGUMENTS                                                                                 \
    SHARED_ARGUMENT, MEMORY, GLOBAL const int64_t *place, const int64_t runs, const int64_t kept, \
        const int64_t first
#define ONE_RUN                                                                                   \
    fly(shared, own + first * runs + run, made + run, every + run,                                \
        RECORDS && place[run] >= 0 ? asked + place[run] : 0, runs, kept)
#define ALL_RUNS(own_words, made_words, every_words, asked_words)                                 \
    KERNEL void fly_all(ARGUMENTS)                                                                \
    {                                                                                             \
        SPILLING;                                                                                 \
        const int64_t item = WORK_ITEM, run = OWN_RUN(item);                                      \
        if (IS_RUN(item)) { ONE_RUN; }                                                            \
    }
