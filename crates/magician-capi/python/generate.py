#!/usr/bin/env python3
"""Generate v1, v2 and v3/DobotDllType.py from what is in source/: generate.py [FOLDER]

They are written to FOLDER, which is this one unless given.
"""

import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE / "source"
sys.path.insert(0, str(SOURCE))
sys.dont_write_bytecode = True

import table  # noqa: E402 (its folder is no package)

TYPES = {
    "u8": "c_uint8", "u16": "c_uint16", "u32": "c_uint32", "u64": "c_uint64", "i32": "c_int32", "f32": "c_float",
    "text": "c_char_p", "char*50": "c_char * 50",
}
TITLE = {
    "v1": "one arm, no ids (the DobotDemo of 2016 to 2020)",
    "v2": "several arms, each with a dobotId",
    "v3": "masterId and slaveId, kept in this module (since 2020)",
}
# Prototypes of the hand-written functions.
HOST = {
    "SearchDobot": ("v1 v2 v3", "c_char_p, c_uint32"),
    "DobotExec": ("v1 v2 v3", ""),
    "PeriodicTask": ("v1 v2 v3", ""),
    "SetDebugEnable": ("v1 v3", "c_uint8"),
    "DobotSleep": ("v3", "c_uint32"),
    "MagicianLastError": ("v1 v2 v3", "c_char_p, c_uint32"),
    "MagicianAllow": ("v1 v2 v3", "c_char_p"),
}
CONNECT = {
    "v1": "c_char_p, c_uint32, c_char_p, c_char_p",
    "v2": "c_char_p, c_uint32, c_char_p, c_char_p, POINTER(c_int32)",
    "v3": "c_char_p, c_uint32, POINTER(ConnectInfo)",
}


def head(family):
    return f'''"""DobotDllType for {TITLE[family]}: family {family} of the DobotDll interface.

    import DobotDllType as dType

    api = dType.load()
    if dType.ConnectDobot(api, "", 115200)[0] == dType.DobotConnect.DobotConnect_NoError:
        print(dType.GetPose(api{", 0" if family == "v2" else ""}))

Names, parameters, defaults and results are those of the file that it stands in for. Other than that one it works on
Linux and macOS as on Windows, and no function waits for ever: one that fails raises DobotError.

Ctrl-C leaves a wait at once, and a call that an arm does not answer when its time is over (SetCmdTimeout). Nothing is
sent to the arm then: it goes on with what it was told. SetQueuedCmdForceStopExec stops it.

Made by generate.py: do not edit.
"""

import os
import platform
import re
import threading
import time
import weakref
from ctypes import *

_FAMILY = "{family}"
# How many ids the functions begin with.
_IDS = {len(table.IDS[family])}
'''


def section(title):
    return f"\n# --- {title} ".ljust(120, "-") + "\n"


def enums(family):
    out = [section("Enumerations")]
    for name, families, members in table.ENUMS:
        if family in families.split():
            body = "".join(f"    {member.replace('=', ' = ')}\n" for member in members.split())
            out.append(f"\n\nclass {name}:\n{body}")
    return "".join(out)


def structures(family):
    out = ["\n" + section("Structures")]
    for name, families, layout in table.STRUCTURES:
        if family not in families.split():
            continue
        body = ""
        for group in layout.split(";"):
            kind, names = group.split(":")
            kind = TYPES.get(kind.strip(), kind.strip())
            body += "".join(f'        ("{field}", {kind}),\n' for field in names.split())
        packed = '_layout_, _pack_ = "ms", 1'
        out.append(f"\n\nclass {name}(Structure):\n    {packed}\n    _fields_ = [\n{body}    ]\n")
    return "".join(out)


