"""Pauses, resumes and kills a job of the command, and continues it from Python:
session_jobs.py PTY UDP TCP SPEED MAGICIAN

The job is on the pseudo-terminal. While it is paused, another program moves the arm over TCP.
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile

import magician

from checks import Checks

ROUNDS = 40
CORNERS = [(220.0, -40.0), (220.0, 40.0), (250.0, 40.0), (250.0, -40.0)]
LAST = (*CORNERS[-1], 20.0)


def plan_file(home):
    """Writes the plan file for command and Python. Returns its path and number of steps."""
    steps = [{"move": [x, y, 20.0, 0.0], "by": "line"} for x, y in CORNERS * ROUNDS]
    path = home / "square.plan.json"
    path.write_text(json.dumps({"format": "magician-plan", "version": 1, "title": "square", "steps": steps}))
    return path, len(steps)


class Command:
    """Process of `magician run`, controlled by lines of JSON on stdin and stdout."""

    def __init__(self, program, port, path):
        command = [program, "--port", port, "--json", "run", path]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def send(self, order):
        self.process.stdin.write(json.dumps({"do": order}) + "\n")
        self.process.stdin.flush()

    def wait_for_event(self, event, step=0):
        """Reads until an event, at a given step or later."""
        for line in self.process.stdout:
            message = json.loads(line)
            if message.get("event") == event and message.get("step", step) >= step:
                return message
        raise AssertionError(f"the command ended before it said {event!r}")


def run_verb(program, port, *arguments):
    """Returns the output of a command as JSON."""
    command = [program, "--port", port, "--json", *arguments]
    return json.loads(subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=True).stdout)


def position(pose):
    return pose.x, pose.y, pose.z


def main():
    pty, tcp, program = sys.argv[1], f"tcp:127.0.0.1:{sys.argv[3]}", sys.argv[5]
    checks = Checks()
    with tempfile.TemporaryDirectory() as folder:
        home = pathlib.Path(folder)
        os.environ["XDG_STATE_HOME"] = str(home / "state")
        path, steps = plan_file(home)
        run_verb(program, pty, "home")
        job = Command(program, pty, path)
        job.wait_for_event("progress", 20)
        job.send("pause")
        checks.equal("the command says that it is paused", job.wait_for_event("paused"), {"event": "paused", "part": None, "reason": "person"})
        queue = run_verb(program, tcp, "queue")
        checks.equal("nothing of it is in the arm", queue["left_space"], 32)
        run_verb(program, tcp, "move", "0", "0", "30", "--relative")
        job.send("resume")
        checks.equal("and that it goes on", job.wait_for_event("resumed"), {"event": "resumed"})
        killed_at = job.wait_for_event("progress", 60)["step"]
        job.process.kill()
        job.process.wait()
        checks.ok("it is killed in its middle", 60 <= killed_at < steps, killed_at)
        with magician.Arm(pty) as arm:
            plan = magician.load(path)
            result = arm.run(plan, resume=True)
            checks.ok("Python goes on where it was", 0 < result.steps <= steps - 60, result.steps)
            checks.near("and comes to its end", position(arm.pose()), LAST)
            try:
                arm.run(plan, resume=True)
                checks.ok("nothing is left to resume", False)
            except magician.Error as error:
                checks.ok("nothing is left to resume", "nothing to resume" in str(error), error)
            job = arm.start(plan)
            while job.progress.done < 10:
                arm.pose()
            job.pause()
            checks.equal("a job of Python's is paused", (job.state, arm.left_space()), ("paused", 32))
            done = job.progress.done
            arm.perform([magician.words.line_by(dz=10)])
            job.resume()
            while job.progress.done < done + 10:
                arm.pose()
            job.stop()
            try:
                job.wait()
                checks.ok("it is stopped", False)
            except magician.errors.ClosedError as error:
                checks.ok("it is stopped", True, error)
        last = subprocess.run(
            [program, "--port", pty, "--json", "run", path, "--resume"], stdin=subprocess.DEVNULL, capture_output=True, check=True
        )
        summary = json.loads(last.stdout.splitlines()[-1])
        checks.ok("the command goes on where Python was", summary["first_step"] > done, summary["first_step"])
    checks.finish()


if __name__ == "__main__":
    main()
