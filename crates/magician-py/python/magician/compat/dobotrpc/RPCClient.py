"""Client of DobotLink, which programs patch so that it does not wait."""

from __future__ import annotations

__all__ = ["NetworkError", "RPCClient"]


class NetworkError(Exception):
    """Never raised here: errors of an arm are those of :mod:`magician.errors`."""


class RPCClient:
    """Client that always reports a connection and has none."""

    def __init__(self, ip: str = "127.0.0.1", port: int = 9090, *_: object, **__: object) -> None:
        self.ip, self.port = ip, port

    async def wait_for_connected(self) -> None:
        """Returns at once."""

    def is_connected(self) -> bool:
        """Returns True."""
        return True
