"""pydobotlab's exceptions; ``__cause__`` is the :class:`magician.errors.Error` that says what."""

from __future__ import annotations

from ... import errors as ours


class DobotError(Exception):
    """Something could not be done."""


class DobotConfigError(DobotError):
    """A setting is wrong."""


class DobotConnectionError(DobotError):
    """There is no connection."""


class DobotPortInUseError(DobotConnectionError):
    """Somebody else has the port."""


class DobotPermissionError(DobotConnectionError):
    """The port may not be opened."""


class DobotProtocolError(DobotError):
    """The arm does not take this."""


class DobotTimeoutError(DobotError):
    """The arm did not answer."""


class DobotAlarmError(DobotError):
    """The arm has an alarm."""


class DobotKinematicError(DobotAlarmError):
    """A place is out of reach."""


class DobotOverspeedError(DobotAlarmError):
    """A joint is too fast."""


class DobotLostStepError(DobotAlarmError):
    """A joint has lost steps."""


class DobotSystemAlarmError(DobotAlarmError):
    """The controller has a fault."""


def fault(error: ours.Error) -> DobotError:
    """What a program for pydobotlab expects."""
    kind: type[DobotError] = DobotProtocolError
    if isinstance(error, ours.AlarmError):
        kind = DobotAlarmError
    elif isinstance(error, ours.UnreachableError):
        kind = DobotKinematicError
    elif isinstance(error, (ours.PortError, ours.ClosedError)):
        kind = DobotConnectionError
    elif isinstance(error, TimeoutError):
        kind = DobotTimeoutError
    return kind(str(error))
