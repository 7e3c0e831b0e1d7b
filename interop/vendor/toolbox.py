"""Shared by the checks of the vendor's library: building libraries, compiling and running
programs."""

import os
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(HERE.parent))

TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
HOME = TARGET / "vendor"
HEADERS = ROOT / "crates" / "magician-capi" / "include"
FAMILIES = ("v1", "v2", "v3")
HOST = "x86_64-unknown-linux-gnu"
WARNINGS = ["-g", "-O1", "-Wall", "-Wextra", "-Werror"]
# Timeout of a program, s: longer than any of these runs, including those under valgrind. A program
# that hangs is ended and counts as a failure.
TIME_LIMIT = 900


def are_installed(*programs):
    """True if all of the programs are installed."""
    return all(shutil.which(program) for program in programs)


def cargo(*words, **environment):
    """Runs cargo and passes on its warnings and errors."""
    subprocess.run(["cargo", *words], cwd=ROOT, env={**os.environ, **environment}, check=True, stdin=subprocess.DEVNULL)


# Builds for these checks are not debugged: function names are enough, line tables are omitted.
LEAN = {"CARGO_PROFILE_DEV_DEBUG": "0"}


def build(*triples, families=FAMILIES, **environment):
    """Builds the libraries, for this system or for several others at once."""
    linkers = {"CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER": "aarch64-linux-gnu-gcc",
               "CARGO_TARGET_ARMV7_UNKNOWN_LINUX_GNUEABIHF_LINKER": "arm-linux-gnueabihf-gcc"}
    targets = [word for triple in triples for word in ("--target", triple)]
    cargo("build", "--quiet", "--locked", *packages(families), *targets, **linkers, **environment)


def packages(families):
    """Returns the arguments that select the crates of the families, for cargo."""
    return [word for family in families for word in ("--package", f"magician-capi-{family}")]


def build_sanitized(sanitizer, families=FAMILIES):
    """Builds the libraries with a sanitizer, for this system. Returns false if the toolchain
    cannot.

    Sanitizers are not yet stable in Rust, but their runtimes are part of the stable toolchain. The
    thread sanitizer must observe the standard library's locks too, so the standard library is built
    as well.
    """
    if not list(rust_libraries().glob(f"librustc-*_rt.{sanitizer[0]}san.a")):
        return False
    build_std = ["-Zbuild-std=std,panic_unwind"] if sanitizer == "thread" else []
    cargo("build", "--quiet", "--locked", *packages(families), "--target", HOST, *build_std, **LEAN, RUSTC_BOOTSTRAP="1",
          RUSTFLAGS=f"-Zsanitizer={sanitizer}", CARGO_TARGET_DIR=str(TARGET / f"vendor-{sanitizer}"))
    return True


def rust_libraries():
    """Returns the folder of the toolchain's own libraries for this system."""
    root = subprocess.run(["rustc", "--print", "sysroot"], check=True, capture_output=True, text=True).stdout.strip()
    return pathlib.Path(root, "lib", "rustlib", HOST, "lib")


def library(family, triple=None, folder=TARGET):
    """Returns the path at which cargo puts a family's library."""
    place = folder / triple / "debug" if triple else folder / "debug"
    windows = triple and "windows" in triple
    return place / (f"dobotdll_{family}.dll" if windows else f"libdobotdll_{family}.so")


def sanitized_library(family, sanitizer):
    """Returns the path of a family's library with a sanitizer."""
    return library(family, HOST, TARGET / f"vendor-{sanitizer}")


def stage_library(family, file, name, group="here"):
    """Copies a library to the name that programs load."""
    place = HOME / group / family / name
    place.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(file, place)
    return place


def generate_calls(family, xtask):
    """Generates the part of `every.c` that comes from the table. Returns its folder."""
    folder = HOME / "calls" / family
    folder.mkdir(parents=True, exist_ok=True)
    generated = subprocess.run([*xtask, "vendor-functions", "calls", family], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    # Written atomically, as another check may be reading it.
    temporary = folder / f"calls.{os.getpid()}"
    temporary.write_text(generated)
    temporary.replace(folder / "calls.h")
    return folder


def compile_program(source, family, *words, compiler="cc", name=None):
    """Compiles one of the sources here into a program for a family."""
    program = HOME / "programs" / family / (name or pathlib.Path(source).stem)
    program.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run([compiler, *WARNINGS, f"-DFAMILY={family[1:]}", f"-I{HEADERS / family}", HERE / source, "-o", program, *words],
                   check=True)
    return program


def run(*command, **environment):
    """Returns the status and all output. A program that does not end counts as status -1."""
    try:
        done = subprocess.run([str(word) for word in command], env={**os.environ, "MAGICIAN_LOG": "off", "MAGICIAN_PORT": "sim", **environment},
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=TIME_LIMIT)
    except subprocess.TimeoutExpired as late:
        return -1, (late.stdout or b"").decode(errors="replace") + f"no end after {TIME_LIMIT} s"
    return done.returncode, done.stdout.decode(errors="replace")


def verdict(checks, what, result, want=0):
    """Checks that a program ended as expected. Shows its output otherwise."""
    status, output = result
    passed = (status == want) if isinstance(want, int) else status in want
    last = output.strip().splitlines()[-1] if output.strip() else ""
    checks.ok(what, passed, last[:150] if passed else f"status {status}\n{output[-6000:]}")
    return passed
