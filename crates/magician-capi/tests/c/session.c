/*
 * A typical session of a C program, on a virtual arm, for each family. Also looks up every function by its name, like
 * programs that load the library at run time. A failed check prints its line.
 */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "DobotDll.h"

/* Generated from the table: the function names of the family. */
#include "names.h"

#if FAMILY == 1
#define ARM
#define ARM_
#define MASTER
#define MASTER_
#elif FAMILY == 2
#define ARM id
#define ARM_ id,
#define MASTER id
#define MASTER_ id,
#else
#define ARM id, 0
#define ARM_ id, 0,
#define MASTER id
#define MASTER_ id,
#endif

static void fail(int line, const char *what)
{
    char why[300] = "no fault is known";
    MagicianLastError(why, sizeof why);
    fprintf(stderr, "session.c:%d: %s; %s\n", line, what, why);
    exit(1);
}

#define CHECK(condition) ((condition) ? (void)0 : fail(__LINE__, #condition))
#define OK(call) CHECK((call) == DobotCommunicate_NoError)

static int connect_arm(void)
{
    int id = 0;
#if FAMILY == 3
    ConnectInfo info;
    memset(&info, 0xee, sizeof info);
    CHECK(ConnectDobot("sim", 115200, &info) == DobotConnect_NoError);
    CHECK(info.masterDevInfo.type == DevTypeMagician);
    CHECK(info.slaveDevInfo1.type == DevTypeIdle && info.slaveDevInfo2.type == DevTypeIdle);
    id = info.masterDevInfo.devId;
#else
    char kind[100] = "", version[100] = "";
#if FAMILY == 2
    CHECK(ConnectDobot("sim", 115200, kind, version, &id) == DobotConnect_NoError);
#else
    CHECK(ConnectDobot("sim", 115200, kind, version) == DobotConnect_NoError);
#endif
    CHECK(strcmp(kind, "DobotSerial") == 0);
    CHECK(strcmp(version, "0.0.0") == 0);
#endif
    return id;
}

static void until(int id, uint64_t index)
{
    uint64_t current = 0;
    int looks = 0;
    (void)id;
    do {
        OK(GetQueuedCmdCurrentIndex(ARM_ &current));
        CHECK(++looks < 100000);
    } while (current < index);
}

static void session(int id)
{
    HOMECmd home = {0};
    PTPCommonParams ratios = {50, 50}, told = {0, 0};
    PTPCmd move = {PTPMOVLXYZMode, 220, 40, 30, 10};
    Pose pose;
    IODO pin = {4, 1};
    IOMultiplexing use = {4, IOFunctionDO};
    uint64_t index = 0, last = 0;
    (void)id;

    OK(SetCmdTimeout(MASTER_ 3000));
    OK(SetQueuedCmdClear(ARM));
    OK(ClearAllAlarmsState(ARM));
    OK(SetQueuedCmdStartExec(ARM));

    /* An index is returned although isQueued is false: this function always queues. */
    OK(SetHOMECmd(ARM_ &home, false, &index));
    CHECK(index > 0);
    OK(SetPTPCommonParams(ARM_ &ratios, true, &last));
    CHECK(last == index + 1);
    OK(SetPTPCmd(ARM_ &move, false, &last));
    CHECK(last == index + 2);
    move.ptpMode = PTPMOVLXYZINCMode;
    move.x = move.y = move.r = 0;
    move.z = -12.5f;
    OK(SetPTPCmd(ARM_ &move, true, NULL));
    OK(SetEndEffectorSuctionCup(ARM_ true, true, true, &last));
    CHECK(last == index + 4);
    until(id, last);

    OK(GetPTPCommonParams(ARM_ &told));
    CHECK(told.velocityRatio == 50 && told.accelerationRatio == 50);
    OK(GetPose(ARM_ &pose));
    CHECK(fabsf(pose.x - 220) < 0.01f && fabsf(pose.y - 40) < 0.01f);
    CHECK(fabsf(pose.z - 17.5f) < 0.01f && fabsf(pose.r - 10) < 0.01f);
    CHECK(fabsf(pose.jointAngle[0] + pose.jointAngle[3] - pose.r) < 0.01f);

    bool enabled = false, on = false;
    OK(GetEndEffectorSuctionCup(ARM_ &enabled, &on));
    CHECK(enabled && on);

    OK(SetIOMultiplexing(ARM_ &use, true, NULL));
    OK(SetIODO(ARM_ &pin, true, &last));
    until(id, last);
    pin.level = 0;
    OK(GetIODO(ARM_ &pin));
    CHECK(pin.address == 4 && pin.level == 1);

    uint8_t alarms[32];
    uint32_t bytes = 0;
    OK(GetAlarmsState(ARM_ alarms, &bytes, sizeof alarms));
    CHECK(bytes == 16);

    /* A null pointer is refused, and the fault has a sentence. */
    CHECK(SetPTPCmd(ARM_ NULL, true, &last) == DobotCommunicate_InvalidParams);
    CHECK(GetPose(ARM_ NULL) == DobotCommunicate_InvalidParams);
    CHECK(MagicianLastError(NULL, 0) > 0);
}

int main(int argc, char **argv)
{
    void *library = dlopen(argc > 1 ? argv[1] : "libDobotDll.so.1", RTLD_NOW | RTLD_GLOBAL);
    CHECK(library != NULL);
    for (size_t i = 0; i < sizeof NAMES / sizeof *NAMES; i++) {
        if (dlsym(library, NAMES[i]) == NULL) {
            fail(__LINE__, NAMES[i]);
        }
    }
    CHECK(dlsym(library, "GetPose") == (void *)GetPose);

    int id = connect_arm();
#if FAMILY != 1
    int other = connect_arm();
    CHECK(other != id);
    session(other);
    CHECK(DisconnectDobot(other) == DobotConnect_NoError);
#endif
    session(id);
    CHECK(DisconnectDobot(MASTER) == DobotConnect_NoError);
    CHECK(dlclose(library) == 0);
    puts("done");
    return 0;
}
