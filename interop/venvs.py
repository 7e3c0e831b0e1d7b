"""Virtual environments with third-party libraries, under target/interop, pinned by hash."""

import fcntl
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()


def python_for(requirements):
    """Returns the interpreter with the library. The environment is made once, and again when the
    pins change."""
    if requirements is None:
        return sys.executable
    pins = (HERE / requirements).read_bytes()
    home = TARGET / "interop" / pathlib.Path(requirements).stem
    stamp, want = home / "stamp", hashlib.sha256(pins + sys.version.encode()).hexdigest()
    python = home / "bin" / "python"
    home.parent.mkdir(parents=True, exist_ok=True)
    # Sessions run in parallel, and some use the same library.
    with open(home.with_suffix(".lock"), "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (stamp.exists() and stamp.read_text() == want):
            shutil.rmtree(home, ignore_errors=True)
            subprocess.run([sys.executable, "-m", "venv", home], check=True)
            install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input", "--no-deps"]
            command = [*install, "--retries", "5", "--require-hashes", "--only-binary", ":all:", "-r", HERE / requirements]
            subprocess.run(command, check=True, timeout=600)
            stamp.write_text(want)
    return str(python)
