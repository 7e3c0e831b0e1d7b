"""Runs an unchanged script that was written for another library of the arm: pydobot, pydobotplus, pydobot2, pydobotpp,
pydobotlab, dobotapi, dobotWrapperPy, DobotEDU, DobotDllType, the vendor's C library by ctypes, or pyserial alone.

    python -m magician.compat script.py [argument...]
    python -m magician.compat -m module [argument...]

The script's imports of those libraries get this package. None of them is needed, nor pyserial for the list of ports.

options, before the script:
  --port PORT          connect to this arm instead of the port that the script names: sim, /dev/ttyUSB0, COM3, udp:HOST.
                       MAGICIAN_PORT does the same; MAGICIAN_PORT_COM3 does it for the port COM3 alone
  --pydobot NAME       meaning of `import pydobot`: pydobot, pydobot2 or pydobotplus
                       (default: the installed one, or the one whose names the script and its modules use)
  --dobotdll FAMILY    family of DobotDllType: v1, v2 or v3
                       (default: that of the file that is imported or beside the script, or by the calls)

Ctrl-C, even if the script catches it, and an exception that ends the script stop the arm. After a script that ends
normally the arm is left as it is.
"""

from __future__ import annotations

import atexit
import importlib.util
import io
import os
import runpy
import signal
import sys
import types
from collections.abc import Mapping, Sequence
from importlib.machinery import PathFinder
from pathlib import Path

from . import _line, _modules, _processes, _program, _script

USAGE = 2
FAMILIES = ("v1", "v2", "v3")


def main() -> int:
    """Runs the command line. Returns the exit status."""
    choices = {"--port": None, "--pydobot": _modules.PYDOBOTS, "--dobotdll": FAMILIES}
    given: dict[str, str] = {}
    arguments = sys.argv[1:]
    while arguments and arguments[0].startswith("-") and arguments[0] != "-m":
        option, equals, value = arguments.pop(0).partition("=")
        if option in ("-h", "--help"):
            print(__doc__)
            return 0
        if option not in choices:
            return _usage(f"there is no option {option}")
        if not equals:
            if not arguments:
                return _usage(f"{option} needs a value")
            value = arguments.pop(0)
        among = choices[option]
        if among is not None and value not in among:
            return _usage(f"{option} is one of {', '.join(among)}")
        given[option] = value
    module = arguments[:1] == ["-m"]
    arguments = arguments[module:]
    if not arguments:
        return _usage("there is no script")
    return _run(arguments, module, given)


def _usage(message: str) -> int:
    print(f"magician.compat: {message}; `python -m magician.compat --help` says what there is", file=sys.stderr)
    return USAGE


def _run(arguments: list[str], module: bool, given: dict[str, str]) -> int:
    # Like Python: the folder of the script, or the current one, replaces this module's.
    path = _find_file(arguments[0]) if module else Path(os.path.abspath(arguments[0]))
    folder = Path() if module else Path(arguments[0]).parent.resolve()
    sys.path[0] = os.getcwd() if module else str(folder)
    if path is None:
        print(f"magician.compat: there is no module {arguments[0]}", file=sys.stderr)
        return 1
    try:
        with io.open_code(str(path)) as file:
            code = file.read()
    except OSError as error:
        if not module:
            return _usage(f"{arguments[0]} cannot be read: {error.strerror}")
        code = b""
    program = _program.find_modules(path, _text(code), folder)
    copies = {name: "\n".join(map(_program.text, files)) for name, files in program.copies.items()}
    pydobot = given.get("--pydobot") or _script.which_pydobot(*program.sources, copy=copies.get("pydobot", ""))
    chosen = _processes.Replacement(
        given.get("--port") or os.environ.get("MAGICIAN_PORT"),
        pydobot,
        given.get("--dobotdll") or _script.which_dobotdll(program.sources, folder, program.wrappers),
        program.packages,
        own=[] if "--pydobot" in given else _modules.needed_copies(copies, program.sources, pydobot),
        wrappers=program.wrappers,
    )
    _processes.install_stand_ins(chosen)
    _processes.install_in_children(chosen, program.sources)
    sys.argv[:] = arguments
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupted)
    try:
        if module:
            runpy.run_module(arguments[0], run_name="__main__", alter_sys=True)
        else:
            # The script must not inherit this file's `__future__` imports.
            given_names = _modules.dobotlab_globals() if _script.expects_magician(program.sources[0]) else {}
            _execute(compile(code, str(path), "exec", dont_inherit=True), str(path), given_names)
    except SystemExit:
        raise
    except KeyboardInterrupt as interrupt:
        _stop_all("interrupted", interrupt)
        theirs = sys.excepthook
        sys.excepthook = lambda kind, error, trace: theirs(kind, *_without_runner_frames(error))
        raise
    except BaseException as error:
        _stop_all("ended by an exception", error)
        sys.excepthook(type(error), *_without_runner_frames(error))
        return 1
    return 0


