masterId = 0
slaveId = 0
masterDevType = 0
slaveDevType = 0
isUsingLinearRail = False
QuitDobotApiFlag = True


def gettime():
    return [time.time()]


def ConnectDobot(api, portName="", baudrate=115200):
    """[result, masterDevType, slaveDevType, firmware, version, masterId, slaveId, seconds it has run].

    result is one of DobotConnect. The other functions are about the arm that was connected last: set `masterId` to
    speak to another.
    """
    global masterId, slaveId, masterDevType, slaveDevType
    info = ConnectInfo()
    result = _try(api, "ConnectDobot", _text(portName), baudrate, info)
    if result != DobotConnect.DobotConnect_NoError:
        return [result, 0, 0, 0, 0, 0, 0, 0]
    arm = info.masterDevInfo
    masterId, masterDevType, slaveId, slaveDevType = arm.devId, arm.type, 0, 0
    if masterDevType == DevType.Conntroller:
        slaves = [slave for slave in (info.slaveDevInfo1, info.slaveDevInfo2) if slave.type != DevType.Idle]
        slaveId, slaveDevType = (slaves[0].devId, slaves[0].type) if slaves else (-1, 0)
        arm = slaves[0] if slaves else arm
    names = [name.decode("utf-8", "replace") for name in (arm.firmwareName, arm.firwareVersion)]
    return [result, masterDevType, slaveDevType, *names, masterId, slaveId, info.masterDevInfo.runTime]


def DisconnectDobot(api):
    _try(api, "DisconnectDobot", masterId)


def SetCmdTimeout(api, times):
    """Milliseconds."""
    _try(api, "SetCmdTimeout", masterId, times)


def DobotExec(api):
    return [_try(api, "DobotExec")]


def PeriodicTask(api):
    _try(api, "PeriodicTask")


def SetDebugEnable(api, flag=False):
    _try(api, "SetDebugEnable", _byte(flag))


def DobotSleep(api, ms):
    _try(api, "DobotSleep", ms)
