"""Numbers of the protocol under pydobot's names."""

from . import CommunicationProtocolIDs, ControlValues, ptpMode
from .ptpMode import PTPMode

__all__ = ["CommunicationProtocolIDs", "ControlValues", "PTPMode", "ptpMode"]
