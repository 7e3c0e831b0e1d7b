"""Which axis, up or down."""

from .._enums import JogCmd

__all__ = ["JogCmd"]
