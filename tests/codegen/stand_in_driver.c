/* Stand-in for the driver of CUDA: the memory of a device is that of this process, a module is the path
   of a shared library, and the work items of a kernel run one after the other. */
#include <dlfcn.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DEVICE = 7, KERNELS = 64 };
enum { THRESHOLD = 4, THREADS = 39, MAJOR = 75 };
typedef void program(const void *, uint64_t, uint64_t, uint64_t, uint64_t, uint64_t, int64_t, int64_t,
    int64_t);
typedef void ranks(uint64_t, uint64_t, uint64_t, int64_t, int64_t, int64_t);
static struct {
    void *function;
    int64_t *item;
    int is_program;
} kernels[KERNELS];
static int context, count;
static int64_t allocated;

int64_t left(void) { return allocated; }

int cuInit(unsigned flags) { return flags != 0; }
int cuDeviceGetCount(int *devices) { *devices = 1; return 0; }
int cuDeviceGet(int *device, int ordinal) { *device = DEVICE; return ordinal; }
int cuDevicePrimaryCtxRetain(void **made, int device) { *made = &context; return device != DEVICE; }
int cuCtxSetCurrent(void *made) { return made != &context; }
int cuDriverGetVersion(int *version) { *version = 13000; return 0; }
int cuDeviceGetName(char *name, int size, int device)
{
    snprintf(name, size, "stand-in");
    return device != DEVICE;
}
int cuDeviceGetAttribute(int *value, int number, int device)
{
    *value = number == MAJOR ? 9 : number == THREADS ? 2048 : 0;
    return device != DEVICE;
}
int cuDeviceGetDefaultMemPool(void **pool, int device) { *pool = &context; return device != DEVICE; }
int cuMemPoolSetAttribute(void *pool, int number, const uint64_t *value)
{
    return pool != &context || number != THRESHOLD || *value != UINT64_MAX;
}
int cuGetErrorString(int code, const char **text)
{
    *text = code == 1 ? "invalid argument" : NULL;
    return 0;
}

int cuModuleLoadData(void **module, const char *path) { return !(*module = dlopen(path, RTLD_NOW)); }
int cuModuleGetFunction(void **function, void *module, const char *name)
{
    *function = dlsym(module, name);
    kernels[count].function = *function;
    kernels[count].item = dlsym(module, "work_item");
    kernels[count].is_program = !strcmp(name, "fly_all");
    return !*function || !kernels[count].item || ++count == KERNELS;
}
int cuFuncGetAttribute(int *value, int number, void *function) { *value = 10 * number; return !function; }
int cuOccupancyMaxActiveBlocksPerMultiprocessor(int *groups, void *function, int size, size_t bytes)
{
    *groups = 512 / size;
    return !function || bytes;
}

int cuStreamCreate(void **stream, unsigned flags) { return !(*stream = malloc(1)) || flags != 1; }
int cuStreamDestroy_v2(void *stream) { free(stream); return 0; }
int cuStreamSynchronize(void *stream) { return !stream; }
int cuMemAllocAsync(uint64_t *address, size_t bytes, void *stream)
{
    *address = (uint64_t)(uintptr_t)malloc(bytes);
    ++allocated;
    return !stream;
}
int cuMemFreeAsync(uint64_t address, void *stream)
{
    free((void *)(uintptr_t)address);
    --allocated;
    return !stream;
}
static int copied(uint64_t to, uint64_t from, size_t bytes, void *stream)
{
    memcpy((void *)(uintptr_t)to, (void *)(uintptr_t)from, bytes);
    return !stream;
}
int cuMemcpyHtoDAsync_v2(uint64_t to, uint64_t from, size_t n, void *s) { return copied(to, from, n, s); }
int cuMemcpyDtoHAsync_v2(uint64_t to, uint64_t from, size_t n, void *s) { return copied(to, from, n, s); }
int cuMemcpyDtoDAsync_v2(uint64_t to, uint64_t from, size_t n, void *s) { return copied(to, from, n, s); }

#define WORD(k) (*(uint64_t *)p[k])
#define NUMBER(k) (*(int64_t *)p[k])
int cuLaunchKernel(void *function, unsigned x, unsigned y, unsigned z, unsigned group, unsigned u,
    unsigned v, unsigned bytes, void *stream, void **p, void **extra)
{
    int k = 0;
    while (k < count && kernels[k].function != function) { ++k; }
    if (k == count || y != 1 || z != 1 || u != 1 || v != 1 || bytes || !stream || extra) { return 1; }
    for (*kernels[k].item = 0; *kernels[k].item < (int64_t)x * group; ++*kernels[k].item) {
        if (kernels[k].is_program) {
            ((program *)function)(
                p[0], WORD(1), WORD(2), WORD(3), WORD(4), WORD(5), NUMBER(6), NUMBER(7), NUMBER(8));
        } else {
            ((ranks *)function)(WORD(0), WORD(1), WORD(2), NUMBER(3), NUMBER(4), NUMBER(5));
        }
    }
    return 0;
}
