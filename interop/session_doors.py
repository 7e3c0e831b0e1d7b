"""Compares DobotDllType on our Python package with DobotDllType on our C library.

Usage: session_doors.py PTY UDP TCP SPEED MAGICIAN FAMILY

Every function of the module is called on both with the same arguments, each on a virtual arm of its
own. Results and error codes are compared.
"""

import ctypes
import inspect
import os
import sys
import tempfile

from checks import Checks
from venvs import TARGET

# Functions whose results do not come from the arm, or depend on time.
HOST = {
    "ConnectDobot", "DisconnectDobot", "DobotExec", "DobotSleep", "GetDeviceTime", "MagicianAllow", "MagicianLastError",
    "PeriodicTask", "SearchDobot", "SetCmdTimeout", "SetDebugEnable", "dSleep", "gettime", "load", "output",
}  # fmt: skip
# Meaningful arguments by name. All others are 1.
MEANING = {
    "x": 220.0, "y": 20.0, "z": 30.0, "r": 5.0, "rHead": 5.0, "ptpMode": 1, "cpMode": 1, "isQueued": 1, "l": 0.0,
    "cirPoint": (200, 20, 30, 0), "toPoint": (210, 0, 30, 0), "parallelCmd": [(50, 2, 1)], "waitTime": 0.01, "str": "name",
    "ssid": "net", "password": "secret", "info": "text", "md5": "00" * 16, "address": 4, "addr": 4, "cmd": 0, "power": 20,
    "maxLen": 32, "pluseCmd": (1, 2, 3, 4, 5, 6), "pid": (1, 1, 1, 1, 1, 1, 1), "zLimit": 80.0, "jumpHeight": 20.0,
    "threshold": 3, "condition": 2, "mode": 1, "maxJumpHeight": 80.0, "value_velocityratio": 50,
}  # fmt: skip


def arguments_for(function, ids):
    """Returns arguments for a function of the module, after `api` and the ids."""
    names = list(inspect.signature(function).parameters)[1 + ids :]
    return [MEANING.get(name, 1) for name in names]


def outcome(function, api, ids, arguments):
    """Returns the result of a call or its failure."""
    try:
        return function(api, *ids, *arguments)
    except Exception as error:
        return type(error).__name__, getattr(error, "code", None)


def plain(value):
    """Converts a value into one that can be compared and printed."""
    if isinstance(value, ctypes.Array):
        return bytes(value)
    return [plain(each) for each in value] if isinstance(value, (list, tuple)) else value


def connected(dType, api, family):
    """Connects to a virtual arm in this process. Returns the library's answer and the arm's ids."""
    answer = dType.ConnectDobot(api, "sim", 115200)
    if answer[0]:
        raise AssertionError(f"no connection: {answer}")
    return answer, (answer[3],) if family == "v2" else ()


def main():
    family = sys.argv[6]
    checks = Checks()
    import magician.compat.dobotdll as dobotdll

    ours = dobotdll.family(family)
    python_api = ours.load()
    suffix = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
    prefix = "" if suffix == ".dll" else "lib"
    library = ctypes.CDLL(str(TARGET / "debug" / f"{prefix}dobotdll_{family}{suffix}"))
    with tempfile.TemporaryDirectory() as home:
        os.chdir(home)
        first, ids = connected(ours, python_api, family)
        second, _ = connected(ours, library, family)
        # The time since the arm's power-up differs.
        checks.equal("ConnectDobot", first[:7], second[:7])
        functions = [
            (name, function)
            for name, function in vars(ours).items()
            if inspect.isfunction(function) and function.__module__ == ours.__name__
            if not name.startswith("_") and name not in HOST
        ]
        equal_count = 0
        for name, function in sorted(functions):
            if any(word in name for word in ("StartExec", "StopExec", "TRIG", "Download", "JOGCmd", "HOMECmd", "Leveling")):
                continue
            for api in (python_api, library):
                ours.ClearAllAlarmsState(api, *ids)
                ours.SetPTPCmdEx(api, *ids, 1, 200.0, 0.0, 20.0, 0.0, 1)
            arguments = arguments_for(function, len(ids))
            one, other = (plain(outcome(function, api, ids, arguments)) for api in (python_api, library))
            if one == other:
                equal_count += 1
            else:
                checks.equal(f"{name}{tuple(arguments)}", one, other)
        checks.ok("functions that give back the same", equal_count > 130, equal_count)
        for word in ("SetTRIGCmd", "SetHOMECmd", "SetJOGCmd", "SetAutoLevelingCmd"):
            function = getattr(ours, word)
            for api in (python_api, library):
                ours.SetQueuedCmdStopExec(api, *ids)
            one, other = (plain(outcome(function, api, ids, arguments_for(function, len(ids)))) for api in (python_api, library))
            checks.equal(f"{word} on a stopped queue", one, other)
            for api in (python_api, library):
                ours.SetQueuedCmdClear(api, *ids)
        for allowed in ("SetDeviceSN", "UpdateFirmware"):
            for api in (python_api, library):
                ours.MagicianAllow(api, allowed)
            function = getattr(ours, allowed)
            arguments = arguments_for(function, len(ids))
            one, other = (plain(outcome(function, api, ids, arguments)) for api in (python_api, library))
            checks.equal(f"{allowed}, allowed", one, other)
        one, other = (plain(ours.GetDeviceSN(api, *ids)) for api in (python_api, library))
        checks.equal("the serial number is the new one", one, other)
        one, other = (plain(ours.GetPose(api, *ids)) for api in (python_api, library))
        checks.equal("both arms stand at", one, other)
        for api in (python_api, library):
            ours.DisconnectDobot(api, *ids)
        one, other = (outcome(ours.GetPose, api, ids, []) for api in (python_api, library))
        checks.equal("without a connection", one, other)
        os.chdir("/")
    checks.finish()


if __name__ == "__main__":
    main()
