"""The same calls with a library and through our replacement for it: session_frames.py PTY UDP TCP
SPEED MAGICIAN

Every program runs twice, each time on a fresh virtual arm at a pseudo-terminal: with its own
library, and with `python -m magician.compat`. The requests to the arm are compared frame by frame,
without polling: queries of the queue's index and of the pose are left out.

Runs in an interpreter that has our package.
"""

import difflib
import re
import sys

from checks import Checks
from sim import run_on_sim
from venvs import HERE, python_for

# Both scripts print each frame to stderr, as id, Ctrl and parameters. THEIRS skips the queries that
# pydobotlab's `wait_for` repeats (index and alarms).
THEIRS = """
import sys
sys.path.insert(0, sys.argv[2])
import whole_frames
import serial
write = serial.Serial.write
def waits():
    frame = sys._getframe(2)
    while frame and frame.f_code.co_name != "wait_for":
        frame = frame.f_back
    return frame
def said(port, data):
    data = bytes(data)
    waits() or print("##", data[3], data[4], data[5:-1].hex(), file=sys.stderr)
    return write(port, data)
serial.Serial.write = said
exec(compile(sys.stdin.read(), "program.py", "exec"), {"__name__": "__main__"})
"""
OURS = """
import sys
from magician.compat import _line
exchange = _line.Line.exchange
def said(line, id, ctrl, params, **named):
    print("##", id, ctrl, params.hex(), file=sys.stderr)
    return exchange(line, id, ctrl, params, **named)
_line.Line.exchange = said
from magician.compat.__main__ import main
sys.argv = ["magician.compat", *sys.argv[1:]]
sys.exit(main())
"""
CURRENT_INDEX, POSE = 246, 10

