def gettime():
    return time.time()


def ConnectDobot(api, portName="", baudrate=115200):
    """[result, firmware, version]; result is one of DobotConnect."""
    firmware, version = create_string_buffer(100), create_string_buffer(100)
    result = _try(api, "ConnectDobot", _text(portName), baudrate, firmware, version)
    return [result, _string(firmware), _string(version)]


def DisconnectDobot(api):
    _try(api, "DisconnectDobot")


def SetCmdTimeout(api, times):
    """Milliseconds, for every arm."""
    _try(api, "SetCmdTimeout", times)


def DobotExec(api):
    return _try(api, "DobotExec")


def PeriodicTask(api):
    _try(api, "PeriodicTask")


def SetDebugEnable(api, flag=False):
    _try(api, "SetDebugEnable", _byte(flag))
