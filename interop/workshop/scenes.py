"""Guarantees for running jobs, as experienced by a user at a terminal or a program with
`--json`."""

import os
import re
import signal
import time

from lab import Program, Terminal

PAPER = -50.0
DRAW = f"magician draw pen.gcode --surface {PAPER}"
BURN = f"magician engrave burn.gcode --surface {PAPER} --yes"
BURN_M4 = BURN.replace("burn", "burn4", 1)


def at_rest(lab):
    """Checks that the arm's queue is empty, the pen is up and the laser off."""
    queue, pose, info = lab.read_state("queue"), lab.read_state("pose"), lab.read_state("info")
    assert queue["left_space"] == 32, queue
    assert info["laser"] is False, info
    return pose


def drawing(lab, words=DRAW, speed="5"):
    """Starts a drawing at a terminal and waits until it has begun."""
    lab.arm(speed)
    terminal = Terminal(lab, words)
    terminal.wait_for(r"[3-9]/\d+ steps done|[3-9] of \d+ steps done")
    return terminal


def keys_pause_and_go_on(lab):
    terminal = drawing(lab)
    terminal.type_keys("p")
    terminal.wait_for("paused: p resumes")
    assert at_rest(lab)["z"] > PAPER + 9, "the pen is up"
    terminal.type_keys("p")
    terminal.wait_for("done in")
    assert terminal.wait_for_exit() == 0


def stops_with(key):
    def scene(lab):
        terminal = drawing(lab)
        terminal.type_keys(key)
        terminal.wait_for("interrupted: the pen is up by")
        assert terminal.wait_for_exit() == 130
        assert at_rest(lab)["z"] > PAPER + 9
        assert terminal.is_restored()

    return scene


def space_never_goes_on(lab):
    terminal = drawing(lab)
    terminal.type_keys("p")
    terminal.wait_for("paused: p resumes")
    terminal.type_keys(" ")
    assert terminal.wait_for_exit() == 130
    at_rest(lab)


def plus_and_minus(lab):
    terminal = drawing(lab)
    terminal.type_keys("---")
    terminal.wait_for("at 70 %")
    terminal.type_keys("+")
    terminal.wait_for("at 80 %")
    terminal.type_keys("-" * 12)
    terminal.wait_for("at 10 %")
    terminal.type_keys("-")
    terminal.type_keys("s")
    assert terminal.wait_for_exit() == 130
    assert "at 0 %" not in terminal.seen


def minus_is_refused_where_it_burns(lab):
    lab.arm("5")
    terminal = Terminal(lab, BURN)
    terminal.wait_for(r"[2-9]/\d+ steps done|[2-9] of \d+ steps done")
    terminal.type_keys("-")
    terminal.wait_for("speed unchanged: the job burns")
    terminal.type_keys("s")
    assert terminal.wait_for_exit() == 130


def minus_is_followed_by_m4(lab):
    lab.arm("5")
    terminal = Terminal(lab, BURN_M4)
    terminal.wait_for(r"[2-9]/\d+ steps done|[2-9] of \d+ steps done")
    terminal.type_keys("-")
    terminal.wait_for("at 90 %")
    terminal.type_keys("s")
    assert terminal.wait_for_exit() == 130


def whole_screen(lab):
    lab.arm("5")
    terminal = Terminal(lab, f"{DRAW} --tui")
    terminal.wait_for("finished")
    terminal.type_keys("p")
    terminal.wait_for("paused")
    at_rest(lab)
    terminal.type_keys("p")
    terminal.wait_for("done in")
    assert terminal.wait_for_exit() == 0
    assert "\x1b[?1049h" in terminal.seen and "\x1b[?1049l" in terminal.seen
    for word in ("left", "queue", "link up", "pause"):
        assert word in terminal.seen.lower(), word


def pauses_for_a_part(lab):
    lab.arm("20")
    job = Program(lab, f"magician draw layers.svg --parts layer --surface {PAPER} --json")
    job.wait_for_event(event="paused", part=2, reason="part")
    assert at_rest(lab)["z"] > PAPER + 9
    job.send({"do": "resume"})
    job.wait_for_event(event="resumed")
    assert job.wait_for_exit() == 0


def pauses_for_the_program(lab):
    lab.arm("20")
    job = Program(lab, f"magician draw stop.gcode --surface {PAPER} --json")
    job.wait_for_event(event="paused", reason="program")
    at_rest(lab)
    job.send({"do": "resume"})
    assert job.wait_for_exit() == 0


