"""Working folder, virtual arms on TCP (which count as real), and the command as run by a user or a
program."""

import contextlib
import errno
import fcntl
import json
import os
import pty
import re
import select
import shutil
import signal
import struct
import subprocess
import tempfile
import termios
import threading
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
SAMPLES = ROOT / "crates/magician-program/samples"
# Timeout of operations that should complete at once, on a machine under load, s.
TIMEOUT = 60


class ProcessResult:
    """A command that has ended."""

    def __init__(self, code, out, err):
        self.code, self.out, self.err = code, out, err

    @property
    def lines(self):
        """Returns the JSON objects of stdout, one per line."""
        return [json.loads(line) for line in self.out.splitlines() if line.startswith("{")]

    @property
    def one(self):
        """Returns the last object, including one that spans several lines."""
        try:
            return json.loads(self.out)
        except ValueError:
            return self.lines[-1]

    @property
    def error(self):
        return next(json.loads(line)["error"] for line in self.err.splitlines() if line.startswith('{"error"'))

    def __repr__(self):
        return f"exit {self.code}\n{self.out[-1500:]}\n{self.err[-1500:]}"


class Lab:
    """Working folder with the files of promises.toml and the samples, without a user's settings."""

    def __init__(self, magician, files):
        self.magician = str(Path(magician).resolve())
        self.dir = Path(tempfile.mkdtemp(prefix="workshop-"))
        for name, text in files.items():
            (self.dir / name).write_text(text)
        for sample in SAMPLES.iterdir():
            shutil.copy(sample, self.dir)
        programs = self.dir / ".bin"
        programs.mkdir()
        (programs / "magician").symlink_to(self.magician)
        inherited = {name: os.environ[name] for name in ("HOME", "LANG", "LC_ALL", "TMPDIR") if name in os.environ}
        self.environment = {
            **inherited,
            "PATH": f"{programs}:{os.environ['PATH']}",
            "TERM": "xterm-256color",
            "NO_COLOR": "1",
            "MAGICIAN_CONFIG": str(self.dir / "settings/config.toml"),
            "XDG_STATE_HOME": str(self.dir / ".state"),
            "MAGICIAN_PORT": "sim",
        }
        self.arms = []

    def arm(self, speed="max", homed=True, recorded=False):
        """Starts a virtual arm on TCP, which this folder's commands use from now on."""
        arm = Arm(self, speed, self.dir / "arm.mcap" if recorded else None)
        self.arms.append(arm)
        self.environment["MAGICIAN_PORT"] = f"tcp:127.0.0.1:{arm.port}"
        if homed:
            done = self.run("magician home")
            if done.code:
                raise AssertionError(done)
        return arm

    def run(self, command, stdin=None):
        """Runs a shell line without a terminal, and without stdin unless it is given."""
        process = subprocess.Popen(
            ["bash", "-c", command],
            cwd=self.dir,
            env=self.environment,
            stdin=subprocess.DEVNULL if stdin is None else subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        try:
            out, err = process.communicate(stdin, timeout=2 * TIMEOUT)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            out, err = process.communicate()
            raise AssertionError(f"`{command}` does not end:\n{out}\n{err}")
        return ProcessResult(process.returncode, out, err)

    def read_state(self, what):
        """Returns the state reported by the arm, over a connection of its own."""
        return self.run(f"magician {what} --json").one

    def written_commands(self, trace):
        """Returns the commands in a trace that were queued or set something, as (name,
        parameters)."""
        found = self.run(f"magician decode {trace} --json").lines
        return [(one["command"], one["params"]) for one in found if one.get("direction") == "request" and one.get("write")]

    def close(self):
        for arm in self.arms:
            arm.end()
        shutil.rmtree(self.dir, ignore_errors=True)


class Arm:
    """`magician sim` on TCP."""

    def __init__(self, lab, speed, recording):
        command = [lab.magician, "sim", "--tcp", "127.0.0.1:0", "--speed", speed]
        self.recording = recording
        if recording:
            command += ["--record", str(recording)]
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=lab.environment)
        if self.process.stdout.readline() != "ready\n":
            raise AssertionError(self.process.stderr.read())
        line = next(line for line in self.process.stderr if line.startswith("serving tcp:"))
        self.port = int(line.rsplit(":", 1)[1])
        threading.Thread(target=self.process.stderr.read, daemon=True).start()

    def end(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(TIMEOUT)
        self.process.kill()
        self.process.wait()


class Terminal:
    """A command at a terminal of 100 by 30, with job control as a shell provides it."""

    def __init__(self, lab, command, stdin=None):
        self.lab, self.seen, self.at = lab, "", 0
        self.pid, self.fd = pty.fork()
        if self.pid == 0:
            os.chdir(lab.dir)
            if stdin:
                os.dup2(os.open(stdin, os.O_RDONLY), 0)
            os.execvpe("bash", ["bash", "-c", f"exec {command}"], lab.environment)
        fcntl.ioctl(self.fd, termios.TIOCSWINSZ, struct.pack("HHHH", 30, 100, 0, 0))
        self.status, self.original_modes = None, termios.tcgetattr(self.fd)[3]

    def _read(self, seconds):
        if not select.select([self.fd], [], [], seconds)[0]:
            return True
        try:
            data = os.read(self.fd, 65536)
        except OSError as error:
            if error.errno != errno.EIO:
                raise
            data = b""
        self.seen += data.decode(errors="replace")
        return bool(data)

    def wait_for(self, pattern, timeout=TIMEOUT):
        """Reads until a pattern is found after the previous match."""
        end = time.monotonic() + timeout
        while not (found := re.compile(pattern, re.S).search(self.seen, self.at)):
            if time.monotonic() > end or not self._read(0.2):
                raise AssertionError(f"no {pattern!r} in {self.seen[self.at:][-1500:]!r}")
        self.at = found.end()
        return found

    def type_keys(self, keys):
        os.write(self.fd, keys.encode())

    def signal(self, name):
        os.kill(self.pid, getattr(signal, name))

    def wait_for_suspend(self):
        """Waits until the command has suspended itself (SIGTSTP)."""
        end = time.monotonic() + TIMEOUT
        while time.monotonic() < end:
            pid, status = os.waitpid(self.pid, os.WNOHANG | os.WUNTRACED)
            if pid and os.WIFSTOPPED(status):
                return
            if pid:
                self.status = os.waitstatus_to_exitcode(status)
                raise AssertionError(f"it has ended: {self.seen}")
            self._read(0.01)
        raise AssertionError(f"it does not stop: {self.seen}")

    def is_restored(self):
        """True if the terminal is back in line mode with echo."""
        modes = termios.tcgetattr(self.fd)[3]
        return modes & termios.ICANON and modes & termios.ECHO

    def wait_for_exit(self, timeout=TIMEOUT):
        """Reads to the end of the command and returns its status."""
        end = time.monotonic() + timeout
        while self.status is None:
            if time.monotonic() > end:
                raise AssertionError(f"it does not end: {self.seen[-1500:]}")
            self._read(0.02)
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                self.status = os.waitstatus_to_exitcode(status)
        while self._read(0) and select.select([self.fd], [], [], 0)[0]:
            pass
        return self.status

    def close(self):
        if self.status is None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, signal.SIGKILL)
                os.waitpid(self.pid, 0)
        os.close(self.fd)


