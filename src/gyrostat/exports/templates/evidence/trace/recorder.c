/* Notes in which steps the groups of statements of traced.c are executed. At the end of the program
   each group is a line of the file that TRACE names: its first step, the number of its steps. */
#include <stdio.h>
#include <stdlib.h>

#define GROUPS @count@

void trace_step(void);
void trace_reached(int group);

static long step;
static long first[GROUPS], last[GROUPS], steps[GROUPS];

static void report(void)
{
    const char *const name = getenv("TRACE");
    FILE *const file = (name == NULL) ? NULL : fopen(name, "w");
    if (file == NULL) { return; }
    for (int k = 0; k < GROUPS; ++k) { fprintf(file, "%ld\t%ld\n", first[k], steps[k]); }
    (void)fclose(file);
}

void trace_step(void)
{
    if (step == 0) { (void)atexit(report); }
    ++step;
}

void trace_reached(int group)
{
    if (steps[group] == 0) { first[group] = step; }
    if ((steps[group] == 0) || (last[group] != step)) { ++steps[group]; }
    last[group] = step;
}
