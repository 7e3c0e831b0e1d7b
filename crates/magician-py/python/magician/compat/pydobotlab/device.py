"""Arm of pydobotlab."""

from __future__ import annotations

import struct
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from typing import Any

from ...errors import Error
from .. import _lab
from .._line import GET, QUEUED, SET, Line
from .alarms import AlarmSet, alarm_error, fault
from .errors import DobotConnectionError

__all__ = ["Dobot", "Magician", "Pose"]

_CALLS = {call.lab.partition(" ")[0]: call for call in _lab.CALLS if call.lab}
_FIELDS = ("x", "y", "z", "r", "j1", "j2", "j3", "j4")


class Pose:
    """Pose, mm and degrees. Iterates over x, y, z, r and the list of joint angles."""

    def __init__(self, *values: float) -> None:
        self.x, self.y, self.z, self.r, self.j1, self.j2, self.j3, self.j4 = values

    @property
    def joints(self) -> list[float]:
        """Returns the four joint angles."""
        return [self.j1, self.j2, self.j3, self.j4]

    def as_xyzr(self) -> tuple[float, float, float, float]:
        """Returns x, y, z and r."""
        return self.x, self.y, self.z, self.r

    def as_joints(self) -> tuple[float, float, float, float]:
        """Returns the four joint angles."""
        return self.j1, self.j2, self.j3, self.j4

    def __iter__(self) -> Iterator[Any]:
        yield from self.as_xyzr()
        yield self.joints

    def __repr__(self) -> str:
        return f"Pose({', '.join(f'{name}={getattr(self, name):.2f}' for name in _FIELDS)})"


