"""Pick and place in the manner of the vendor's DobotControl.py: connect, queue everything, start, wait, disconnect.

Nothing in it is about which library it runs on: it works with DobotDllType.py of the family v1 and of v3, on a real arm
(an empty name is the first one found) and, with MAGICIAN_PORT=sim, on a virtual one.
"""

import DobotDllType as dType

PLACES = [(220, -60), (240, 0), (220, 60)]
ABOVE, DOWN = 40, -10

STATES = {
    dType.DobotConnect.DobotConnect_NoError: "DobotConnect_NoError",
    dType.DobotConnect.DobotConnect_NotFound: "DobotConnect_NotFound",
    dType.DobotConnect.DobotConnect_Occupied: "DobotConnect_Occupied",
}

api = dType.load()
state = dType.ConnectDobot(api, "", 115200)[0]
print("Connect status:", STATES[state])

if state == dType.DobotConnect.DobotConnect_NoError:
    dType.SetQueuedCmdStopExec(api)
    dType.SetQueuedCmdClear(api)

    dType.SetHOMEParams(api, 200, 0, 50, 0, isQueued=1)
    dType.SetPTPJointParams(api, 200, 200, 200, 200, 200, 200, 200, 200, isQueued=1)
    dType.SetPTPCommonParams(api, 100, 100, isQueued=1)
    dType.SetPTPJumpParams(api, 30, 100, isQueued=1)
    dType.SetHOMECmd(api, temp=0, isQueued=1)

    for (x, y), (to_x, to_y) in zip(PLACES, PLACES[1:]):
        dType.SetPTPCmd(api, dType.PTPMode.PTPMOVJXYZMode, x, y, ABOVE, 0, isQueued=1)
        dType.SetPTPCmd(api, dType.PTPMode.PTPMOVLXYZMode, x, y, DOWN, 0, isQueued=1)
        dType.SetEndEffectorSuctionCup(api, 1, 1, isQueued=1)
        dType.SetPTPCmd(api, dType.PTPMode.PTPJUMPXYZMode, to_x, to_y, DOWN, 0, isQueued=1)
        dType.SetEndEffectorSuctionCup(api, 1, 0, isQueued=1)
        lastIndex = dType.SetPTPCmd(api, dType.PTPMode.PTPMOVLXYZMode, to_x, to_y, ABOVE, 0, isQueued=1)[0]

    dType.SetQueuedCmdStartExec(api)
    while lastIndex > dType.GetQueuedCmdCurrentIndex(api)[0]:
        dType.dSleep(100)
    dType.SetQueuedCmdStopExec(api)
    print("Pose:", [round(value, 2) for value in dType.GetPose(api)[:4]])

dType.DisconnectDobot(api)
