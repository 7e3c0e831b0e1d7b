"""The arm for programs without asyncio: made of ``aio.py`` by ``tools/blocking.py``; change that."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ._magician import Core
from ._native import wait
from ._pictures import Picture
from .programs import Plan, Report, report_of
from .running import Progress, RunResult, Watcher, follow

__all__ = ["Arm", "Progress", "RunResult"]


class Arm:
    """A connected arm.

    Lengths are mm, angles degrees, times seconds. Every call ends: with its answer, or with an exception of
    :mod:`magician.errors` by its deadline. A ``with`` block that is left by an exception stops what the arm was told to do.
    """

    def __init__(self, core: Core) -> None:
        self._core = core

    @classmethod
    def connect(cls, port: str, *, timeout: float = 3.0, window: int = 1) -> Arm:
        """Connects to the arm at ``port``: ``"sim"`` for a virtual one, ``"/dev/ttyUSB0"``, ``"COM3"``, ``"udp:HOST"``."""
        return cls(wait(Core.connect(port, timeout=timeout, window=window)))

    def home(self) -> None:
        """Homes the arm and waits until it is there."""
        wait(self._core.home())

    def stop(self) -> None:
        """Stops the arm at once, whatever is going on, and empties its queue."""
        wait(self._core.stop())

    def close(self) -> None:
        """Ends the connection; what it set going stops."""
        wait(self._core.close())

    # Programs.

    def check(self, plan: Plan) -> Report:
        """Follows a plan from where this arm stands, with the settings that it has; moves nothing."""
        start = wait(self._core.start_of(plan._native))
        return report_of(plan._native.check(start))

    def preview(self, plan: Plan) -> Picture:
        """The picture of a plan, from where this arm stands; moves nothing."""
        start = wait(self._core.start_of(plan._native))
        return Picture(plan._native.preview(start, None, None))

    def run(
        self,
        program: Plan | Iterable[Any],
        *,
        progress: Watcher = False,
        first_step: int = 1,
        check: bool = True,
        keep: bool = False,
        require_homed: bool = False,
        allow_laser: bool = False,
        restore: bool = True,
    ) -> RunResult:
        """Has the arm do a plan, or commands, and waits for the end. All of it is checked before the first byte is sent.

        The queue is kept full enough that the arm never waits for the next command, and no fuller than that: at most two seconds
        of motion go on if this program dies. Whatever ends the wait early (Ctrl-C, a cancelled task, an exception in
        ``progress``) stops the arm first; a note on the exception tells how many steps are done.

        Args:
            program: A :class:`~magician.Plan`, or commands as :mod:`magician.words` makes them.
            progress: ``True`` shows a line on stderr; a function is called with a :class:`~magician.Progress` up to 20
                times a second.
            first_step: Begins there, counted from 1: sets what the steps before would have set, and goes there from above.
            check: Whether to refuse what the arm cannot do.
            keep: Whether to run first what an earlier program left in the queue.
            require_homed: Whether to refuse an arm that was not homed since it was switched on.
            allow_laser: Whether the laser of an arm that is not virtual may burn.
            restore: Whether speeds and heights of jumps that the plan changes are given back at its end.

        Raises:
            UnreachableError, InvalidInputError: The check refuses a step: which, why, and both values.
            AlarmError: An alarm holds the queue.
            ClosedError: A stop came first.
        """
        plan = program if isinstance(program, Plan) else Plan.of(program)
        how = {
            "first_step": first_step,
            "check": check,
            "keep": keep,
            "require_homed": require_homed,
            "allow_laser": allow_laser,
            "restore": restore,
            "watched": progress is not False,
        }
        begun = self._core.run(plan._native, how)
        return follow(self._core, begun, len(plan), progress)

    # Pictures.

    def picture(self) -> Picture:
        """The arm as it stands, from above and from the side."""
        return Picture(wait(self._core.snapshot()))

    def _repr_svg_(self) -> str:
        # A notebook waits for it, whatever kind of program this is.
        return self._core.snapshot().wait().svg
