/* Start of a program on a Cortex-M with FPU, with semihosting of newlib (librdimon). */
#include <stdint.h>
#include <stdlib.h>

extern uint32_t stack_top[], data_source[], data_begin[], data_end[], bss_begin[], bss_end[];
extern void initialise_monitor_handles(void);
extern void report_counts(void);
extern int main(int arguments, char **argument);

void reset(void);
void fault(void);
void _fini(void);

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    (void (*)(void))stack_top, reset, fault, fault, fault, fault, fault,
};

void reset(void)
{
    static char *argument[] = {"board", NULL};
    const uint32_t *from = data_source;
    *(volatile uint32_t *)0xE000ED88u |= 0xF00000u; /* CPACR: the FPU may be used */
    __asm volatile("dsb\n\tisb" ::: "memory");
    for (uint32_t *to = data_begin; to < data_end; ++to) { *to = *from++; }
    for (uint32_t *to = bss_begin; to < bss_end; ++to) { *to = 0u; }
    initialise_monitor_handles();
    const int status = main(1, argument);
    report_counts();
    exit(status);
}

void fault(void) { exit(3); }

void _fini(void) {} /* of the C library's exit */