def may_be_jogged_meanwhile(lab):
    lab.arm("20")
    job = Program(lab, f"{DRAW} --json")
    job.wait_for_step(4)
    job.send({"do": "pause"})
    job.wait_for_event(event="paused", part=None, reason="person")
    before = at_rest(lab)
    assert before["z"] > PAPER + 9
    done = lab.run("magician jog x 10 && magician jog z 5")
    assert done.code == 0, done
    moved = lab.read_state("pose")
    assert abs(moved["x"] - before["x"] - 10) < 0.5, (before, moved)
    job.send({"do": "resume"})
    job.wait_for_event(event="resumed")
    assert job.wait_for_exit() == 0
    whole = job.events[-1][1]
    assert whole["end"]["pen"] == "up", whole


def stop_signal(lab):
    terminal = drawing(lab)
    terminal.signal("SIGTSTP")
    terminal.wait_for_suspend()
    assert terminal.is_restored()
    assert at_rest(lab)["z"] > PAPER + 9
    terminal.signal("SIGCONT")
    terminal.wait_for("done in")
    assert terminal.wait_for_exit() == 0


def stop_key(lab):
    terminal = drawing(lab)
    terminal.type_keys("\x1a")
    terminal.wait_for_suspend()
    assert terminal.is_restored()
    at_rest(lab)
    terminal.signal("SIGCONT")
    terminal.wait_for("left")
    terminal.type_keys("s")
    assert terminal.wait_for_exit() == 130


def stopped_burning_stays_paused(lab):
    lab.arm("5")
    terminal = Terminal(lab, BURN)
    terminal.wait_for(r"[2-9]/\d+ steps done|[2-9] of \d+ steps done")
    terminal.signal("SIGTSTP")
    terminal.wait_for_suspend()
    at_rest(lab)
    terminal.signal("SIGCONT")
    terminal.wait_for("stays paused, laser off, until you press p")
    at_rest(lab)
    terminal.type_keys("p")
    terminal.wait_for("done in")
    assert terminal.wait_for_exit() == 0


def stopped_burning_is_resumed_by_a_line(lab):
    lab.arm("5")
    job = Program(lab, f"{BURN} --json")
    job.wait_for_step(4)
    os.kill(job.process.pid, signal.SIGTSTP)
    job.wait_for_event(event="paused", reason="person")
    until_stopped(job.process.pid)
    at_rest(lab)
    os.kill(job.process.pid, signal.SIGCONT)
    time.sleep(0.5)
    at_rest(lab)
    assert job.process.poll() is None
    job.send({"do": "resume"})
    job.wait_for_event(event="resumed")
    assert job.wait_for_exit() == 0


def until_stopped(pid):
    end = time.monotonic() + 30
    while open(f"/proc/{pid}/stat").read().rsplit(")", 1)[1].split()[0] != "T":
        assert time.monotonic() < end, "it does not stop itself"
        time.sleep(0.01)


def progress_at_most_ten_a_second(lab):
    lab.arm("5")
    job = Program(lab, f"{DRAW} --json")
    assert job.wait_for_exit() == 0
    at = [when for when, event in job.events if event.get("event") == "progress"]
    fields = {"step", "steps", "loop", "seconds_left"}
    assert all(fields <= event.keys() for _, event in job.events if event.get("event") == "progress")
    most = max(sum(1 for other in at if 0 <= other - one < 1) for one in at)
    assert most <= 11, most
    result = job.events[-1][1]
    assert "event" not in result and "end" in result, result
    return f"{len(at)} lines, at most {most} in a second"


def lines_are_obeyed(lab):
    lab.arm("5")
    job = Program(lab, f"{DRAW} --json")
    job.wait_for_step(3)
    job.send({"do": "pause"})
    job.wait_for_event(event="paused", part=None, reason="person")
    at_rest(lab)
    job.send("go on")
    job.wait_for_event(event="ignored", line="go on")
    job.send('{"do":"dance"}')
    job.wait_for_event(event="ignored", line='{"do":"dance"}')
    job.send({"do": "resume"})
    job.wait_for_event(event="resumed")
    job.send({"do": "stop"})
    assert job.wait_for_exit() == 130
    at_rest(lab)


