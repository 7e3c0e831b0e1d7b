"""Kinds of point-to-point moves."""

from enum import Enum

__all__ = ["PTPMode"]


class PTPMode(Enum):
    """Path of a move and meaning of its four numbers."""

    JUMP_XYZ = 0
    """Up, across and down to a pose (mm, degrees)."""
    MOVJ_XYZ = 1
    """With the joints to a pose."""
    MOVL_XYZ = 2
    """In a straight line to a pose."""
    JUMP_ANGLE = 3
    """Up, across and down to joint angles (degrees)."""
    MOVJ_ANGLE = 4
    """With the joints to joint angles."""
    MOVL_ANGLE = 5
    """In a straight line to joint angles."""
    MOVJ_INC = 6
    """With the joints by joint angles."""
    MOVL_INC = 7
    """In a straight line by a distance."""
    MOVJ_XYZ_INC = 8
    """With the joints by a distance."""
    JUMP_MOVL_XYZ = 9
    """Up, across in a straight line and down to a pose."""
