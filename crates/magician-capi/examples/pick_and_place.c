/*
 * Picks something up at one place and puts it down at another, with the suction cup.
 *
 *     make && ./pick_and_place sim            a virtual arm
 *     ./pick_and_place /dev/ttyUSB0           a real one: keep clear of it, it homes first
 *     ./pick_and_place                        MAGICIAN_PORT, or the first arm that is found
 */
#include <stdio.h>
#include <stdlib.h>
#ifdef _WIN32
#include <windows.h>
#define nap(ms) Sleep(ms)
#else
#include <time.h>
static void nap(int ms)
{
    struct timespec time = {ms / 1000, ms % 1000 * 1000000L};
    nanosleep(&time, NULL);
}
#endif

#include "DobotDll.h"

static void give_up(const char *what)
{
    char why[300];
    if (MagicianLastError(why, sizeof why) > 0)
        fprintf(stderr, "%s\n", why);
    else
        fprintf(stderr, "%s failed\n", what);
    exit(1);
}

/* Retries while the queue is full: the arm makes room as it works. */
#define MUST(call)                                          \
    do {                                                    \
        int code_;                                          \
        while ((code_ = (call)) == DobotCommunicate_BufferFull) \
            nap(20);                                        \
        if (code_ != DobotCommunicate_NoError)              \
            give_up(#call);                                 \
    } while (0)

static uint64_t go(uint8_t mode, float x, float y, float z)
{
    PTPCmd command = {mode, x, y, z, 0};
    uint64_t index = 0;
    MUST(SetPTPCmd(&command, true, &index));
    return index;
}

static uint64_t suck(bool on)
{
    uint64_t index = 0;
    MUST(SetEndEffectorSuctionCup(true, on, true, &index));
    return index;
}

/* Waits until the command with this index has finished. */
static void wait_for(uint64_t index)
{
    uint64_t current = 0;
    for (;;) {
        MUST(GetQueuedCmdCurrentIndex(&current));
        if (current >= index)
            return;
        nap(20);
    }
}

int main(int argc, char **argv)
{
    EndEffectorParams cup = {59.7f, 0, 0};
    PTPCommonParams speed = {50, 50};
    PTPJumpParams jump = {40, 150};
    HOMECmd home = {0};
    WAITCmd moment = {300};
    uint64_t index = 0;
    Pose pose;

    if (ConnectDobot(argc > 1 ? argv[1] : NULL, 115200, NULL, NULL) != DobotConnect_NoError)
        give_up("ConnectDobot");
    MUST(SetQueuedCmdStopExec());
    MUST(SetQueuedCmdClear());
    MUST(ClearAllAlarmsState());
    MUST(SetQueuedCmdStartExec());

    MUST(SetEndEffectorParams(&cup, true, NULL));
    MUST(SetPTPCommonParams(&speed, true, NULL));
    MUST(SetPTPJumpParams(&jump, true, NULL));
    MUST(SetHOMECmd(&home, true, &index));
    wait_for(index);
    puts("homed");

    go(PTPJUMPXYZMode, 220, 80, 10);
    suck(true);
    MUST(SetWAITCmd(&moment, true, NULL));
    go(PTPJUMPXYZMode, 220, -80, 10);
    suck(false);
    index = go(PTPMOVLXYZMode, 220, -80, 50);
    wait_for(index);

    MUST(GetPose(&pose));
    printf("done at x %.1f, y %.1f, z %.1f\n", pose.x, pose.y, pose.z);
    DisconnectDobot();
    return 0;
}