class C:
    """The C side of a row: what goes before the call, into it, and the types."""

    def __init__(self, row):
        self.before, self.given, self.types = [], [], []
        self.queued = False
        for argument in row.arguments:
            kind, _, rest = argument.partition(" ")
            getattr(self, "other" if not hasattr(self, "add_" + kind) else "add_" + kind)(kind, rest)

    def add(self, kind, *given):
        self.types.append(kind)
        self.given += given

    def add_in(self, _, rest):
        kind, _, made = rest.partition(" ")
        self.add(f"POINTER({kind})", made)

    def add_out(self, _, rest):
        kind, name, *start = rest.split(" ", 2)
        kind = TYPES.get(kind, kind)
        self.before.append(f"{name} = {start[0] if start else kind + '()'}")
        self.add(f"POINTER({kind})", name)

    def add_chars(self, _, rest):
        name, size = rest.split()
        self.before.append(f"{name} = create_string_buffer({size})")
        self.add("c_char_p", name)
        self.add("c_uint32", size)

    def add_text(self, _, rest):
        self.add("c_char_p", rest if rest.startswith("_") else f"_text({rest})")

    def add_alarms(self, _, rest):
        self.before.append("alarmsState, length = create_string_buffer(maxLen), c_uint32(0)")
        self.add("c_char_p", "alarmsState")
        self.add("POINTER(c_uint32)", "length")
        self.add("c_uint32", "maxLen")

    def add_outputs(self, _, rest):
        self.before.append("outputs, count = _outputs(parallelCmd)")
        self.add("POINTER(ParallelOutputCmd)", "outputs")
        self.add("c_int32", "count")

    def add_q(self, *_):
        self.add("c_uint8", "_byte(isQueued)")

    def add_index(self, *_):
        self.queued = True
        self.before.append("queuedCmdIndex = c_uint64(0)")
        self.add("POINTER(c_uint64)", "queuedCmdIndex")

    def add_queue(self, *_):
        self.add_q()
        self.add_index()

    def other(self, kind, rest):
        self.add(TYPES[kind], rest)


def listed(*parts):
    return ", ".join(part for part in parts if part)


def arm(row, family):
    """The ids as the C call begins with them; a row may have others where there are two."""
    ids = table.IDS[family]
    return tuple(row.ids) if row.ids and len(row.ids) == len(ids) else ids


def tuple_of(names):
    return f"({names[0]},)" if len(names) == 1 else f"({', '.join(names)})"


def parameters(row, family):
    own = ("dobotId",) if family == "v2" else ()
    return listed("api", *own, row.parameters)


def function(row, family):
    c = C(row)
    ids = arm(row, family)
    call = "_call(" + listed("api", f'"{row.c_name}"', *ids, *c.given) + ")"
    lines = [*c.before, call]
    if row.after:
        lines.append(row.after.replace("ARM", tuple_of(ids)))
    result = row.result
    if isinstance(result, table.One):
        result = result.expression if family == "v1" else f"[{result.expression}]"
    result = result or ("[queuedCmdIndex.value]" if c.queued else None)
    if result and result != "None":
        lines.append(f"return {result}")
    doc = f'    """{row.doc}"""\n' if row.doc else ""
    return f"\n\ndef {row.name}({parameters(row, family)}):\n{doc}" + "".join(f"    {line}\n" for line in lines)


def finished(family, rows):
    """The functions that also wait."""
    out = []
    for name, own, families in table.FINISHED:
        if family not in families.split():
            continue
        row = rows[name]
        row = table.Row(name, own or row.parameters, ids=row.ids)
        given = listed("api", *(("dobotId",) if family == "v2" else ()),
                       *(part.split("=")[0].strip() for part in row.parameters.split(",")))
        lines = []
        if name in table.ON_RAIL and family == "v1":
            lines = ["if not GetDeviceWithL(api):", '    print("the arm is not on a rail")', "    return None"]
        lines.append(f"queued = {name}({given})[0]")
        lines.append(f'_finish(api, {tuple_of(arm(row, family))}, "{name}Ex", queued)')
        if name == "SetPTPWithLCmd" and family == "v3":
            lines.append("return [queued]")
        out.append(f"\n\ndef {name}Ex({parameters(row, family)}):\n" + "".join(f"    {line}\n" for line in lines))
    own = "api, dobotId" if family == "v2" else "api"
    if family != "v3":
        out.append(f'\n\ndef SetWAITCmdEx({own}, waitTime, isQueued=0):\n    """Sleeps here; waitTime: seconds."""\n'
                   "    dSleep(waitTime * 1000)\n")
    withl = f"GetDeviceWithL({own})" + ("" if family == "v1" else "[0]")
    out.append(f'''

def GetPoseEx({own}, index):
    """One number of the pose: 1 to 8 as in GetPose, 0 is the position on the rail."""
    if index == 0:
        if not {withl}:
            print("the arm is not on a rail")
            return None
        return round(GetPoseL({own})[0], 4)
    return round(GetPose({own})[index - 1], 4)


def GetColorSensorEx({own}, index):
    """One of red, green and blue."""
    return GetColorSensor({own})[index]


def SetEndEffectorLaserEx({own}, enableCtrl, power, isQueued=0):
    """The laser on the outputs 2 and 4: switched, and its power (0 to 100)."""
    SetIOMultiplexingEx({own}, 2, 1, isQueued)
    SetIOMultiplexingEx({own}, 4, 2, isQueued)
    SetIODOEx({own}, 2, enableCtrl, isQueued)
    SetIOPWMEx({own}, 4, 10000, power, isQueued)
''')
    return "".join(out)


