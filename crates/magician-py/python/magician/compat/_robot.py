"""Common base of the three libraries: one method for every frame that they send."""

from __future__ import annotations

import struct
import warnings
from enum import Enum
from typing import Any

from ..errors import Error
from ._line import GET, QUEUED, SET, Line
from ._message import Message
from ._port import Port

__all__ = ["Robot"]


def floats(*values: float) -> bytes:
    """Encodes numbers as 32-bit floats."""
    return struct.pack(f"<{len(values)}f", *values)


def switch(enable: object, name: str) -> bytes:
    """Returns the control byte and level of a tool. Only ``True`` itself switches on, as in the libraries."""
    if enable is not True and enable:
        warnings.warn(f"{name}({enable!r}) switches off, as it always did: write {name}(True)", stacklevel=4)
    return bytes((1, enable is True))


class Robot:
    """Connected arm. Every method sends one frame and returns the reply.

    Programs subclass the arms of these libraries and add attributes of any name. Members that the libraries do not have
    are therefore called ``_magician_…`` here.
    """

    _magician_line: Line
    _magician_port: Port

    def _magician_open(self, port: str | None) -> None:
        try:
            self._magician_line = Line(port)
        except Error as error:
            raise self._magician_fault(error) from error
        self._magician_port = Port(self._magician_line)
        self._magician_answer: Message | None = None

    def __getattr__(self, name: str) -> Any:
        # A subclass that opens the port itself and does not call this constructor connects on first use.
        if name in ("_magician_line", "_magician_port", "_magician_answer"):
            theirs = self.__dict__.get("_ser") or self.__dict__.get("ser")
            self._magician_open(getattr(theirs, "port", None))
            return self.__dict__[name]
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}", name=name, obj=self)

    def _magician_setup(self) -> None:
        """Sends what the libraries send to every arm after connecting."""
        self._set_queued_cmd_start_exec()
        self._set_queued_cmd_clear()
        self._set_ptp_joint_params(200, 200, 200, 200, 200, 200, 200, 200)
        self._set_ptp_coordinate_params(velocity=200, acceleration=200)
        self._set_ptp_jump_params(10, 200)
        self._set_ptp_common_params(velocity=100, acceleration=100)

    def _magician_fault(self, error: Error) -> Exception:
        """Converts an error to the exception that a program for this library expects."""
        return error

    def _magician_exchange(self, msg: Message) -> Message:
        msg.refresh()
        id, ctrl = msg.id, msg.ctrl
        assert isinstance(id, int) and isinstance(ctrl, int)
        try:
            ctrl, params = self._magician_line.exchange(id, ctrl, bytes(msg.params))
        except Error as error:
            raise self._magician_fault(error) from error
        return Message.answer(id, ctrl, params)

    def _magician_finish(self, index: int, motion: bool = False) -> None:
        try:
            self._magician_line.finish(index, motion)
        except Error as error:
            raise self._magician_fault(error) from error

    def _send_message(self, msg: Message) -> None:
        """Sends a frame; :meth:`_read_message` returns its reply."""
        self._magician_answer = self._magician_exchange(msg)

    def _read_message(self) -> Message | None:
        """Returns the reply to the last frame sent, once."""
        answer, self._magician_answer = self._magician_answer, None
        return answer

    def _send_command(self, msg: Message, wait: bool = False) -> Message:
        """Sends a frame and returns its reply; with ``wait``, after the queued command has finished."""
        answer = self._magician_exchange(msg)
        if wait:
            self._magician_finish(self._magician_index(answer), motion=True)
        return answer

    def _magician_command(self, id: int, ctrl: int, params: bytes = b"", wait: bool = False) -> Message:
        msg = Message()
        msg.id, msg.ctrl, msg.params = id, ctrl, bytearray(params)
        return self._send_command(msg, wait) if wait else self._send_command(msg)

    @staticmethod
    def _magician_index(response: Message) -> int:
        """Returns the queue index in the reply to a queued command."""
        return int.from_bytes(response.params[:8], "little")

    def _get_queued_cmd_current_index(self) -> int:
        return self._magician_index(self._magician_command(246, GET))

    def _set_queued_cmd_start_exec(self) -> Message:
        return self._magician_command(240, SET)

    def _set_queued_cmd_stop_exec(self) -> Message:
        return self._magician_command(241, SET)

    def _set_queued_cmd_clear(self) -> Message:
        return self._magician_command(245, SET)

    def _set_ptp_joint_params(
        self, v_x: float, v_y: float, v_z: float, v_r: float, a_x: float, a_y: float, a_z: float, a_r: float
    ) -> Message:
        return self._magician_command(80, QUEUED, floats(v_x, v_y, v_z, v_r, a_x, a_y, a_z, a_r))

    def _set_ptp_coordinate_params(self, velocity: float, acceleration: float) -> Message:
        return self._magician_command(81, QUEUED, floats(velocity, velocity, acceleration, acceleration))

    def _set_ptp_jump_params(self, jump: float, limit: float) -> Message:
        return self._magician_command(82, QUEUED, floats(jump, limit))

    def _set_ptp_common_params(self, velocity: float, acceleration: float) -> Message:
        return self._magician_command(83, QUEUED, floats(velocity, acceleration))

    def _magician_ptp(self, mode: int | Enum, x: float, y: float, z: float, r: float, wait: bool) -> Message:
        number = int(mode.value) if isinstance(mode, Enum) else int(mode)
        return self._magician_command(84, QUEUED, struct.pack("<B4f", number, x, y, z, r), wait)

    def _set_cp_cmd(self, x: float, y: float, z: float) -> Message:
        return self._magician_command(91, QUEUED, struct.pack("<B3fB", 1, x, y, z, 0))

    def _set_end_effector_suction_cup(self, enable: bool = False) -> Message:
        return self._magician_command(62, QUEUED, switch(enable, "suck"))

    def _set_end_effector_gripper(self, enable: bool = False) -> Message:
        return self._magician_command(63, QUEUED, switch(enable, "grip"))
