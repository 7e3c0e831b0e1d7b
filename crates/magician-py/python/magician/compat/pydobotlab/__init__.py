"""Stand-in for pydobotlab: the 28 calls of DobotLab, and its own.

Calls go to the arm directly. There is no broker, and several programs at a virtual arm need none. A call that the arm
queues returns ``True`` once it is done.
"""

from .alarms import Alarm, AlarmSet
from .device import Dobot, Magician, Pose
from .discovery import (
    KNOWN_DOBOT_USB_IDS,
    DiscoveredDobot,
    Discovery,
    PortInfo,
    ProbeFailure,
    discover,
    discover_with_diagnostics,
    find_free_port,
    is_dobot,
    is_port_in_use,
    list_ports,
)
from .errors import (
    DobotAlarmError,
    DobotConfigError,
    DobotConnectionError,
    DobotError,
    DobotKinematicError,
    DobotLostStepError,
    DobotOverspeedError,
    DobotPermissionError,
    DobotPortInUseError,
    DobotProtocolError,
    DobotSystemAlarmError,
    DobotTimeoutError,
)
from .protocol import CommandID, EndEffectorType, IOFunction, JOGCmd, JogMode, PTPMode

__all__ = [
    "KNOWN_DOBOT_USB_IDS",
    "Alarm",
    "AlarmSet",
    "CommandID",
    "DiscoveredDobot",
    "Discovery",
    "Dobot",
    "DobotAlarmError",
    "DobotConfigError",
    "DobotConnectionError",
    "DobotError",
    "DobotKinematicError",
    "DobotLostStepError",
    "DobotOverspeedError",
    "DobotPermissionError",
    "DobotPortInUseError",
    "DobotProtocolError",
    "DobotSystemAlarmError",
    "DobotTimeoutError",
    "EndEffectorType",
    "IOFunction",
    "JOGCmd",
    "JogMode",
    "Magician",
    "PTPMode",
    "PortInfo",
    "Pose",
    "ProbeFailure",
    "discover",
    "discover_with_diagnostics",
    "find_free_port",
    "is_dobot",
    "is_port_in_use",
    "list_ports",
]
