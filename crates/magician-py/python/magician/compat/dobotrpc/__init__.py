"""Stand-in for the parts of DobotRPC that programs for DobotEDU use. It connects to nothing."""

from . import RPCClient
from .RPCClient import NetworkError

__all__ = ["NetworkError", "RPCClient"]