def prototypes(family, rows):
    ids = ", ".join(["c_int32"] * len(table.IDS[family]))
    out = {name: types for name, (families, types) in HOST.items() if family in families}
    out["ConnectDobot"] = CONNECT[family]
    out["DisconnectDobot"] = "c_int32" if ids else ""
    out["SetCmdTimeout"] = listed(out["DisconnectDobot"], "c_uint32")
    for row in rows.values():
        types = listed(ids, *C(row).types)
        if out.setdefault(row.c_name, types) != types:
            sys.exit(f"{family}: {row.name} and another disagree about the arguments of {row.c_name}")
    out = {name: types + "," * (types != "" and "," not in types) for name, types in out.items()}
    lines = "".join(f'    "{name}": ({types}),\n' for name, types in out.items())
    said = "\n# The arguments of the C functions; all return an int.\n"
    return section("Prototypes") + said + "_PROTOTYPES = {\n" + lines + "}\n"


def module(family):
    rows = {row.name: row for _, chapter in table.FUNCTIONS for row in chapter if family in row.families}
    out = [head(family), enums(family), structures(family), "\n\n", (SOURCE / "core.py").read_text(encoding="utf-8")]
    out += ["\n\n", (SOURCE / f"{family}.py").read_text(encoding="utf-8")]
    for title, chapter in table.FUNCTIONS:
        made = "".join(function(row, family) for row in chapter if family in row.families)
        if made:
            out += ["\n", section(title), made]
    out += ["\n", section("And wait"), finished(family, rows), "\n", prototypes(family, rows)]
    text = "".join(out)
    # Wrap rows that are too long for a line, in the style of an editor.
    return re.sub(r"\n{4,}", "\n\n\n", "\n".join(wrapped(line) for line in text.split("\n")))


def wrapped(line):
    if len(line) <= 120:
        return line
    indent = len(line) - len(line.lstrip())
    cut = line.find("(", 0, 60) + 1
    if line.lstrip().startswith("return ["):
        cut = line.find("[") + 1
    opened = line[:cut]
    if not opened:
        return line
    inner, close = line[cut:], ""
    depth = 0
    for at, char in enumerate(inner):
        depth += char in "([{"
        depth -= char in ")]}"
        if depth < 0:
            inner, close = inner[:at], inner[at:]
            break
    pad = " " * (indent + (8 if line.lstrip().startswith("def ") else 4))
    rows, row, depth = [], "", 0
    for piece in re.split(r"(?<=,) ", inner):
        if row and len(pad) + len(row) + len(piece) + 1 > 119:
            rows.append(row)
            row = piece
        else:
            row = f"{row} {piece}" if row else piece
    rows.append(row)
    return "\n".join([opened, *(pad + row for row in rows), " " * indent + close])


def write(path, text):
    """Write a file that differs; one that does not keeps its time, so that nothing is built anew for it."""
    if path.exists() and path.read_text(encoding="utf-8") == text:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def main():
    folder = pathlib.Path(sys.argv[1]) if sys.argv[1:] else HERE
    for family in table.FAMILIES:
        write(folder / family / "DobotDllType.py", module(family))


if __name__ == "__main__":
    main()
