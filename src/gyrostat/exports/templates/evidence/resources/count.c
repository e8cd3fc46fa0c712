/* Counts the instructions and the stack of each call of some functions. The linker puts the functions
   __wrap_... in the place of those that another file calls (ld --wrap). An instruction takes 512 ns
   (qemu -icount 9), which are 12.8 ticks of the timer of the board. */
@include@
#include <stdint.h>
#include <stdio.h>

#define TIMER ((volatile uint32_t *)0x40000000u) /* of the boards MPS2: control, value, reload */
#ifndef PAINTED
#define PAINTED 8192 /* words of the stack */
#endif
#define PAINT 0xA5C3F096u

typedef struct {
    const char *name;
    void (*call)(void);
    uint32_t instructions, stack;
} Count;

void report_counts(void);

static int status;

/* One instruction: it returns. */
__attribute__((noinline)) static void nothing(void) { __asm volatile(""); }

__attribute__((always_inline)) static inline uint32_t ticks(void (*call)(void))
{
    const uint32_t begin = TIMER[1];
    call();
    return begin - TIMER[1];
}

static void count(Count *entry)
{
    volatile uint32_t *stack;
    uint32_t instructions, depth = PAINTED;
    __asm volatile("mov %0, sp" : "=r"(stack));
    TIMER[2] = UINT32_MAX;
    TIMER[0] = 1u;
    instructions = ticks(nothing);
    for (uint32_t *word = (uint32_t *)stack - PAINTED; word < stack; ++word) { *word = PAINT; }
    instructions = 1u + (uint32_t)((5u * (uint64_t)(ticks(entry->call) - instructions) + 32u) / 64u);
    while ((depth > 0u) && (*(stack - depth) == PAINT)) { --depth; }
    if (instructions > entry->instructions) { entry->instructions = instructions; }
    if (4u * depth > entry->stack) { entry->stack = 4u * depth; }
}

@calls@

void report_counts(void)
{
    const Count *const every[] = {@every@};
    for (unsigned k = 0u; k < sizeof every / sizeof *every; ++k) {
        printf("count\t%s\t%lu\t%lu\n", every[k]->name, (unsigned long)every[k]->instructions,
            (unsigned long)every[k]->stack);
    }
}
