"""Programs for DobotLink on a station: session_link.py PTY UDP TCP SPEED MAGICIAN rpc|edu|kit

`rpc` is DobotRPC 4.8.8, `edu` DobotEDU 2.2.2 on top of it (websockets 10.4), `kit` dobotkit 0.2.0,
all unmodified. The station serves the virtual arm of the session over TCP. Modules that DobotRPC
and DobotEDU import but that can no longer be installed, or are for clouds and cameras, are replaced
by empty modules.
"""

import importlib.machinery
import json
import os
import signal
import subprocess
import sys
import tempfile
import types

from checks import TIMEOUT, Checks
from station import serving

# Imported by DobotRPC and DobotEDU, but not used for the arm.
STAND_INS = {"demjson", "cv2", "scipy", "sounddevice", "soundfile", "playsound", "requests", "tkinter"}


class StandIns:
    """Import finder for empty modules of these names, whose attributes exist and do nothing."""

    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in STAND_INS:
            return importlib.machinery.ModuleSpec(name, self, is_package=True)
        return None

    def create_module(self, spec):
        module = types.ModuleType(spec.name)
        module.__getattr__ = lambda name: type(name, (), {})
        return module

    def exec_module(self, module):
        pass


class Station:
    """A `magician serve` with a link, from `ready` to its end."""

    def __init__(self, magician, tcp, *flags):
        words = [magician, "serve", "--port", f"tcp:127.0.0.1:{tcp}", "--listen", "localhost:0", *flags]
        self.process, self.ready = serving(words, os.environ)

    def report(self):
        """Returns the calls so far, as reported by GET /api/v1/link."""
        import urllib.request

        with urllib.request.urlopen(self.ready["url"] + "api/v1/link", timeout=TIMEOUT) as answer:
            return json.load(answer)["clients"]

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(timeout=TIMEOUT)


def pose(magician, udp):
    """Returns the pose of the arm, requested without the station."""
    done = subprocess.run([magician, "--port", f"udp:127.0.0.1:{udp}", "--json", "pose"], capture_output=True, text=True)
    found = json.loads(done.stdout)
    return [found[axis] for axis in "xyz"]


def rpc(checks, magician, udp, station):
    """Tests the transport alone, against a port other than the default."""
    import asyncio

    loop = asyncio.new_event_loop()
    asyncio.set_event_loop(loop)
    from DobotRPC import DobotlinkAdapter, RPCClient

    host, port = station.ready["link"].removeprefix("ws://").rsplit(":", 1)
    adapter = DobotlinkAdapter(RPCClient(ip=host, port=int(port), loop=loop), is_sync=True)
    ports = adapter.Magician.SearchDobot()
    checks.equal("the arm is a port", [port["portName"] for port in ports], ["arm"])
    told = adapter.Magician.ConnectDobot(portName="arm")
    checks.equal("it is a Magician", told["productName"], "Magician")
    adapter.Magician.SetHOMECmd(portName="arm")
    adapter.Magician.SetPTPCmd(portName="arm", ptpMode=2, x=220, y=50, z=20, r=0)
    checks.near("a move has ended when it is answered", pose(magician, udp), (220, 50, 20), 0.01)
    index = adapter.Magician.SetPTPCmd(portName="arm", ptpMode=2, x=220, y=-50, z=20, r=0, isWaitForFinish=False)
    checks.ok("one that is not waited for has its index", index["queuedCmdIndex"] > 0)
    adapter.Magician.SetWAITCmd(portName="arm", delay=100, timeout=60_000)
    checks.near("and was done before the next", pose(magician, udp), (220, -50, 20), 0.01)
    for what, call in {
        "an unknown call": lambda: adapter.Magician.Fly(portName="arm"),
        "a port that is not there": lambda: adapter.Magician.ConnectDobot(portName="COM99"),
        "firmware": lambda: adapter.Magician.SetDeviceRestart(portName="arm"),
    }.items():
        try:
            checks.ok(f"{what} is refused", False, call())
        except Exception as error:
            checks.ok(f"{what} is refused", "code" in str(error), error)
    checks.equal("it is disconnected", adapter.Magician.DisconnectDobot(portName="arm"), True)