class Program:
    """A command with `--json`, controlled by lines on stdin."""

    def __init__(self, lab, command):
        self.process = subprocess.Popen(
            ["bash", "-c", f"exec {command}"],
            cwd=lab.dir,
            env=lab.environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.events, self.changed, self.err = [], threading.Condition(), ""
        self.at = 0
        self.listener = threading.Thread(target=self._read_events, daemon=True)
        self.listener.start()
        threading.Thread(target=self._read_stderr, daemon=True).start()

    def _read_events(self):
        for line in self.process.stdout:
            with self.changed:
                self.events.append((time.monotonic(), json.loads(line)))
                self.changed.notify_all()

    def _read_stderr(self):
        for line in self.process.stderr:
            self.err += line

    def wait_for_event(self, **fields):
        """Waits for the next object with these fields."""

        def found():
            for at, (_, event) in enumerate(self.events[self.at :], self.at):
                if all(event.get(name) == value for name, value in fields.items()):
                    return at
            return None

        with self.changed:
            if not self.changed.wait_for(lambda: found() is not None, TIMEOUT):
                raise AssertionError(f"it does not say {fields}: {self.events[-5:]} {self.err}")
            self.at = found() + 1
            return self.events[self.at - 1][1]

    def wait_for_step(self, step):
        """Waits until a number of steps is done."""
        while self.wait_for_event(event="progress")["step"] < step:
            pass

    def send(self, line):
        self.process.stdin.write((line if isinstance(line, str) else json.dumps(line)) + "\n")
        self.process.stdin.flush()

    def wait_for_exit(self):
        code = self.process.wait(TIMEOUT)
        self.listener.join(TIMEOUT)
        return code

    def close(self):
        self.process.kill()
        self.process.wait()


def mcap_messages(path):
    """Returns the messages of an uncompressed MCAP file by topic, as (seconds on the arm's clock,
    value)."""
    data, channels, topics = Path(path).read_bytes(), {}, {}

    def records(data, at):
        while at + 9 <= len(data):
            kind, size = struct.unpack_from("<BQ", data, at)
            yield kind, data[at + 9 : at + 9 + size]
            at += 9 + size

    def message(kind, body):
        if kind == 4:
            number, _, size = struct.unpack_from("<HHI", body)
            channels[number] = body[8 : 8 + size].decode()
        elif kind == 5:
            number, _, logged = struct.unpack_from("<HIQ", body)
            topics.setdefault(channels[number], []).append((logged / 1e9, json.loads(body[22:])))

    for kind, body in records(data[:-8], 8):
        if kind == 6:
            (compression_length,) = struct.unpack_from("<I", body, 28)
            assert not compression_length, "the recording is compressed"
            for inner in records(body[40:], 0):
                message(*inner)
        else:
            message(kind, body)
    return topics
