#!/usr/bin/env python3
"""Run a script of DobotStudio's "Script" page: studio.py SCRIPT [--port PORT] [--family v1|v2|v3]

On that page `dType` and `api` already exist and are connected. This program provides them: it connects, empties and
starts the queue, runs the script, and disconnects. Ctrl-C stops the arm and empties the queue.

PORT is a port as ConnectDobot takes it: a serial port, an address, or `sim` for a virtual arm. Without --port,
MAGICIAN_PORT gives it, or else the first arm found is used. The exit status is 0 after success, 1 if the script fails
with an exception, 2 for a wrong command line, 4 without a library or an arm, 130 after Ctrl-C; or the status with which
the script exits.
"""

import argparse
import importlib.util
import os
import pathlib
import sys
import traceback

HERE = pathlib.Path(__file__).resolve().parent


def load_module(family):
    """Loads the DobotDllType.py of a family, from its subfolder or from the folder of this file."""
    candidates = [HERE / family / "DobotDllType.py", HERE / "DobotDllType.py"]
    path = next((candidate for candidate in candidates if candidate.exists()), None)
    if path is None:
        sys.exit(f"studio: there is no {candidates[0]}")
    spec = importlib.util.spec_from_file_location("DobotDllType", path)
    loaded = importlib.util.module_from_spec(spec)
    # A script that imports DobotDllType gets this module.
    sys.modules["DobotDllType"] = loaded
    spec.loader.exec_module(loaded)
    return loaded


def connect(dType, port):
    """Loads the library and connects an arm. Returns the library and the leading ids of its functions."""
    try:
        api = dType.load()
    except OSError as error:
        print(f"studio: {error}", file=sys.stderr)
        sys.exit(4)
    result = dType.ConnectDobot(api, port, 115200)
    if result[0] == dType.DobotConnect.DobotConnect_NotFound:
        print("studio: no arm was found; --port says where it is, --port sim is a virtual one", file=sys.stderr)
    elif result[0] != dType.DobotConnect.DobotConnect_NoError:
        print(f"studio: {port or 'the port'} cannot be opened: {dType.MagicianLastError(api)}", file=sys.stderr)
    else:
        return api, tuple(result[3:4]) if dType._FAMILY == "v2" else ()
    sys.exit(4)


def run(path, names):
    """Runs the script as `python SCRIPT` would. Returns the exit status."""
    sys.argv = [str(path)]
    sys.path.insert(0, str(path.parent))
    try:
        # Compile bytes, so that Python handles an encoding declaration and the byte order mark of Windows.
        exec(compile(path.read_bytes(), str(path), "exec"), names)
    except SystemExit as exit_request:
        if exit_request.code is not None and not isinstance(exit_request.code, int):
            print(exit_request.code, file=sys.stderr)
            return 1
        return exit_request.code or 0
    except Exception as error:
        # Hide the frame of this file: the traceback begins in the script.
        error.__traceback__ = error.__traceback__.tb_next
        traceback.print_exception(type(error), error, error.__traceback__)
        return 1
    return 0


def stop(dType, api, arm):
    """Stops the arm. Returns a message about the outcome."""
    try:
        dType.SetQueuedCmdForceStopExec(api, *arm)
        dType.SetQueuedCmdClear(api, *arm)
    except dType.DobotError as error:
        return f"the arm could not be told to stop: {error}"
    return "stopped, and the queue is empty"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("script", type=pathlib.Path)
    parser.add_argument("--port", default="", help="where the arm is (MAGICIAN_PORT, or the first that is found)")
    parser.add_argument("--family", choices=("v1", "v2", "v3"), default="v1", help="v1 unless given")
    arguments = parser.parse_args()
    if not arguments.script.is_file():
        parser.error(f"there is no {arguments.script}")

    if arguments.port:
        # A script that connects by itself must get the same arm.
        os.environ["MAGICIAN_PORT"] = arguments.port
    dType = load_module(arguments.family)
    api, arm = connect(dType, arguments.port)
    names = {"__name__": "__main__", "__file__": str(arguments.script), "dType": dType, "api": api}
    if arm:
        names["dobotId"] = arm[0]
    try:
        dType.SetQueuedCmdClear(api, *arm)
        dType.SetQueuedCmdStartExec(api, *arm)
        status = run(arguments.script, names)
    except KeyboardInterrupt:
        print("studio:", stop(dType, api, arm), file=sys.stderr)
        status = 130
    except dType.DobotError as error:
        print(f"studio: {error}", file=sys.stderr)
        status = 1
    finally:
        dType.DisconnectDobot(api, *arm)
    sys.exit(status)


if __name__ == "__main__":
    main()
