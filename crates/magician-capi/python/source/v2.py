def gettime():
    return [time.time()]


def ConnectDobot(api, portName="", baudrate=115200):
    """[result, firmware, version, dobotId]; result is one of DobotConnect."""
    firmware, version, dobotId = create_string_buffer(100), create_string_buffer(100), c_int32(0)
    result = _try(api, "ConnectDobot", _text(portName), baudrate, firmware, version, dobotId)
    return [result, _string(firmware), _string(version), dobotId.value]


def DisconnectDobot(api, dobotId):
    _try(api, "DisconnectDobot", dobotId)


def SetCmdTimeout(api, dobotId, times):
    """Milliseconds."""
    _try(api, "SetCmdTimeout", dobotId, times)


def DobotExec(api):
    return [_try(api, "DobotExec")]


def PeriodicTask(api):
    _try(api, "PeriodicTask")