PYDOBOT2_PROGRAM = """
from {library} import Dobot
dobot = Dobot(PORT)
dobot.speed(80, 70)
dobot.move_to(220, 20, 30, 5)
dobot.go_arc(210, 0, 30, 0, 220, 10, 30, 0)
dobot.suck(True)
dobot.suck(False)
dobot.grip(True)
dobot.grip(False)
dobot.set_io(4, True)
dobot.set_home(200, 0, 50)
dobot.wait_for_cmd(dobot.home())
dobot.clear_alarms()
dobot.get_alarms()
dobot.get_pose()
dobot.close()
"""
# Calls that pydobot2 lacks, or that fail in it.
PYDOBOTPLUS_CALLS = """
dobot.conveyor_belt(0.5)
dobot.conveyor_belt(0)
dobot.conveyor_belt_distance(50, 10)
dobot.set_color(True)
dobot.get_color()
dobot.set_ir(True)
dobot.get_ir()
dobot.move_rel(x=5, z=-5)
dobot.laze(20, True)
dobot.laze(0, False)
dobot.set_hht_trig_output(True)
dobot.get_hht_trig_output()
dobot.jog_x(-10)
dobot.jog_x(0)
dobot.close()
"""
# The library stores its settings in the home directory.
PYDOBOTLAB_PROGRAM = """
import os
os.environ["XDG_CONFIG_HOME"] = os.path.dirname(PORT)
from pydobotlab import JOGCmd, Magician, PTPMode
with Magician(PORT, require_panel=False, verbose=False) as bot:
    bot.clear_alarm()
    bot.motion_params = 80, 70
    bot.motion_params
    bot.jump_params = 100, 20
    bot.jump_params
    bot.ptp(PTPMode.MOVL_XYZ, 220, 20, 30, 5)
    bot.set_r(10)
    bot.move_to(210, 0, 30, 5, mode=PTPMode.MOVJ_XYZ)
    bot.set_device_withl(True, 1)
    bot.set_ptpl_params(50, 40)
    bot.set_ptpwithl_cmd(2, 220, 0, 30, 0, 20)
    bot.get_posel()
    bot.set_device_withl(False)
    bot.set_multiplexing("DO_01", 1)
    bot.set_do("DO_01", 1)
    bot.set_multiplexing(4, 2)
    bot.set_pwm("DO_04", 1000, 50)
    bot.get_di("DI_07")
    bot.get_adc(9)
    bot.set_endeffector_suctioncup(True, True)
    bot.set_endeffector_suctioncup(False, False)
    bot.set_endeffector_gripper(True, True)
    bot.set_endeffector_gripper(False, False)
    bot.set_endeffector_laser(False, False)
    bot.set_infrared_sensor(2, True)
    bot.get_infrared_sensor(2)
    bot.set_color_sensor(1, True)
    bot.get_color_sensor()
    bot.wait(0.25)
    bot.get_arm_speed_ratio(0)
    bot.get_arm_speed_ratio(1)
    bot.set_lost_step_params(5)
    bot.set_lost_step_cmd()
    bot.get_lost_step_result()
    bot.set_converyor(bot.Stepper1, True, -500)
    bot.set_conveyor(0, False, 0)
    bot.set_jog_common_params(50, 40)
    bot.get_jog_common_params()
    bot.jog(JOGCmd.AP_DOWN)
    bot.jog_stop()
    bot.set_cp_params(100, 50, real_time_track=True)
    bot.set_cp_params(100, 50)
    with bot.batch():
        bot.cp(225, 0, 30)
        with bot.batch():
            bot.cp(-5, 0, 0, velocity=50, mode=0)
        bot.ptp(1, 220, 30, 30, 0)
    try:
        with bot.batch():
            bot.ptp(1, 230, 30, 30, 0)
            raise OSError
    except OSError:
        pass
    bot.set_home()
    bot.clear_alarm()
    bot.get_alarms()
    bot.ensure_no_alarms()
    bot.set_device_name("arm")
    bot.get_device_name()
    bot.get_device_serial_number()
    bot.get_device_version()
    bot.queued_cmd_left_space()
"""
# The library's conveyor belt runs in one direction only, and `close()` closes the gripper.
DOBOTAPI_PROGRAM = """
from dobotapi import Dobot
from dobotapi.dobot_interfaces import MODE_PTP, Position
dobot = Dobot(PORT, execution_delay=0.01)
dobot.connect()
dobot.speed(80, 70)
dobot.move_to(220, 20, 30, 5)
dobot.move_to(220, 20, 40, mode=MODE_PTP.MOVJ_XYZ, delay_overwrite=0.01)
dobot.move_to_position(Position(210, 0, 30, 0))
dobot.gripper.open()
dobot.gripper.close()
dobot.suction_cup.suck()
dobot.suction_cup.idle()
dobot.conveyor_belt.move(0.5)
dobot.conveyor_belt.idle()
dobot.ir_toggle()
dobot.get_ir()
dobot.get_alarms()
dobot.get_pose()
dobot.wait(10)
dobot.close()
"""
# Omits calls that fail in the library. Frames whose checksum is 0 or 255 (names, the serial number)
# get a wrong one, so no arm answers them. Inputs are requested without their pin.
DOBOTWRAPPERPY_PROGRAM = """
import asyncio
from dobotWrapperPy import DobotApi, DobotAsync, DobotConnection
from dobotWrapperPy.paramsStructures import *
from dobotWrapperPy.enums.IOFunction import IOFunction
from dobotWrapperPy.enums.level import Level
from dobotWrapperPy.enums.ptpMode import PTPMode
api = DobotApi(DobotConnection(PORT))
api.initialize_robot()
api.set_ptp_cmd(tagPTPCmd(PTPMode.MOVL_XYZ, 220, 20, 30, 5), wait=True, is_queued=True)
api.set_ptp_common_params(tagPTPCommonParams(50, 40), is_queued=True)
api.get_ptp_common_params()
api.set_home_params(tagHomeParams(200, 0, 50, 0), is_queued=True)
api.get_home_params()
api.set_end_effector_suction_cup(True, is_queued=True)
api.get_end_effector_suction_cup()
api.set_end_effector_gripper(True, False, is_queued=True)
api.set_arc_cmd(tagARCCmd(tagARCCmd.Point(210, 0, 30, 0), tagARCCmd.Point(220, 10, 30, 0)), True, True)
api.set_wait_cmd(tagWAITCmd(10), is_queued=True)
api.get_device_version()
api.get_active_alarms()
api.clear_all_alarms_state()
api.get_pose()
api.set_queued_cmd_stop_exec()
api.set_queued_cmd_clear()
api.set_queued_cmd_start_exec()

async def main():
    dobot = DobotAsync(PORT)
    await dobot.connect()
    await dobot.move_xyz_linear(220, 20, 30, 5)
    await dobot.move_xyz_joint(210, 0, 30, 0)
    await dobot.move_relative_xyz_linear(5, 0, -5, 0)
    await dobot.move_relative_xyz_joint(5, 0, -5, 0)
    await dobot.jump(210, 10, 30, 0)
    await dobot.jump_relative_xyz(5, 5, 0, 0)
    await dobot.move_in_circle(215, 0, 30, 0, 220, 10, 30, 0)
    await dobot.set_pin_purpose(1, IOFunction.DO)
    await dobot.set_pin_output(1, Level.HIGH)
    await dobot.get_pin_input(7)
    await dobot.set_pwm(4, 1000, 50)
    await dobot.suck(True)
    await dobot.grip(True, True)
    await dobot.laser(False)
    await dobot.wait(10)
    await dobot.home()
    await dobot.pose()
    await dobot.clear_alarms()
    await dobot.get_alarms()
    dobot.force_stop()

api.close()
asyncio.run(main())
"""
PROGRAMS = {
    "pydobot": """
from pydobot import Dobot
dobot = Dobot(port=PORT)
dobot.speed(80, 70)
dobot.move_to(220, 20, 30, 5, wait=True)
dobot.go(210, 0, 30)
dobot.suck(True)
dobot.suck(False)
dobot.grip(True)
dobot.grip(False)
dobot.set_eio(4, 1)
dobot.get_eio(4)
dobot.wait(10)
dobot.pose()
dobot.close()
""",
    "pydobot2": PYDOBOT2_PROGRAM.format(library="pydobot"),
    **{
        library: PYDOBOT2_PROGRAM.format(library=library).replace("dobot.close()\n", PYDOBOTPLUS_CALLS)
        for library in ("pydobotplus", "pydobotpp")
    },
    "pydobotlab": PYDOBOTLAB_PROGRAM,
    "dobotapi": DOBOTAPI_PROGRAM,
    "dobotwrapperpy": DOBOTWRAPPERPY_PROGRAM,
}


