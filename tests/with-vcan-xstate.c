/* Lets User-Mode Linux (6.1) run on processors whose register state is larger than the one it was built for.
 *
 * Its buffer for extended registers has a fixed size; Linux takes a register set whole or not at all. On a processor
 * with AMX the set is 11,008 bytes long, the kernel refuses what User-Mode Linux gives back, and it panics before its
 * first program. Loaded before it (LD_PRELOAD; see tests/with-vcan), this hands it the front of the set that it knows,
 * and completes what it gives back with what the process has already. AMX itself stays unused inside. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <elf.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/uio.h>

typedef long ptrace_call(int request, pid_t pid, void *addr, void *data);

long ptrace(enum __ptrace_request request, ...) {
    static ptrace_call *call;
    static _Thread_local char whole[65536];
    va_list rest;
    va_start(rest, request);
    pid_t pid = va_arg(rest, pid_t);
    void *addr = va_arg(rest, void *);
    void *data = va_arg(rest, void *);
    va_end(rest);
    if (call == NULL) {
        call = (ptrace_call *)dlsym(RTLD_NEXT, "ptrace");
    }
    int gets = request == PTRACE_GETREGSET, sets = request == PTRACE_SETREGSET;
    if ((!gets && !sets) || (unsigned long)addr != NT_X86_XSTATE) {
        return call(request, pid, addr, data);
    }
    struct iovec *part = data;
    struct iovec all = {.iov_base = whole, .iov_len = sizeof whole};
    long failed = call(PTRACE_GETREGSET, pid, addr, &all);
    if (failed) {
        return failed;
    }
    size_t known = part->iov_len < all.iov_len ? part->iov_len : all.iov_len;
    if (gets) {
        memcpy(part->iov_base, whole, known);
        part->iov_len = known;
        return 0;
    }
    memcpy(whole, part->iov_base, known);
    return call(PTRACE_SETREGSET, pid, addr, &all);
}
