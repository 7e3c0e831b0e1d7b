"""DobotRPC, as far as programs for DobotEDU touch it: there is nothing to connect to."""

from . import RPCClient
from .RPCClient import NetworkError

__all__ = ["NetworkError", "RPCClient"]
