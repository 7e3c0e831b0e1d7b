/* Access to our replacement of the vendor's library: loaded by its file name at run time, on Linux and
 * on Windows, or linked, with LINKED.
 *
 * FAMILY is 1, 2 or 3. The family's own DobotDll.h declares the functions.
 */
#ifndef LIBRARY_H
#define LIBRARY_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <DobotDll.h>

#ifdef _WIN32
#include <windows.h>
typedef HMODULE library;
#define nap(ms) Sleep(ms)
#else
#include <dlfcn.h>
#include <unistd.h>
typedef void *library;
#define nap(ms) usleep((ms) * 1000)
#endif

/* First arguments of a function: no id, the arm's ids, or the arm's id without the slave's. */
#if FAMILY == 1
#define ARM(who)
#define ONLY(who)
#define ONLY_MASTER(who)
#define MASTER(who)
#elif FAMILY == 2
#define ARM(who) (who),
#define MASTER(who) (who),
#define ONLY(who) (who)
#define ONLY_MASTER(who) (who)
#else
#define ARM(who) (who), 0,
#define MASTER(who) (who),
#define ONLY(who) (who), 0
#define ONLY_MASTER(who) (who)
#endif

static inline library open_library(const char *file) {
#ifdef _WIN32
    library opened = LoadLibraryA(file);
    if (!opened) {
        fprintf(stderr, "%s: error %lu\n", file, GetLastError());
        exit(9);
    }
#else
    library opened = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    if (!opened) {
        fprintf(stderr, "%s\n", dlerror());
        exit(9);
    }
#endif
    return opened;
}

static inline void *symbol(library from, const char *name) {
#ifdef _WIN32
    void *found = (void *)(uintptr_t)GetProcAddress(from, name);
#else
    void *found = dlsym(from, name);
#endif
    if (!found) {
        fprintf(stderr, "there is no %s\n", name);
        exit(9);
    }
    return found;
}

/* Function with that name, with the type declared in the header. */
#ifdef LINKED
#define OF(from, name) ((void)(from), &name)
#else
#define OF(from, name) ((__typeof__(&name))(uintptr_t)symbol(from, #name))
#endif

/* Connects and stores the arm's id in `who`. Returns the result of ConnectDobot. */
static inline int connect_arm(library from, const char *port, int *who) {
    *who = 0;
#if FAMILY == 3
    ConnectInfo *told = calloc(1, sizeof *told);
    int code = OF(from, ConnectDobot)(port, 115200, told);
    memcpy(who, told, sizeof *who);
    free(told);
    return code;
#else
    char *firmware = malloc(64), *version = malloc(64);
#if FAMILY == 1
    int code = OF(from, ConnectDobot)(port, 115200, firmware, version);
#else
    int code = OF(from, ConnectDobot)(port, 115200, firmware, version, who);
#endif
    free(firmware);
    free(version);
    return code;
#endif
}

#endif
