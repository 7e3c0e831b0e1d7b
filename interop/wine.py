"""Separate Windows environment: Wine, with a replacement DLL for the features it lacks.

`interop/wine.py PROGRAM ARGUMENT...` runs one program there.
"""

import os
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
COMPILER = "x86_64-w64-mingw32-gcc"
TIME_LIMIT = 300


def tool(*names):
    """Returns the first of these programs that is installed. Debian installs Wine's programs
    outside PATH."""
    for name in names:
        if found := shutil.which(name) or shutil.which(name, path="/usr/lib/wine"):
            return found
    sys.exit(f"interop: there is no {' or '.join(names)}")


class Windows:
    """Separate Wine prefix, and the folder of the programs to run."""

    def __init__(self):
        self.home = TARGET / "windows"
        self.home.mkdir(parents=True, exist_ok=True)
        self.wine, self.server = tool("wine64", "wine"), tool("wineserver")
        quiet = {"WINEDEBUG": "-all", "WINEDLLOVERRIDES": "mscoree,mshtml="}
        self.environment = {**os.environ, **quiet, "WINEPREFIX": str(self.home / "prefix"), "NO_COLOR": "1"}
        stand_in = self.home / "bcryptprimitives.dll"
        command = [tool(COMPILER), "-shared", "-O1", "-Wall", "-Wextra", "-Werror", "-o", stand_in, HERE / "windows.c"]
        subprocess.run([*command, "-ladvapi32"], check=True)
        self.process = None

    def start(self):
        """Starts Wine. Also used to restart it after `stop`, because Wine reads its list of ports
        only at the start."""
        # In the foreground and without output: in Debian's build the server lists its open handles
        # on stderr when it ends.
        command = [self.server, "-f", "-p"]
        self.process = subprocess.Popen(command, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        subprocess.run([self.wine, "wineboot"], env=self.environment, check=True, timeout=300,
                       stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def stop(self):
        """Ends all processes of the prefix."""
        subprocess.run([self.server, "-k"], env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def register(self, key, name, text):
        """Writes a string into the registry."""
        command = [self.wine, "reg", "add", key, "/v", name, "/d", text, "/f"]
        subprocess.run(command, env=self.environment, check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, timeout=300)

    def copy_in(self, file, name):
        """Copies a file next to the replacement DLL, where Windows looks for a program's
        libraries."""
        return pathlib.Path(shutil.copyfile(file, self.home / name))

    def run(self, program, *arguments):
        """Runs a program. Returns its status and output, with line endings unchanged."""
        return run([self.wine, program, *arguments], self.environment)


def run(command, environment=None):
    """Runs a command. Returns its status, stdout and stderr."""
    done = subprocess.run(command, env=environment, stdin=subprocess.DEVNULL, capture_output=True, timeout=TIME_LIMIT)
    return done.returncode, done.stdout.decode(), done.stderr.decode()


def main():
    """Runs a program, and passes on its output and status."""
    windows = Windows()
    program = windows.copy_in(sys.argv[1], pathlib.Path(sys.argv[1]).name)
    windows.start()
    try:
        status, out, err = windows.run(program, *sys.argv[2:])
    finally:
        windows.stop()
    sys.stdout.write(out)
    sys.stderr.write(err)
    sys.exit(status)


if __name__ == "__main__":
    main()
