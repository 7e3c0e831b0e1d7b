"""The client of DobotLink, which programs patch so that it does not wait."""

from __future__ import annotations

__all__ = ["NetworkError", "RPCClient"]


class NetworkError(Exception):
    """Is not raised here: an arm's errors are those of :mod:`magician.errors`."""


class RPCClient:
    """Connected without a connection."""

    def __init__(self, ip: str = "127.0.0.1", port: int = 9090, *_: object, **__: object) -> None:
        self.ip, self.port = ip, port

    async def wait_for_connected(self) -> None:
        """Returns at once."""

    def is_connected(self) -> bool:
        """It is, as far as programs ask."""
        return True