class Magician:
    """Arm, connected by :meth:`connect` or ``with``: mm, degrees, seconds."""

    Stepper1, Stepper2 = 0, 1

    def __init__(
        self,
        port: str | None = None,
        baudrate: int | None = None,
        timeout: float | None = None,
        *,
        auto_start_queue: bool = True,
        only_known_adapters: bool = False,
        require_panel: bool | None = None,
        via_broker: bool | str = "auto",
        broker_host: str | None = None,
        broker_port: int | None = None,
        verbose: bool = True,
    ) -> None:
        self._wanted, self._timeout, self._verbose = port, timeout, verbose
        self._start_queue = auto_start_queue
        self._line: Line | None = None
        self._batches = 0

    def connect(self) -> None:
        """Connects, clears the queue and starts it."""
        if self.is_open:
            return
        try:
            self._line = Line(self._wanted, timeout=self._timeout or 3.0)
        except Error as error:
            raise fault(error) from error
        if self._start_queue:
            self.clear_queue()
            self.start_queue()
        if self._verbose:
            print(f"[pydobotlab] Connected to {self._line.name}.", flush=True)

    def disconnect(self) -> None:
        """Clears the queue and ends the connection."""
        line = self._line
        if line is not None and not line.closed:
            self.clear_queue()
            self.start_queue()
            line.close()
        self._line = None

    close = disconnect

    def __enter__(self) -> Magician:
        self.connect()
        return self

    def __exit__(self, *_: object) -> None:
        self.disconnect()

    @property
    def port(self) -> str | None:
        """Port of the arm; ``None`` if it is not connected."""
        return self._line.name if self._line else self._wanted

    @property
    def is_open(self) -> bool:
        """True if the arm is connected."""
        return self._line is not None and not self._line.closed

    def _connected(self) -> Line:
        if self._line is None:
            raise DobotConnectionError("not connected: call connect() first, or use `with Magician() as bot:`")
        return self._line

    def _exchange(self, id: int, ctrl: int, params: bytes = b"") -> bytes:
        line = self._connected()
        try:
            return bytes(line.exchange(id, ctrl, params)[1])
        except Error as error:
            raise fault(error) from error

    def _call(self, name: str, *values: Any) -> Any:
        line = self._connected()
        try:
            return _lab.exchange(line, _CALLS[name], [*values], wait=not self._batches)
        except Error as error:
            raise fault(error) from error

    def _index(self, params: bytes) -> int:
        return int.from_bytes(params[:8], "little")

    # The 28 calls.

    def ptp(self, mode: int, x: float, y: float, z: float, r: float) -> bool:
        """Moves to a pose, or in modes 3 to 5 to joint angles."""
        return bool(self._call("ptp", mode, x, y, z, r))

    def set_device_withl(self, enable: bool, version: int = 0) -> bool:
        """Declares that the arm is mounted on a rail."""
        return bool(self._call("set_device_withl", enable, version))

    def set_ptpl_params(self, vel: float, accel: float) -> bool:
        """Sets the rail's speed and acceleration."""
        return bool(self._call("set_ptpl_params", vel, accel))

    def set_ptpwithl_cmd(self, mode: int, x: float, y: float, z: float, r: float, l: float) -> bool:
        """Moves to a pose, and to a position on the rail."""
        return bool(self._call("set_ptpwithl_cmd", mode, x, y, z, r, l))

    def set_r(self, r: float) -> bool:
        """Rotates the tool."""
        return bool(self._call("set_r", r))

    @property
    def motion_params(self) -> tuple[float, float]:
        """Sets the ratios (%) of speed and acceleration."""
        velocity, acceleration = struct.unpack_from("<2f", self._exchange(83, GET))
        return velocity, acceleration

    @motion_params.setter
    def motion_params(self, value: tuple[float, float]) -> None:
        self._call("motion_params", *value)

    @property
    def jump_params(self) -> tuple[float, float]:
        """Sets the highest z of a jump, and its height (mm)."""
        height, limit = struct.unpack_from("<2f", self._exchange(82, GET))
        return limit, height

    @jump_params.setter
    def jump_params(self, value: tuple[float, float]) -> None:
        self._call("jump_params", *value)

    def set_multiplexing(self, io: int | str, multiplex: int) -> bool:
        """Sets the function of a pin."""
        return bool(self._call("set_multiplexing", _lab.io(io), multiplex))

    def set_pwm(self, io: int | str, freq: float, cycle: float) -> bool:
        """Sets frequency (Hz) and duty cycle (%) of a pin."""
        return bool(self._call("set_pwm", _lab.io(io), freq, cycle))

    def set_do(self, io: int | str, level: int) -> bool:
        """Sets an output."""
        return bool(self._call("set_do", _lab.io(io), 1 if int(level) else 0))

    def get_di(self, io: int | str) -> int:
        """Returns the level of an input."""
        return int(self._call("get_di", _lab.io(io)))

    def get_adc(self, io: int | str) -> int:
        """Returns the value of an analogue input (0 to 4095)."""
        return int(self._call("get_adc", _lab.io(io)))

    def set_endeffector_suctioncup(self, enable: bool, on: bool) -> bool:
        """Switches the pump, to suck or to blow."""
        return bool(self._call("set_endeffector_suctioncup", bool(enable), bool(on)))

    def set_endeffector_gripper(self, enable: bool, on: bool) -> bool:
        """Switches the gripper, to close or to open."""
        return bool(self._call("set_endeffector_gripper", bool(enable), bool(on)))

    def set_infrared_sensor(self, port: int, enable: bool, version: int = 1) -> bool:
        """Switches the sensor at a socket, counted from 0."""
        return bool(self._call("set_infrared_sensor", port, bool(enable), version))

    def get_infrared_sensor(self, port: int) -> int:
        """Returns 1 if an object is in front of the sensor."""
        return int(self._call("get_infrared_sensor", port))

    def set_color_sensor(self, port: int, enable: bool, version: int = 0) -> bool:
        """Switches the sensor at a socket, counted from 0."""
        return bool(self._call("set_color_sensor", port, bool(enable), version))

    def get_color_sensor(self) -> tuple[int, int, int]:
        """Returns three values, one each for red, green and blue: true for the detected colour."""
        red, green, blue = self._call("get_color_sensor")
        return red, green, blue

    def wait(self, second: float) -> bool:
        """Queues a wait."""
        return bool(self._call("wait", second))

    def set_home(self) -> bool:
        """Homes the arm, and clears its alarms."""
        done = bool(self._call("set_home"))
        return self.clear_alarm() if not self._batches and self.get_alarms() else done

    def get_pose(self) -> Pose:
        """Returns the pose of the arm."""
        return Pose(*struct.unpack_from("<8f", self._exchange(10, GET)))

    def get_posel(self) -> float:
        """Returns the position on the rail (mm)."""
        return float(struct.unpack_from("<f", self._exchange(13, GET))[0])

    def clear_alarm(self) -> bool:
        """Clears the alarms. Raises an error if one is active again at once."""
        self._call("clear_alarm")
        self.ensure_no_alarms()
        return True

    def get_arm_speed_ratio(self, mode: int) -> float:
        """Returns the ratio (%) of jogging (0) or of moves (1)."""
        return float(self._call("get_arm_speed_ratio", mode)["value"])

    def set_lost_step_params(self, value: float) -> bool:
        """Sets the deviation (degrees) from which steps count as lost."""
        return bool(self._call("set_lost_step_params", value))

    def set_lost_step_cmd(self) -> bool:
        """Checks for lost steps."""
        return bool(self._call("set_lost_step_cmd"))

    def get_lost_step_result(self) -> list[str]:
        """Returns the names of the active alarms."""
        return self.get_alarms().names()

    def set_converyor(self, index: int, enable: bool, speed: float) -> bool:
        """Runs a motor (pulses/s)."""
        return bool(self._call("set_converyor", index, bool(enable), speed))

    # Its own.

    set_conveyor = set_converyor
    home = set_home
    clear_alarms = clear_alarm
    wait_seconds = wait
    get_pose_l = get_slideway_pose = get_posel

    def move_to(
        self,
        x: float,
        y: float,
        z: float,
        r: float = 0.0,
        *,
        mode: int = 1,
        wait: bool = True,
        timeout: float | None = None,
        raise_on_alarm: bool = True,
    ) -> int:
        """Moves to a pose. Returns the queue index."""
        index = self.queue_command(84, struct.pack("<B4f", int(mode), x, y, z, r))
        if wait:
            self.wait_for(index, raise_on_alarm=raise_on_alarm)
        return index

    def cp(self, x: float, y: float, z: float, *, velocity: float = 100.0, mode: int = 1) -> int:
        """Queues a point of a continuous path. Returns the queue index."""
        return self._index(self._exchange(91, QUEUED, struct.pack("<B4f", int(mode), x, y, z, velocity)))

    def set_cp_params(
        self, plan_acc: float, junction_vel: float, acc: float = 0.0, *, real_time_track: bool = False
    ) -> int:
        """Sets the path's acceleration and speed at corners. Returns the queue index."""
        params = struct.pack("<3fB", plan_acc, junction_vel, acc, real_time_track)
        return self._index(self._exchange(90, QUEUED, params))

    def set_endeffector_laser(self, enable: bool, on: bool) -> bool:
        """Switches the laser."""
        return self.execute_command(61, bytes((bool(enable), bool(on))))

    def jog(self, cmd: int, mode: int = 0) -> None:
        """Jogs along an axis until :meth:`jog_stop`."""
        self._exchange(73, SET, bytes((int(mode), int(cmd))))

    def jog_stop(self) -> None:
        """Stops jogging."""
        self.jog(0)

    def set_jog_common_params(self, vel_ratio: float, acc_ratio: float) -> int:
        """Sets the ratios (%) of jogging. Returns the queue index."""
        return self._index(self._exchange(72, QUEUED, struct.pack("<2f", vel_ratio, acc_ratio)))

    def get_jog_common_params(self) -> tuple[float, float]:
        """Returns the ratios (%) of jogging."""
        velocity, acceleration = struct.unpack_from("<2f", self._exchange(72, GET))
        return velocity, acceleration

    def write_command(self, command_id: int, params: bytes = b"") -> bytes:
        """Sends a frame that sets a value immediately. Returns the parameters of its reply."""
        return self._exchange(int(command_id), SET, params)

    def read_command(self, command_id: int, params: bytes = b"") -> bytes:
        """Sends a frame that reads a value. Returns the parameters of its reply."""
        return self._exchange(int(command_id), GET, params)

    def queue_command(self, command_id: int, params: bytes = b"") -> int:
        """Queues a frame. Returns the queue index."""
        return self._index(self._exchange(int(command_id), QUEUED, params))

    def execute_command(self, command_id: int, params: bytes = b"") -> bool:
        """Queues a frame, and waits until it is done unless in a batch."""
        index = self.queue_command(command_id, params)
        if not self._batches:
            self.wait_for(index)
        return True

    def start_queue(self) -> None:
        """Starts the queue."""
        self._exchange(240, SET)

    def stop_queue(self) -> None:
        """Stops the queue after the command under way."""
        self._exchange(241, SET)

    def force_stop_queue(self) -> None:
        """Stops the arm."""
        self._exchange(242, SET)

    def clear_queue(self) -> None:
        """Clears the queue immediately, like pydobotlab 0.2: the current motion may end where it is."""
        self._exchange(245, SET)

    def queued_cmd_current_index(self) -> int:
        """Returns the index of the last finished command."""
        return self._index(self._exchange(246, GET))

    def queued_cmd_left_space(self) -> int:
        """Returns the free space of the queue."""
        return int.from_bytes(self._exchange(247, GET)[:4], "little")

    def wait_for(self, index: int, timeout: float | None = None, raise_on_alarm: bool = True, **_: object) -> None:
        """Waits until a queued command is done."""
        if self._line is not None:
            try:
                self._line.finish(index, raise_on_alarm)
            except Error as error:
                raise fault(error) from error

    def wait_idle(self, timeout: float | None = None, **named: Any) -> None:
        """Waits until all commands that this program has queued are done."""
        if last := self._connected().last:
            self.wait_for(last, **named)

    @contextmanager
    def batch(self) -> Generator[Magician]:
        """Queues calls without running them, runs them at the end, and waits. After an exception they are not run."""
        if not self._batches:
            self.stop_queue()
            self.clear_queue()
        self._batches += 1
        try:
            yield self
        except BaseException:
            if self._batches == 1:
                self.clear_queue()
            raise
        finally:
            self._batches -= 1
            if not self._batches:
                self.start_queue()
        if not self._batches:
            self.wait_idle()

    def get_alarms(self) -> AlarmSet:
        """Returns the active alarms."""
        return AlarmSet(self._exchange(20, GET))

    def ensure_no_alarms(self) -> None:
        """Raises an error if an alarm is active."""
        if alarms := self.get_alarms():
            raise alarm_error(alarms)

    def get_device_serial_number(self) -> str:
        """Returns the arm's serial number."""
        return self._exchange(0, GET).split(b"\0")[0].decode("utf-8", "replace")

    def get_device_name(self) -> str:
        """Returns the arm's name."""
        return self._exchange(1, GET).split(b"\0")[0].decode("utf-8", "replace")

    def set_device_name(self, name: str) -> None:
        """Sets the arm's name."""
        self._exchange(1, SET, name.encode() + b"\0")

    def get_device_version(self) -> tuple[int, int, int]:
        """Returns the version of the firmware."""
        major, minor, revision = self._exchange(2, GET)[:3]
        return major, minor, revision


Dobot = Magician
