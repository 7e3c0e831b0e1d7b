/*
 * A program that disconnects from its arm at exit, when the thread-local state of the library is already destroyed. C++
 * objects that outlive `main` do so.
 */
#include <stdio.h>
#include <stdlib.h>

#include "DobotDll.h"

#if FAMILY == 1
#define ARM
#define ARM_
#define MASTER
#elif FAMILY == 2
#define ARM 0
#define ARM_ 0,
#define MASTER 0
#else
#define ARM 0, 0
#define ARM_ 0, 0,
#define MASTER 0
#endif

static void leave(void)
{
    Pose pose;
    if (SetQueuedCmdStopExec(ARM) == DobotCommunicate_NoError && GetPose(ARM_ &pose) == DobotCommunicate_NoError &&
        GetPose(ARM_ NULL) == DobotCommunicate_InvalidParams && DisconnectDobot(MASTER) == DobotConnect_NoError) {
        puts("left");
    }
}

int main(void)
{
    Pose pose;
#if FAMILY == 3
    ConnectInfo info;
    int code = ConnectDobot("sim", 115200, &info);
#elif FAMILY == 2
    int id = 1, code = ConnectDobot("sim", 115200, NULL, NULL, &id);
#else
    int code = ConnectDobot("sim", 115200, NULL, NULL);
#endif
    atexit(leave);
    /* Cause a fault, so that the thread-local state is in use. */
    return code != DobotConnect_NoError || GetPose(ARM_ NULL) != DobotCommunicate_InvalidParams ||
           GetPose(ARM_ &pose) != DobotCommunicate_NoError;
}
