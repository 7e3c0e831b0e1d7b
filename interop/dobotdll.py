"""Calls to a DobotDll library as the stock wrappers make them: without prototypes, with ints for
bools, and with structures that are too large.

The structures are those of the wrappers in the field, including their mistakes: a 21-byte PTPCmd in
v1, an IOADC of 5 bytes, HOMECmd as a float, a CircleCmd without its count.
"""

import ctypes
import os
import pathlib
import subprocess
from ctypes import byref, c_byte, c_float, c_int, c_uint64, create_string_buffer

NOT_CONNECTED = {"v1": 2, "v2": 2, "v3": 4}
SENTINEL = 7_777_777


def structure(name, *fields):
    """Defines a packed structure."""
    return type(name, (ctypes.Structure,), {"_layout_": "ms", "_pack_": 1, "_fields_": list(fields)})


def floats(name, count):
    """Defines a structure of floats."""
    return structure(name, ("values", c_float * count))


Pose = floats("Pose", 8)
HOMECmd = floats("HOMECmd", 1)
CircleCmd = floats("CircleCmd", 8)
PTPCmd = {
    "v1": structure("PTPCmd", ("mode", c_byte), ("target", c_float * 4), ("gripper", c_float)),
    "v2": structure("PTPCmd", ("mode", c_byte), ("target", c_float * 4)),
    "v3": structure("PTPCmd", ("mode", c_byte), ("target", c_float * 4)),
}
JOGCmd = structure("JOGCmd", ("joint", c_byte), ("cmd", c_byte))
WAITCmd = structure("WAITCmd", ("ms", ctypes.c_uint32))
IOADC = structure("IOADC", ("address", c_byte), ("value", c_int))
IODO = structure("IODO", ("address", c_byte), ("level", c_byte))
DevInfo = structure("DevInfo", ("id", c_int), ("type", c_int), ("name", c_byte * 50), ("version", c_byte * 50),
                    ("time", c_float))
ConnectInfo = structure("ConnectInfo", ("master", DevInfo), ("slave1", DevInfo), ("slave2", DevInfo))


class ConnectResult:
    """Result of ConnectDobot."""

    def __init__(self, result, firmware, version, ids=(), kind=2):
        self.result, self.firmware, self.version, self.ids, self.kind = result, firmware, version, ids, kind


class Stock:
    """A family's library, called in the same way as by the stock wrappers of that family."""

    def __init__(self, family, path):
        self.family, self.path = family, str(path)
        self.api = ctypes.CDLL(self.path)

    def connect(self, port):
        """Calls ConnectDobot."""
        port_buffer = create_string_buffer(100)
        port_buffer.raw = port.encode()
        if self.family == "v3":
            info = ConnectInfo()
            result = self.api.ConnectDobot(port_buffer, 115200, byref(info))
            text = [bytes(field).rstrip(b"\0").decode() for field in (info.master.name, info.master.version)]
            return ConnectResult(result, *text, (c_int(info.master.id), c_int(0)), info.master.type)
        firmware, version, number = create_string_buffer(100), create_string_buffer(100), c_int(0)
        id_argument = (byref(number),) if self.family == "v2" else ()
        result = self.api.ConnectDobot(port_buffer, 115200, firmware, version, *id_argument)
        ids = (number.value,) if self.family == "v2" else ()
        return ConnectResult(result, firmware.value.decode(), version.value.decode(), ids)

    def arm(self, ids=None):
        """Returns the functions of an arm, by default of the first one, whose ids need no
        connection."""
        default_ids = {"v1": (), "v2": (0,), "v3": (c_int(0), c_int(0))}[self.family]
        return Arm(self, default_ids if ids is None else ids)


class Arm:
    """Functions of a library, called for one arm."""

    def __init__(self, stock, ids):
        self.stock, self.ids, self.family = stock, ids, stock.family

    def __call__(self, name, *arguments):
        return getattr(self.stock.api, name)(*self.ids, *arguments)

    def disconnect(self):
        """Calls DisconnectDobot. v3 passes only one id."""
        return self.stock.api.DisconnectDobot(*self.ids[:1])

    def set_timeout(self, milliseconds):
        """Calls SetCmdTimeout. v3 passes only one id."""
        return self.stock.api.SetCmdTimeout(*self.ids[:1], milliseconds)

    def pose(self):
        """Returns the result code, and x y z r j1 j2 j3 j4."""
        pose = Pose((c_float * 8)(*[SENTINEL] * 8))
        code = self("GetPose", byref(pose))
        return code, list(pose.values)

    def index(self):
        """Returns the index of the last finished command."""
        index = c_uint64(SENTINEL)
        code = self("GetQueuedCmdCurrentIndex", byref(index))
        if code:
            raise AssertionError(f"GetQueuedCmdCurrentIndex returned {code}")
        return index.value

    def queued(self, name, *arguments, queued=0):
        """Sends a queued command, by default with isQueued 0. Returns the code and the index."""
        index = c_uint64(SENTINEL)
        code = self(name, *arguments, queued, byref(index))
        return code, index.value

    def move(self, mode, *target, queued=0):
        """Calls SetPTPCmd."""
        return self.queued("SetPTPCmd", byref(PTPCmd[self.family](mode, (c_float * 4)(*target))), queued=queued)

    def wait(self, milliseconds):
        """Calls SetWAITCmd."""
        return self.queued("SetWAITCmd", byref(WAITCmd(milliseconds)), queued=1)


def exported(path):
    """Returns the names of the functions that a library exports."""
    output = subprocess.run(["nm", "-D", "--defined-only", path], capture_output=True, text=True, check=True).stdout
    names = {line.split()[2].split("@")[0] for line in output.splitlines() if line.split()[1:2] == ["T"]}
    return {name for name in names if name[0].isupper()}


def library(magician, family):
    """Returns the path of a family's library, which was built next to the program, and the folder
    of the crate. Removes MAGICIAN_PORT from the environment."""
    root = pathlib.Path(__file__).resolve().parent.parent
    path = pathlib.Path(magician).resolve().parent / f"libdobotdll_{family}.so"
    if not path.exists():
        raise SystemExit(f"there is no {path}: cargo build -p magician-capi-{family}")
    os.environ.pop("MAGICIAN_PORT", None)
    return path, root / "crates" / "magician-capi"
