#!/usr/bin/env python3
"""Run a script of DobotStudio's "Script" page: studio.py SCRIPT [--port PORT] [--family v1|v2|v3]

Such a script finds `dType` and `api` there already, connected. This connects, empties and starts the queue, runs the
script and disconnects. Ctrl-C stops the arm and empties the queue.

PORT is what ConnectDobot takes: a serial port, an address, `sim` for a virtual arm. Without it MAGICIAN_PORT says, or
the first arm that is found. The exit status is 0; 1 if the script breaks off, 2 for a wrong command line, 4 without a
library or an arm, 130 after Ctrl-C; or what the script says.
"""

import argparse
import importlib.util
import os
import pathlib
import sys
import traceback

HERE = pathlib.Path(__file__).resolve().parent


def module(family):
    """The DobotDllType.py of a family: in its folder, or right here."""
    places = [HERE / family / "DobotDllType.py", HERE / "DobotDllType.py"]
    path = next((place for place in places if place.exists()), None)
    if path is None:
        sys.exit(f"studio: there is no {places[0]}")
    spec = importlib.util.spec_from_file_location("DobotDllType", path)
    made = importlib.util.module_from_spec(spec)
    # A script that imports DobotDllType gets this module.
    sys.modules["DobotDllType"] = made
    spec.loader.exec_module(made)
    return made


def connected(dType, port):
    """The library with an arm, and the ids that its functions begin with."""
    try:
        api = dType.load()
    except OSError as error:
        print(f"studio: {error}", file=sys.stderr)
        sys.exit(4)
    answer = dType.ConnectDobot(api, port, 115200)
    if answer[0] == dType.DobotConnect.DobotConnect_NotFound:
        print("studio: no arm was found; --port says where it is, --port sim is a virtual one", file=sys.stderr)
    elif answer[0] != dType.DobotConnect.DobotConnect_NoError:
        print(f"studio: {port or 'the port'} cannot be opened: {dType.MagicianLastError(api)}", file=sys.stderr)
    else:
        return api, tuple(answer[3:4]) if dType._FAMILY == "v2" else ()
    sys.exit(4)


def run(path, names):
    """The script, as if Python had been given it; the exit status."""
    sys.argv = [str(path)]
    sys.path.insert(0, str(path.parent))
    try:
        # Compile bytes, so that Python handles an encoding declaration and the byte order mark of Windows.
        exec(compile(path.read_bytes(), str(path), "exec"), names)
    except SystemExit as wanted:
        if wanted.code is not None and not isinstance(wanted.code, int):
            print(wanted.code, file=sys.stderr)
            return 1
        return wanted.code or 0
    except Exception as error:
        # Hide the frame of this file: the traceback begins in the script.
        error.__traceback__ = error.__traceback__.tb_next
        traceback.print_exception(type(error), error, error.__traceback__)
        return 1
    return 0


def stopped(dType, api, arm):
    """Stops the arm; what came of it."""
    try:
        dType.SetQueuedCmdForceStopExec(api, *arm)
        dType.SetQueuedCmdClear(api, *arm)
    except dType.DobotError as error:
        return f"the arm could not be told to stop: {error}"
    return "stopped, and the queue is empty"


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("script", type=pathlib.Path)
    options.add_argument("--port", default="", help="where the arm is (MAGICIAN_PORT, or the first that is found)")
    options.add_argument("--family", choices=("v1", "v2", "v3"), default="v1", help="v1 unless given")
    given = options.parse_args()
    if not given.script.is_file():
        options.error(f"there is no {given.script}")

    if given.port:
        # A script that connects by itself shall find the same arm.
        os.environ["MAGICIAN_PORT"] = given.port
    dType = module(given.family)
    api, arm = connected(dType, given.port)
    names = {"__name__": "__main__", "__file__": str(given.script), "dType": dType, "api": api}
    if arm:
        names["dobotId"] = arm[0]
    try:
        dType.SetQueuedCmdClear(api, *arm)
        dType.SetQueuedCmdStartExec(api, *arm)
        status = run(given.script, names)
    except KeyboardInterrupt:
        print("studio:", stopped(dType, api, arm), file=sys.stderr)
        status = 130
    except dType.DobotError as error:
        print(f"studio: {error}", file=sys.stderr)
        status = 1
    finally:
        dType.DisconnectDobot(api, *arm)
    sys.exit(status)


if __name__ == "__main__":
    main()
