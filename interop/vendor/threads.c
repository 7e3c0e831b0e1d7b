/* Runs many threads on one library: threads LIBRARY [planted]
 *
 * For helgrind, memcheck and the thread sanitizer. Some threads call, some fill the queue, one
 * connects and disconnects, one changes the timeout, and families with ids have a second arm. Checked:
 * every call returns one of the interface's codes, results are not torn, and a result written for one
 * thread never reaches another. With `planted`, two threads also increment a counter without a lock,
 * which the tool must report.
 */
#include "library.h"

#include <pthread.h>

#ifndef ROUNDS
#define ROUNDS 40
#endif

static library from;
static int arms[2];
static int planted;
static int done; /* Protected by the lock, except in the planted fault. */
static int wrong;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static void note(bool good) {
    pthread_mutex_lock(&lock);
    wrong += !good;
    done += 1;
    pthread_mutex_unlock(&lock);
    if (planted) {
        done += 1;
    }
}

/* A call in flight when its arm is disconnected returns 0 and writes no result, as with the vendor's
 * library. In families with ids no thread disconnects the arm of another here. */
static bool taken_away(void) {
    return FAMILY == 1;
}

/* Reads repeatedly. An answer is a complete pose; without an answer nothing may be written. */
static void *reads(void *of) {
    int who = arms[(intptr_t)of % 2];
    (void)who;
    for (int round = 0; round < ROUNDS; round++) {
        Pose *pose = malloc(sizeof *pose);
        memset(pose, 0xA5, sizeof *pose);
        float untouched;
        memset(&untouched, 0xA5, sizeof untouched);
        int code = OF(from, GetPose)(ARM(who) pose);
        float x, last;
        memcpy(&x, pose, sizeof x);
        memcpy(&last, (char *)pose + 28, sizeof last);
        bool written = memcmp(&x, &untouched, sizeof x) != 0;
        note(code == 0 ? written ? x == x && last == last : taken_away() : !written && code <= 4);
        free(pose);
    }
    return NULL;
}

/* Queues commands. The indices of one thread increase. */
static void *queues(void *of) {
    int who = arms[(intptr_t)of % 2];
    uint64_t last = 0;
    (void)who;
    for (int round = 0; round < ROUNDS; round++) {
        WAITCmd *wait = malloc(sizeof *wait);
        memset(wait, 0, sizeof *wait);
        uint64_t *index = calloc(1, sizeof *index);
        int code = OF(from, SetWAITCmd)(ARM(who) wait, true, index);
        note(code == 0 && *index ? *index > last : *index == 0 && (code != 0 || taken_away()) && code <= 4);
        last = *index > last ? *index : last;
        free(wait);
        free(index);
    }
    return NULL;
}

/* Settings that a program may change meanwhile. */
static void *changes(void *unused) {
    (void)unused;
    for (int round = 0; round < ROUNDS; round++) {
        note(OF(from, SetCmdTimeout)(MASTER(arms[0]) 500 + round) == 0);
        char *text = malloc(40);
        int length = OF(from, MagicianLastError)(text, 40);
        note(length >= 0);
        free(text);
    }
    return NULL;
}

/* Connects and disconnects: with ids a third arm, without ids the one that all threads use. */
static void *comes_and_goes(void *unused) {
    (void)unused;
    for (int round = 0; round < ROUNDS / 8; round++) {
#if FAMILY == 1
        note(OF(from, DisconnectDobot)() == 0);
        int who;
        note(connect_arm(from, "sim", &who) == 0);
#else
        int who = -1;
        Pose pose;
        note(connect_arm(from, "sim", &who) == 0 && who != arms[0] && who != arms[1]);
        note(OF(from, GetPose)(ARM(who) &pose) == 0);
        note(OF(from, DisconnectDobot)(ONLY_MASTER(who)) == 0);
#endif
    }
    return NULL;
}

int main(int count, char **words) {
    if (count < 2) {
        fprintf(stderr, "threads LIBRARY [planted]\n");
        return 2;
    }
    planted = count > 2;
    from = open_library(words[1]);
    bool connected = connect_arm(from, "sim", &arms[0]) == 0;
#if FAMILY != 1
    connected = connected && connect_arm(from, "sim", &arms[1]) == 0 && arms[1] != arms[0];
#endif
    if (!connected) {
        fprintf(stderr, "no connection\n");
        return 1;
    }
    pthread_t threads[8];
    void *(*work[])(void *) = {reads, reads, reads, reads, queues, queues, changes, comes_and_goes};
    for (intptr_t at = 0; at < 8; at++) {
        if (pthread_create(&threads[at], NULL, work[at], (void *)at) != 0) {
            return 1;
        }
    }
    for (int at = 0; at < 8; at++) {
        pthread_join(threads[at], NULL);
    }
    bool left = OF(from, DisconnectDobot)(ONLY_MASTER(arms[0])) == 0;
#if FAMILY != 1
    left = OF(from, DisconnectDobot)(ONLY_MASTER(arms[1])) == 0 && left;
#endif
    printf("%d calls, %d wrong\n", done, wrong);
    return wrong || !left ? 1 : 0;
}