def a_file_on_stdin_is_not_obeyed(lab):
    lab.arm("max")
    text = (lab.dir / "pen.gcode").read_text()
    done = lab.run(f"magician draw - --format gcode --surface {PAPER} --json", stdin=text + '({"do":"stop"})\n')
    assert done.code == 0, done


def speeds_after_kill(lab):
    """kill -9, then a query, then a move."""
    lab.arm("5")
    lab.run("magician set PTPCommonParams velocity_ratio=77 acceleration_ratio=66")
    job = Program(lab, f"{DRAW} --speed-ratio 20 --json")
    job.wait_for_step(4)
    # While the job lives, other commands do not restore the speeds.
    done = lab.run("magician suction off")
    assert "restore" not in done.err, done
    job.close()
    ratio = lambda: lab.read_state("get PTPCommonParams")["velocity_ratio"]
    assert ratio() == 20, ratio()
    done = lab.run("magician pose")
    assert "the next command that moves or sets restores" in done.err, done
    assert ratio() == 20
    lab.run("magician stop")
    done = lab.run("magician move 10 0 0 --relative")
    assert done.code == 0 and "restored now" in done.err, done
    assert ratio() == 77, ratio()


def speeds_at_the_end(lab):
    lab.arm("max")
    lab.run("magician set PTPCommonParams velocity_ratio=77 acceleration_ratio=66")
    done = lab.run(f"{DRAW} --speed-ratio 20")
    assert done.code == 0, done
    now = lab.read_state("get PTPCommonParams")
    assert (now["velocity_ratio"], now["acceleration_ratio"]) == (77, 66), now


def first_interrupt_lifts(lab):
    terminal = drawing(lab)
    begun = time.monotonic()
    terminal.type_keys("\x03")
    terminal.wait_for("interrupted: the pen is up by 10.0 mm")
    assert terminal.wait_for_exit() == 130
    assert at_rest(lab)["z"] > PAPER + 9
    return f"{time.monotonic() - begun:.2f} s"


def second_interrupt_moves_nothing(lab):
    lab.arm("0.5")
    terminal = Terminal(lab, f"{DRAW} --lift 60")
    terminal.wait_for(r"[4-9]/\d+ steps done|[4-9] of \d+ steps done")
    terminal.type_keys("\x03")
    # A sooner second press would be taken for a bounce.
    time.sleep(0.55)
    terminal.type_keys("\x03")
    assert terminal.wait_for_exit() == 130
    pose = at_rest(lab)
    assert pose["z"] < PAPER + 59, pose
    return f"z {pose['z']}"


def stays_down(lab):
    terminal = drawing(lab, f"{DRAW} --stay")
    while lab.read_state("pose")["z"] > PAPER + 0.1:
        time.sleep(0.02)
    terminal.type_keys("\x03")
    assert terminal.wait_for_exit() == 130
    assert at_rest(lab)["z"] < PAPER + 1


def goes_on_after_a_stop(lab):
    lab.arm("5")
    terminal = Terminal(lab, BURN)
    while lab.read_state("pose")["x"] < 250 or lab.read_state("pose")["z"] > PAPER + 0.1:
        time.sleep(0.05)
    terminal.type_keys("\x03")
    assert terminal.wait_for_exit() == 130
    at_rest(lab)
    done = lab.run(f"{BURN} --resume --overlap 2 </dev/null")
    assert done.code == 0, done
    assert re.search(r"2\.\d mm are burnt twice", done.err), done


space_stops, s_stops = stops_with(" "), stops_with("s")


def a_person_is_asked(lab):
    lab.arm("20")
    terminal = Terminal(lab, "magician engrave burn.gcode --surface -50")
    terminal.wait_for(r"laser of the arm.*\?|go on\?|\[y/N\]|y/n")
    terminal.type_keys("n\n")
    assert terminal.wait_for_exit() == 2
    terminal = Terminal(lab, "magician engrave burn.gcode --surface -50")
    terminal.wait_for(r"laser of the arm.*\?|go on\?|\[y/N\]|y/n")
    terminal.type_keys("y\n")
    terminal.wait_for("step|left")
    terminal.type_keys("s")
    assert terminal.wait_for_exit() == 130


def a_laser_of_another_program_is_not_said_to_be_off(lab):
    lab.arm("5")
    job = Program(lab, f"{BURN} --json")
    job.wait_for_step(4)
    assert lab.read_state("info")["laser"] is None
    job.send({"do": "stop"})
    assert job.wait_for_exit() == 130
    assert lab.read_state("info")["laser"] is False
