/* A driver without a GPU: it keeps arrays in memory of the host, counts what is started, and runs nothing. STUB_COUNTS names a file for the counts. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef unsigned long long address;
enum { OK = 0, OUT_OF_MEMORY = 2, INVALID = 1, INVALID_IMAGE = 200, NOT_FOUND = 500 };
#define TOTAL ((size_t)64 << 30)

static long launches, modules, copies, events;

static void save(void)
{
    const char *name = getenv("STUB_COUNTS");
    FILE *file = name ? fopen(name, "w") : NULL;
    if (!file) return;
    fprintf(file, "launches %ld\nmodules %ld\ncopies %ld\nevents %ld\n", launches, modules, copies, events);
    fclose(file);
}

int cuInit(unsigned flags) { (void)flags; atexit(save); return OK; }
int cuDriverGetVersion(int *version) { *version = 12000; return OK; }
int cuDeviceGetCount(int *count) { *count = 1; return OK; }
int cuDeviceGet(int *device, int ordinal) { *device = ordinal; return ordinal ? INVALID : OK; }
int cuDeviceGetName(char *name, int length, int device) { (void)device; snprintf(name, (size_t)length, "a stub without a GPU"); return OK; }

/* Compute capability 9.0, no pools of memory. */
int cuDeviceGetAttribute(int *value, int attribute, int device)
{
    (void)device;
    *value = attribute == 75 ? 9 : 0;
    return OK;
}

static int current;
int cuDevicePrimaryCtxRetain(void **context, int device) { (void)device; *context = &current; return OK; }
int cuDevicePrimaryCtxRelease_v2(int device) { (void)device; return OK; }
int cuCtxGetCurrent(void **context) { *context = &current; return OK; }
int cuCtxSetCurrent(void *context) { (void)context; return OK; }
int cuCtxSynchronize(void) { return OK; }

int cuStreamCreate(void **stream, unsigned flags) { (void)flags; *stream = malloc(1); return OK; }
int cuStreamCreateWithPriority(void **stream, unsigned flags, int priority) { (void)priority; return cuStreamCreate(stream, flags); }
int cuStreamDestroy_v2(void *stream) { free(stream); return OK; }
int cuStreamSynchronize(void *stream) { (void)stream; return OK; }
int cuStreamWaitEvent(void *stream, void *event, unsigned flags) { (void)stream; (void)event; (void)flags; return OK; }

int cuEventCreate(void **event, unsigned flags) { (void)flags; ++events; *event = malloc(1); return OK; }
int cuEventDestroy_v2(void *event) { free(event); return OK; }
int cuEventRecord(void *event, void *stream) { (void)event; (void)stream; return OK; }
int cuEventSynchronize(void *event) { (void)event; return OK; }
/* A millisecond for all that is timed: no figure of a run with this driver means anything. */
int cuEventElapsedTime(float *milliseconds, void *start, void *end) { (void)start; (void)end; *milliseconds = 1.0f; return OK; }

static size_t used;
int cuMemGetInfo_v2(size_t *free_bytes, size_t *total) { *free_bytes = TOTAL - used; *total = TOTAL; return OK; }
int cuMemAlloc_v2(address *out, size_t bytes)
{
    size_t *own = bytes < TOTAL / 4 ? malloc(bytes + 64) : NULL;
    if (!own) return OUT_OF_MEMORY;
    own[0] = bytes;
    used += bytes;
    *out = (address)own + 64;
    return OK;
}
int cuMemFree_v2(address at)
{
    size_t *own = (size_t *)(at - 64);
    used -= own[0];
    free(own);
    return OK;
}
int cuMemsetD8_v2(address at, unsigned char byte, size_t bytes) { memset((void *)at, byte, bytes); return OK; }
int cuMemsetD8Async(address at, unsigned char byte, size_t bytes, void *stream) { (void)stream; return cuMemsetD8_v2(at, byte, bytes); }
static int copy(void *to, const void *from, size_t bytes) { ++copies; memcpy(to, from, bytes); return OK; }
int cuMemcpyHtoDAsync_v2(address to, const void *from, size_t bytes, void *stream) { (void)stream; return copy((void *)to, from, bytes); }
int cuMemcpyDtoHAsync_v2(void *to, address from, size_t bytes, void *stream) { (void)stream; return copy(to, (void *)from, bytes); }
int cuMemcpyDtoDAsync_v2(address to, address from, size_t bytes, void *stream) { (void)stream; return copy((void *)to, (void *)from, bytes); }

/* Machine code is an ELF file; nothing else is known of it. */
int cuModuleLoadData(void **module, const void *image)
{
    if (memcmp(image, "\177ELF", 4) != 0) return INVALID_IMAGE;
    ++modules;
    *module = malloc(1);
    return OK;
}
int cuModuleUnload(void *module) { free(module); return OK; }
int cuModuleGetFunction(void **function, void *module, const char *name) { (void)module; *function = strdup(name); return OK; }
int cuLaunchKernel(void *function, unsigned gx, unsigned gy, unsigned gz, unsigned bx, unsigned by, unsigned bz,
    unsigned shared, void *stream, void **arguments, void **extra)
{
    (void)shared; (void)stream; (void)extra;
    if (!function || !arguments || !gx || !gy || !gz || !bx || !by || !bz) return INVALID;
    ++launches;
    return OK;
}
int cuGetErrorName(int error, const char **name) { (void)error; *name = "an error of the stub"; return OK; }
int cuGetErrorString(int error, const char **name) { return cuGetErrorName(error, name); }