def edu(checks, magician, udp, station):
    """Tests the package as its users import it. It requires ports 9090 and 10001."""
    from DobotEDU import dobot_edu, dobot_magician as arm

    dobot_edu.set_portname(arm.search_dobot()[0]["portName"])
    checks.equal("it is connected", arm.connect_dobot()["firmwareName"], "Dobot")
    arm.clear_allalarms_state()
    arm.set_homecmd()
    arm.set_ptpcommon_params(100, 100)
    arm.set_ptpcmd(2, 220, 60, 30, 0)
    checks.near("a move has ended when it is answered", pose(magician, udp), (220, 60, 30), 0.01)
    found = arm.get_pose()
    checks.near("its pose is the arm's", [found[axis] for axis in "xyz"], (220, 60, 30), 0.01)
    arm.set_endeffector_suctioncup(True, True)
    checks.equal("the suction cup is on", arm.get_endeffector_suctioncup(), {"isEnabled": True, "isOn": True})
    arm.set_endeffector_suctioncup(True, False)
    arm.set_iomultiplexing(17, 1)
    arm.set_iodo(17, 1)
    checks.equal("a pin is high", arm.get_iodo(17)["level"], 1)
    arm.set_rcmd(30)
    checks.near("the tool turns where it is", pose(magician, udp), (220, 60, 30), 0.01)
    arm.set_ptpcmd(1, 200, 0, 40, 0)
    arm.set_waitcmd(50)
    checks.near("it ends where it should", pose(magician, udp), (200, 0, 40), 0.01)
    checks.equal("no alarm stands", sum(arm.get_alarms_state()["state"]), 0)
    checks.ok("it is disconnected", arm.disconnect_dobot())


def kit(checks, magician, udp, station):
    """Tests dobotkit's arm, whose requests do not name the Lite."""
    from dobotkit.arm import MagicianLite

    host, port = station.ready["link"].removeprefix("ws://").rsplit(":", 1)
    with MagicianLite(host=host, ws_port=int(port)) as arm:
        arm.home()
        arm.move_to(220, 40, 30, wait=True)
        checks.near("a move has ended when it is answered", pose(magician, udp), (220, 40, 30), 0.01)
        arm.move_relative(dy=-20, wait=True)
        checks.near("and one by so much", pose(magician, udp), (220, 20, 30), 0.01)
        arm.pick_and_place((220, 40, 0), (220, -40, 0), 40)
        checks.near("picked and placed", pose(magician, udp), (220, -40, 40), 0.01)
        arm.cmds.set_io_multiplexing(17, 1)
        arm.cmds.set_io_do(17, 1)
        checks.equal("a pin is high", arm.cmds._call("GetIODO", port=17)["level"], 1)
        # The alarm from the start remains: dobotkit does not clear it.
        checks.equal("no other alarm stands", sum(arm.cmds.get_alarms_state()["state"]), 1)
    odd = station.report()[0]["unknown_params"]
    checks.ok("its other names are reported", "Magician.SetIODO.address" in odd, odd)


def main():
    _path, udp, tcp, _speed, magician, which = sys.argv[1:]
    sys.meta_path.insert(0, StandIns())
    magician = os.path.abspath(magician)
    # DobotRPC writes a log into the working directory.
    os.chdir(tempfile.mkdtemp(prefix="magician-"))
    checks = Checks()
    flags = ["--link", "--link-image"] if which == "edu" else ["--link=localhost:0"]
    station = Station(magician, tcp, *flags)
    try:
        checks.section({"rpc": rpc, "edu": edu, "kit": kit}[which], magician, udp, station)
        errors = {name: count for client in station.report() for name, count in client["errors"].items()}
        checks.ok("no call failed that should not", which == "rpc" or not errors, errors)
    finally:
        checks.equal("the station ends", station.end(), 0)
    sys.stdout.flush()
    # The destructor of DobotRPC's client blocks on its socket, so the process exits without it.
    print(f"{checks.passed} passed, {checks.failed} failed", flush=True)
    os._exit(1 if checks.failed or not checks.passed else 0)


main()