def frames(said):
    """Returns the frames that a program printed, without the polling."""
    found = [(int(id), int(ctrl), params) for id, ctrl, params in re.findall(r"^## (\d+) (\d+) ?(\w*)$", said, re.M)]
    return [frame for frame in found if frame[0] not in (CURRENT_INDEX, POSE)]


def run(magician, command, program):
    """Runs a program on an arm of its own. Returns the frames it wrote and its exit status."""
    ended, _, _ = run_on_sim(magician, command, f"import sys\nPORT = sys.argv[1]\n{program}")
    if ended.returncode:
        print(ended.stderr)
    return frames(ended.stderr), ended.returncode


def main():
    magician, ours = sys.argv[5], sys.executable
    checks = Checks()
    for library, program in PROGRAMS.items():
        print(f"what {library} writes")
        if library == "pydobotlab" and sys.version_info < (3, 11):
            print("  left out: it needs Python 3.11")
            continue
        theirs = python_for(f"{library}.txt")
        their_command = [theirs, "-B", "-c", THEIRS]
        their_frames, status = run(magician, lambda path, _, their_command=their_command: [*their_command, path, HERE], program)
        checks.equal("its own library ends well", status, 0)
        options = ["--pydobot", library] if library in ("pydobot", "pydobot2") else []
        our_command = [ours, "-B", "-c", OURS, *options]
        our_frames, status = run(magician, lambda path, script, our_command=our_command: [*our_command, script, path], program)
        checks.equal("the stand-in ends well", status, 0)
        checks.ok("frames were written", len(their_frames) > 10)
        same = [*difflib.unified_diff([str(each) for each in their_frames], [str(each) for each in our_frames], lineterm="", n=2)]
        checks.ok("and the stand-in writes the same", not same, "\n  ".join([f"{len(their_frames)} frames", *same]))
    checks.finish()


if __name__ == "__main__":
    main()
