/* Runs one typical session of programs in the field, at any kind of port: session LIBRARY PORT
 *
 * Connects, sets speeds, homes, moves through the queue, reads the pose, fills the stopped queue,
 * sets outputs, disconnects and connects again. Runs on Linux on any processor and on Windows.
 */
#include "library.h"

#include <math.h>

static int passed, failed;

static void check(const char *what, bool kept) {
    printf("  %s %s\n", kept ? "ok  " : "FAIL", what);
    fflush(stdout);
    passed += kept;
    failed += !kept;
}

/* Waits until the arm has finished the command with that index; false after a timeout. */
static bool ended(library from, int who, uint64_t index) {
    (void)who;
    for (int tries = 0; tries < 12000; tries++) {
        uint64_t current = 0;
        if (OF(from, GetQueuedCmdCurrentIndex)(ARM(who) &current) != 0) {
            return false;
        }
        if (current >= index) {
            return true;
        }
        nap(10);
    }
    return false;
}

static bool near_to(const float *got, const float *want, int count) {
    for (int at = 0; at < count; at++) {
        if (!(fabsf(got[at] - want[at]) < 0.01f)) {
            return false;
        }
    }
    return true;
}

static void moves(library from, int who) {
    (void)who;
    uint64_t index = 0, before = 0;
    PTPCommonParams fast = {100, 100};
    HOMEParams at_home = {200, 0, 50, 0};
    HOMECmd home = {0};
    check("the queue is cleared and started",
          OF(from, SetQueuedCmdClear)(ONLY(who)) == 0 && OF(from, SetQueuedCmdStartExec)(ONLY(who)) == 0);
    check("speeds", OF(from, SetPTPCommonParams)(ARM(who) &fast, true, &before) == 0);
    check("home", OF(from, SetHOMEParams)(ARM(who) &at_home, true, NULL) == 0
                      && OF(from, SetHOMECmd)(ARM(who) &home, true, &index) == 0);
    check("indices go up by one", index == before + 2);
    check("homed", ended(from, who, index) && OF(from, ClearAllAlarmsState)(ONLY(who)) == 0);
    const float places[3][4] = {{220, 30, 40, 10}, {180, -60, 80, -20}, {250, 0, 20, 0}};
    for (int at = 0; at < 3; at++) {
        PTPCmd move = {1, places[at][0], places[at][1], places[at][2], places[at][3]};
        Pose pose;
        /* The caller asks for an immediate command. The vendor's library queues it nevertheless, and
         * programs wait for the index. */
        bool moved = OF(from, SetPTPCmd)(ARM(who) &move, false, &index) == 0 && ended(from, who, index);
        bool looked = OF(from, GetPose)(ARM(who) &pose) == 0;
        float got[4];
        memcpy(got, &pose, sizeof got);
        check("moved, and is where it was sent", moved && looked && near_to(got, places[at], 4));
    }
}

/* A stopped queue accepts commands until it is full, then reports that. No call blocks for ever. */
static void fills(library from, int who) {
    (void)who;
    WAITCmd wait = {1};
    uint64_t index = 0, last = 0;
    bool rising = true;
    int code = OF(from, SetQueuedCmdStopExec)(ONLY(who)), taken = 0;
    for (; code == 0 && taken < 1000; taken++) {
        code = OF(from, SetWAITCmd)(ARM(who) &wait, true, &index);
        rising = rising && (code != 0 || last == 0 || index == last + 1);
        last = index;
    }
    check("a full queue is told by 1, and the index is left alone", code == 1 && taken > 8 && rising && index == last);
    check("it runs on", OF(from, SetQueuedCmdStartExec)(ONLY(who)) == 0 && ended(from, who, last));
}

static void outputs(library from, int who) {
    (void)who;
    IOMultiplexing as_output = {4, 1};
    IODO on = {4, 1}, seen = {4, 0};
    uint64_t index = 0;
    check("a pin is an output, and on", OF(from, SetIOMultiplexing)(ARM(who) &as_output, true, NULL) == 0
                                            && OF(from, SetIODO)(ARM(who) &on, true, &index) == 0 && ended(from, who, index));
    check("it is seen", OF(from, GetIODO)(ARM(who) &seen) == 0 && seen.level == 1);
    char name[5], long_name[64];
    check("a name is set", OF(from, SetDeviceName)(ARM(who) "a name of some length") == 0);
    check("as much as fits of it", OF(from, GetDeviceName)(ARM(who) name, sizeof name) == 0 && strcmp(name, "a na") == 0);
    check("and all of it",
          OF(from, GetDeviceName)(ARM(who) long_name, sizeof long_name) == 0 && strcmp(long_name, "a name of some length") == 0);
    uint8_t alarms[32];
    uint32_t count = 0;
    memset(alarms, 0xEE, sizeof alarms);
    check("alarms: 16 bytes, none set",
          OF(from, GetAlarmsState)(ARM(who) alarms, &count, sizeof alarms) == 0 && count == 16 && alarms[15] == 0 && alarms[16] == 0xEE);
}

int main(int count, char **words) {
    if (count != 3) {
        fprintf(stderr, "session LIBRARY PORT\n");
        return 2;
    }
#ifdef LINKED
    library from = NULL;
#else
    library from = open_library(words[1]);
#endif
    int who = 0;
    Pose pose;
    check("without a connection nothing hangs", OF(from, GetPose)(ARM(7) &pose) != 0);
    check("connects", connect_arm(from, words[2], &who) == 0);
    check("a timeout is set", OF(from, SetCmdTimeout)(MASTER(who) 3000) == 0);
    moves(from, who);
    fills(from, who);
    outputs(from, who);
    check("disconnects", OF(from, DisconnectDobot)(ONLY_MASTER(who)) == 0);
    check("then nothing answers", OF(from, GetPose)(ARM(who) &pose) != 0);
    char sentence[200] = "";
    int length = OF(from, MagicianLastError)(sentence, sizeof sentence);
    check("and there is a sentence why", length > 0 && strlen(sentence) > 0);
    check("connects again", connect_arm(from, words[2], &who) == 0 && OF(from, GetPose)(ARM(who) &pose) == 0);
    check("and disconnects", OF(from, DisconnectDobot)(ONLY_MASTER(who)) == 0);
    printf("%d passed, %d failed\n", passed, failed);
    return failed ? 1 : 0;
}
