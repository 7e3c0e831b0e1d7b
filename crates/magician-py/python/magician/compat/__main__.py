"""Runs a script that was written for pydobot, pydobotplus, pydobot2 or DobotDllType, as it is.

    python -m magician.compat script.py [argument...]
    python -m magician.compat -m module [argument...]

The script imports what it always imports, and gets this package. It needs none of those libraries, and no pyserial for
the list of ports.

options, before the script:
  --port PORT          the arm to connect to, whatever port the script names: sim, /dev/ttyUSB0, COM3, udp:HOST.
                       MAGICIAN_PORT does the same; MAGICIAN_PORT_COM3 does it for the port COM3 alone
  --pydobot NAME       what `import pydobot` means: pydobot, pydobot2 or pydobotplus
                       (otherwise the one that is installed, or the one whose names the script uses)
  --dobotdll FAMILY    the family of DobotDllType: v1, v2 or v3
                       (otherwise that of the file beside the script, or what its calls look like)

Ctrl-C, and an exception that ends the script, stop the arm. A script that ends well leaves it as it is.
"""

from __future__ import annotations

import io
import os
import runpy
import sys
import traceback
import types
from importlib.util import find_spec
from pathlib import Path

from . import _line, _modules, _script

USAGE = 2
FAMILIES = ("v1", "v2", "v3")


def main() -> int:
    """The exit status."""
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
    path = Path(arguments[0])
    folder = Path() if module else path.parent.resolve()
    # As Python does it: the folder of the script, or the current one, takes the place of this module's.
    sys.path[0] = os.getcwd() if module else str(folder)
    if module:
        spec = find_spec(arguments[0])
        path = Path(spec.origin if spec and spec.origin else "")
    source = ""
    try:
        with io.open_code(str(path)) as file:
            code = file.read()
        source = code.decode("utf-8", "replace")
    except OSError as error:
        if not module:
            return _usage(f"{arguments[0]} cannot be read: {error.strerror}")
        code = b""
    _line.send_elsewhere(given.get("--port") or os.environ.get("MAGICIAN_PORT"))
    _modules.install(
        given.get("--pydobot") or _script.which_pydobot(source),
        given.get("--dobotdll") or _script.which_dobotdll(source, folder),
    )
    sys.argv[:] = arguments
    try:
        if module:
            runpy.run_module(arguments[0], run_name="__main__", alter_sys=True)
        else:
            _execute(compile(code, str(path), "exec"), str(path))
    except SystemExit:
        raise
    except KeyboardInterrupt as interrupt:
        _stop_all("interrupted", interrupt)
        raise
    except BaseException as error:
        _stop_all("ended by an exception", error)
        _show(error)
        return 1
    return 0


def _execute(code: types.CodeType, path: str) -> None:
    main = types.ModuleType("__main__")
    main.__dict__.update(__file__=path, __builtins__=__builtins__, __cached__=None, __spec__=None, __package__=None)
    sys.modules["__main__"] = main
    exec(code, main.__dict__)


def _show(error: BaseException) -> None:
    """The traceback as the script alone would have it."""
    here = os.path.dirname(os.path.abspath(__file__))
    inner = error.__traceback__
    while inner is not None and inner.tb_next is not None:
        name = inner.tb_frame.f_code.co_filename
        if os.path.dirname(os.path.abspath(name)) != here and "runpy" not in name:
            break
        inner = inner.tb_next
    traceback.print_exception(type(error), error, inner)


def _stop_all(why: str, because: BaseException) -> None:
    for line in _line.opened():
        print(f"magician.compat: {why}, so the arm at {line.name} is stopped", file=sys.stderr)
        line.stop(because)


if __name__ == "__main__":
    sys.exit(main())
