/* Loads and unloads libraries in one process: reload LIBRARY COPY
 *
 * COPY is the same library under another file name: programs with several arms load such copies.
 * Linux only.
 */
#include "library.h"

#include <dirent.h>
#include <sys/wait.h>
#include <time.h>

static int passed, failed;

static void check(const char *what, bool kept) {
    printf("  %s %s\n", kept ? "ok  " : "FAIL", what);
    fflush(stdout);
    passed += kept;
    failed += !kept;
}

/* Number of entries in a folder of /proc: threads or open files. */
static int entries(const char *path) {
    DIR *folder = opendir(path);
    int count = 0;
    while (folder && readdir(folder)) {
        count++;
    }
    closedir(folder);
    return count;
}

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec / 1e9;
}

static bool answers(library from, int who) {
    (void)who;
    Pose pose;
    return OF(from, GetPose)(ARM(who) &pose) == 0;
}

/* Load, connect, use, disconnect and unload repeatedly must leak nothing. */
static void again_and_again(const char *file) {
    int threads = 0, files = 0;
    bool good = true;
    for (int round = 0; round < 12; round++) {
        library from = open_library(file);
        int who;
        good = connect_arm(from, "sim", &who) == 0 && answers(from, who) && good;
        good = OF(from, DisconnectDobot)(ONLY_MASTER(who)) == 0 && good;
        good = dlclose(from) == 0 && good;
        if (round == 1) {
            threads = entries("/proc/self/task");
            files = entries("/proc/self/fd");
        }
    }
    check("loaded, connected, used, disconnected, unloaded: 12 times", good);
    /* The kernel may list a joined thread for a moment. */
    for (int tries = 0; tries < 6000 && entries("/proc/self/task") > threads; tries++) {
        nap(10);
    }
    check("no thread is left over", entries("/proc/self/task") == threads);
    check("no open file is left over", entries("/proc/self/fd") == files);
}

/* Unloaded with an arm connected: its threads continue, so their code must remain mapped. */
static void unloaded_too_early(const char *file) {
    library from = open_library(file);
    int who;
    bool connected = connect_arm(from, "sim", &who) == 0;
    dlclose(from);
    nap(100);
    check("unloaded with an arm connected: the process lives", connected);
    from = open_library(file);
    check("loaded again, it connects again", connect_arm(from, "sim", &who) == 0 && answers(from, who));
    OF(from, DisconnectDobot)(ONLY_MASTER(who));
    dlclose(from);
}

/* A copy in another file is a separate library with its own arm. */
static void two_copies(const char *file, const char *copy) {
    library one = open_library(file), two = open_library(copy);
    int first, second;
    char name[64] = "", other[64] = "";
    check("two copies are two libraries", one != two && symbol(one, "GetPose") != symbol(two, "GetPose"));
    check("each connects", connect_arm(one, "sim", &first) == 0 && connect_arm(two, "sim", &second) == 0);
    OF(one, SetDeviceName)(ARM(first) "first");
    OF(two, SetDeviceName)(ARM(second) "second");
    OF(one, GetDeviceName)(ARM(first) name, sizeof name);
    OF(two, GetDeviceName)(ARM(second) other, sizeof other);
    check("to an arm of its own", strcmp(name, "first") == 0 && strcmp(other, "second") == 0);
    OF(one, DisconnectDobot)(ONLY_MASTER(first));
    check("one disconnects, the other stays", !answers(one, first) && answers(two, second));
    OF(two, DisconnectDobot)(ONLY_MASTER(second));
    dlclose(one);
    dlclose(two);
}

/* A child forked from a connected parent has no arm, and its calls must return. */
static void forked(const char *file) {
    library from = open_library(file);
    int who;
    bool connected = connect_arm(from, "sim", &who) == 0 && answers(from, who);
    pid_t child = fork();
    if (child == 0) {
        alarm(120);
        double began = seconds();
        /* Timeout for an arm that does not answer: 3 s. */
        bool refused = !answers(from, who) && seconds() - began < 2.9;
        bool left = OF(from, DisconnectDobot)(ONLY_MASTER(who)) == 0;
        /* Runs the exit handlers of the process. */
        exit(refused && left ? 0 : 1);
    }
    int status = -1;
    waitpid(child, &status, 0);
    check("a forked child is refused at once, and ends", connected && status == 0);
    check("its parent goes on", answers(from, who));
    OF(from, DisconnectDobot)(ONLY_MASTER(who));
    dlclose(from);
}

/* A child that connects to an arm of its own, forked from a parent that was not connected. */
static void forked_before(const char *file) {
    library from = open_library(file);
    pid_t child = fork();
    if (child == 0) {
        alarm(120);
        int who;
        exit(connect_arm(from, "sim", &who) == 0 && answers(from, who) ? 0 : 1);
    }
    int status = -1;
    waitpid(child, &status, 0);
    check("a child that was forked before may connect, and ends connected", status == 0);
    dlclose(from);
}

int main(int count, char **words) {
    if (count != 3) {
        fprintf(stderr, "reload LIBRARY COPY\n");
        return 2;
    }
    forked_before(words[1]);
    again_and_again(words[1]);
    unloaded_too_early(words[1]);
    two_copies(words[1], words[2]);
    forked(words[1]);
    /* The process ends with an arm connected. */
    library from = open_library(words[1]);
    int who;
    check("connected to the end", connect_arm(from, "sim", &who) == 0);
    printf("%d passed, %d failed\n", passed, failed);
    return failed ? 1 : 0;
}
