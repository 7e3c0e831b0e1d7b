"""pydobotlab's exceptions; ``__cause__`` is the :class:`magician.errors.Error` that says what."""

from __future__ import annotations


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
    """The arm has alarms: ``alarms`` has their names."""

    def __init__(self, alarms: list[str] | None = None, message: str = "") -> None:
        self.alarms = alarms or []
        super().__init__(message or f"the arm has an alarm: {', '.join(self.alarms)}")


class DobotKinematicError(DobotAlarmError):
    """A place is out of reach."""


class DobotOverspeedError(DobotAlarmError):
    """A joint is too fast."""


class DobotLostStepError(DobotAlarmError):
    """A joint has lost steps."""


class DobotSystemAlarmError(DobotAlarmError):
    """The controller has a fault."""