def _find_file(name: str) -> Path | None:
    """Finds the file of a module without running its packages; ``None`` if there is none."""
    paths: Sequence[str] = [os.getcwd(), *sys.path[1:]]
    parts = name.split(".")
    origin = ""
    for at in range(len(parts)):
        spec = PathFinder.find_spec(".".join(parts[: at + 1]), paths)
        if spec is None:
            return None
        origin, paths = spec.origin or "", spec.submodule_search_locations or []
    main = PathFinder.find_spec(f"{name}.__main__", paths)
    return Path((main and main.origin) or origin)


def _text(code: bytes) -> str:
    """Reads a program as text, in its declared encoding, or as UTF-8 with replacements if that fails."""
    try:
        return importlib.util.decode_source(code)
    except (SyntaxError, UnicodeDecodeError):
        return code.decode("utf-8", "replace")


def _execute(code: types.CodeType, path: str, names: Mapping[str, object]) -> None:
    main = types.ModuleType("__main__")
    main.__dict__.update(names)
    main.__dict__.update(__file__=path, __builtins__=__builtins__, __cached__=None, __spec__=None, __package__=None)
    sys.modules["__main__"] = main
    # After the script's own exit handlers and before this package's, which closes the connections.
    atexit.register(_destroy, main.__dict__)
    try:
        exec(code, main.__dict__)
    except BaseException:
        # Stop the arm and leave it stopped.
        atexit.unregister(_destroy)
        raise


def _destroy(names: dict[str, object]) -> None:
    """Runs destructors while the connection is still open: many programs home the arm in one."""
    for name in [name for name, value in names.items() if hasattr(type(value), "__del__")]:
        del names[name]


def _without_runner_frames(error: BaseException) -> tuple[BaseException, types.TracebackType | None]:
    """Removes the frames of this runner from an exception's traceback."""
    here = os.path.dirname(os.path.abspath(__file__))
    trace = error.__traceback__
    while trace is not None:
        name = trace.tb_frame.f_code.co_filename
        if os.path.dirname(os.path.abspath(name)) != here and "runpy" not in name:
            break
        trace = trace.tb_next
    at = trace
    while at is not None and at.tb_next is not None:
        if at.tb_next.tb_frame.f_code is _interrupted.__code__:
            at.tb_next = None
        else:
            at = at.tb_next
    return error.with_traceback(trace), trace


def _interrupted(number: int, frame: types.FrameType | None) -> None:
    """Handles Ctrl-C: stops the arms, even if the script catches the interrupt and sends nothing more."""
    for line in _line.opened():
        line.interrupted()
    signal.default_int_handler(number, frame)


def _stop_all(why: str, because: BaseException) -> None:
    for line in _line.opened():
        print(f"magician.compat: {why}, so the arm at {line.name} is stopped", file=sys.stderr)
        line.stop(because)


if __name__ == "__main__":
    sys.exit(main())
