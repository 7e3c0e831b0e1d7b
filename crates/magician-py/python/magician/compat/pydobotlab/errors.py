"""Exceptions of pydobotlab; ``__cause__`` is the :class:`magician.errors.Error` with the reason."""

from __future__ import annotations


class DobotError(Exception):
    """Base class of the failures of calls."""


class DobotConfigError(DobotError):
    """Wrong setting."""


class DobotConnectionError(DobotError):
    """No connection."""


class DobotPortInUseError(DobotConnectionError):
    """Another program has the port."""


class DobotPermissionError(DobotConnectionError):
    """No permission to open the port."""


class DobotProtocolError(DobotError):
    """Command not accepted by the arm."""


class DobotTimeoutError(DobotError):
    """No reply from the arm."""


class DobotAlarmError(DobotError):
    """Active alarms; ``alarms`` has their names."""

    def __init__(self, alarms: list[str] | None = None, message: str = "") -> None:
        self.alarms = alarms or []
        super().__init__(message or f"the arm has an alarm: {', '.join(self.alarms)}")


class DobotKinematicError(DobotAlarmError):
    """Target out of reach."""


class DobotOverspeedError(DobotAlarmError):
    """Joint too fast."""


class DobotLostStepError(DobotAlarmError):
    """Lost steps of a joint."""


class DobotSystemAlarmError(DobotAlarmError):
    """Fault of the controller."""
