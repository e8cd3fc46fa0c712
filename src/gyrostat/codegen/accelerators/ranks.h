/* Values of given ranks in each run, exact: the smallest value that enough values do not exceed, by
   bisection. The bits of a real number that is not negative increase with it. Infinite values do not
   count; a run without others has NaN. `ranks` has the rank, from 1, for each share and each number
   of values; four shares are searched together. */
#define INFINITE UINT64_C(0x7ff0000000000000)
KERNEL void ranked(GLOBAL const uint64_t *values, GLOBAL const int64_t *ranks,
    GLOBAL uint64_t *found, const int64_t runs, const int64_t samples, const int64_t shares)
{
    const int64_t run = WORK_ITEM;
    if (run >= runs) { return; }
    int64_t count = 0;
    uint64_t most = 0;
    for (int64_t sample = 0; sample < samples; ++sample) {
        const uint64_t value = values[sample * runs + run];
        if (value < INFINITE) {
            ++count;
            most = value > most ? value : most;
        }
    }
    for (int64_t first = 0; first < shares; first += 4) {
        int64_t rank[4];
        uint64_t low[4], high[4];
        for (int k = 0; k < 4; ++k) {
            const int64_t share = first + k < shares ? first + k : first;
            rank[k] = ranks[share * (samples + 1) + count];
            low[k] = 0;
            high[k] = most;
        }
        while (low[0] < high[0] || low[1] < high[1] || low[2] < high[2] || low[3] < high[3]) {
            int64_t below[4];
            uint64_t middle[4];
            for (int k = 0; k < 4; ++k) {
                below[k] = 0;
                middle[k] = low[k] + ((high[k] - low[k]) >> 1);
            }
            for (int64_t sample = 0; sample < samples; ++sample) {
                const uint64_t value = values[sample * runs + run];
                for (int k = 0; k < 4; ++k) { below[k] += value <= middle[k]; }
            }
            for (int k = 0; k < 4; ++k) {
                if (below[k] >= rank[k]) { high[k] = middle[k]; }
                else { low[k] = middle[k] + 1; }
            }
        }
        for (int k = 0; k < 4 && first + k < shares; ++k) {
            found[(first + k) * runs + run] = count > 0 ? low[k] : UINT64_C(0x7ff8000000000000);
        }
    }
}
