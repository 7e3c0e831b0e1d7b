"""pydobotlab's arm."""

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
    """mm and degrees. One after the other it gives x, y, z, r and the list of joint angles."""

    def __init__(self, *values: float) -> None:
        self.x, self.y, self.z, self.r, self.j1, self.j2, self.j3, self.j4 = values

    @property
    def joints(self) -> list[float]:
        """The four angles."""
        return [self.j1, self.j2, self.j3, self.j4]

    def as_xyzr(self) -> tuple[float, float, float, float]:
        """x, y, z and r."""
        return self.x, self.y, self.z, self.r

    def as_joints(self) -> tuple[float, float, float, float]:
        """The four angles."""
        return self.j1, self.j2, self.j3, self.j4

    def __iter__(self) -> Iterator[Any]:
        yield from self.as_xyzr()
        yield self.joints

    def __repr__(self) -> str:
        return f"Pose({', '.join(f'{name}={getattr(self, name):.2f}' for name in _FIELDS)})"


class Magician:
    """An arm, connected by :meth:`connect` or ``with``: mm, degrees, seconds."""

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
        """Connects, and empties and starts the queue."""
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
        """Empties the queue and ends the connection."""
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
        """Where the arm is."""
        return self._line.name if self._line else self._wanted

    @property
    def is_open(self) -> bool:
        """Whether it is connected."""
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
        """Goes to a pose, or to joint angles by the modes 3 to 5."""
        return bool(self._call("ptp", mode, x, y, z, r))

    def set_device_withl(self, enable: bool, version: int = 0) -> bool:
        """Says that the arm stands on a rail."""
        return bool(self._call("set_device_withl", enable, version))

    def set_ptpl_params(self, vel: float, accel: float) -> bool:
        """The rail's speed and acceleration."""
        return bool(self._call("set_ptpl_params", vel, accel))

    def set_ptpwithl_cmd(self, mode: int, x: float, y: float, z: float, r: float, l: float) -> bool:
        """Goes to a pose, and to a place on the rail."""
        return bool(self._call("set_ptpwithl_cmd", mode, x, y, z, r, l))

    def set_r(self, r: float) -> bool:
        """Turns the tool."""
        return bool(self._call("set_r", r))

    @property
    def motion_params(self) -> tuple[float, float]:
        """Ratios (%) of speed and acceleration."""
        velocity, acceleration = struct.unpack_from("<2f", self._exchange(83, GET))
        return velocity, acceleration

    @motion_params.setter
    def motion_params(self, value: tuple[float, float]) -> None:
        self._call("motion_params", *value)

    @property
    def jump_params(self) -> tuple[float, float]:
        """The highest z of a jump, and how far it goes up (mm)."""
        height, limit = struct.unpack_from("<2f", self._exchange(82, GET))
        return limit, height

    @jump_params.setter
    def jump_params(self, value: tuple[float, float]) -> None:
        self._call("jump_params", *value)

    def set_multiplexing(self, io: int | str, multiplex: int) -> bool:
        """What a pin does."""
        return bool(self._call("set_multiplexing", _lab.io(io), multiplex))

    def set_pwm(self, io: int | str, freq: float, cycle: float) -> bool:
        """Frequency (Hz) and duty cycle (%) of a pin."""
        return bool(self._call("set_pwm", _lab.io(io), freq, cycle))

    def set_do(self, io: int | str, level: int) -> bool:
        """Sets an output."""
        return bool(self._call("set_do", _lab.io(io), 1 if int(level) else 0))

    def get_di(self, io: int | str) -> int:
        """The level of an input."""
        return int(self._call("get_di", _lab.io(io)))

    def get_adc(self, io: int | str) -> int:
        """The value of an analogue input (0 to 4095)."""
        return int(self._call("get_adc", _lab.io(io)))

    def set_endeffector_suctioncup(self, enable: bool, on: bool) -> bool:
        """Switches the pump, to suck or to blow."""
        return bool(self._call("set_endeffector_suctioncup", bool(enable), bool(on)))

    def set_endeffector_gripper(self, enable: bool, on: bool) -> bool:
        """Switches the gripper, to close or to open."""
        return bool(self._call("set_endeffector_gripper", bool(enable), bool(on)))

    def set_infrared_sensor(self, port: int, enable: bool, version: int = 1) -> bool:
        """Switches the sensor at a socket, which is counted from 0."""
        return bool(self._call("set_infrared_sensor", port, bool(enable), version))

    def get_infrared_sensor(self, port: int) -> int:
        """1 if something is before the sensor."""
        return int(self._call("get_infrared_sensor", port))

    def set_color_sensor(self, port: int, enable: bool, version: int = 0) -> bool:
        """Switches the sensor at a socket, which is counted from 0."""
        return bool(self._call("set_color_sensor", port, bool(enable), version))

    def get_color_sensor(self) -> tuple[int, int, int]:
        """Whether red, green, blue stands out."""
        red, green, blue = self._call("get_color_sensor")
        return red, green, blue

    def wait(self, second: float) -> bool:
        """Waits in the arm's queue."""
        return bool(self._call("wait", second))

    def set_home(self) -> bool:
        """Homes the arm, and clears its alarms."""
        done = bool(self._call("set_home"))
        return self.clear_alarm() if not self._batches and self.get_alarms() else done

    def get_pose(self) -> Pose:
        """Where the arm is."""
        return Pose(*struct.unpack_from("<8f", self._exchange(10, GET)))

    def get_posel(self) -> float:
        """Where it stands on the rail (mm)."""
        return float(struct.unpack_from("<f", self._exchange(13, GET))[0])

    def clear_alarm(self) -> bool:
        """Clears the alarms; raises if one stands again at once."""
        self._call("clear_alarm")
        self.ensure_no_alarms()
        return True

    def get_arm_speed_ratio(self, mode: int) -> float:
        """The ratio (%) of jogging (0) or of moves (1)."""
        return float(self._call("get_arm_speed_ratio", mode)["value"])

    def set_lost_step_params(self, value: float) -> bool:
        """From how much on (degrees) steps count as lost."""
        return bool(self._call("set_lost_step_params", value))

    def set_lost_step_cmd(self) -> bool:
        """Looks for lost steps."""
        return bool(self._call("set_lost_step_cmd"))

    def get_lost_step_result(self) -> list[str]:
        """The alarms that stand, by name."""
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
        """Goes there; returns the queue index."""
        index = self.queue_command(84, struct.pack("<B4f", int(mode), x, y, z, r))
        if wait:
            self.wait_for(index, raise_on_alarm=raise_on_alarm)
        return index

    def cp(self, x: float, y: float, z: float, *, velocity: float = 100.0, mode: int = 1) -> int:
        """A point of a continuous path; returns the queue index."""
        return self._index(self._exchange(91, QUEUED, struct.pack("<B4f", int(mode), x, y, z, velocity)))

    def set_cp_params(
        self, plan_acc: float, junction_vel: float, acc: float = 0.0, *, real_time_track: bool = False
    ) -> int:
        """The path's acceleration and speed at corners; returns the queue index."""
        params = struct.pack("<3fB", plan_acc, junction_vel, acc, real_time_track)
        return self._index(self._exchange(90, QUEUED, params))

    def set_endeffector_laser(self, enable: bool, on: bool) -> bool:
        """Switches the laser."""
        return self.execute_command(61, bytes((bool(enable), bool(on))))

    def jog(self, cmd: int, mode: int = 0) -> None:
        """Moves along an axis until :meth:`jog_stop`."""
        self._exchange(73, SET, bytes((int(mode), int(cmd))))

    def jog_stop(self) -> None:
        """Stops jogging."""
        self.jog(0)

    def set_jog_common_params(self, vel_ratio: float, acc_ratio: float) -> int:
        """Ratios (%) of jogging; returns the queue index."""
        return self._index(self._exchange(72, QUEUED, struct.pack("<2f", vel_ratio, acc_ratio)))

    def get_jog_common_params(self) -> tuple[float, float]:
        """Ratios (%) of jogging."""
        velocity, acceleration = struct.unpack_from("<2f", self._exchange(72, GET))
        return velocity, acceleration

    def write_command(self, command_id: int, params: bytes = b"") -> bytes:
        """Sends a frame that sets something at once; the parameters of its answer."""
        return self._exchange(int(command_id), SET, params)

    def read_command(self, command_id: int, params: bytes = b"") -> bytes:
        """Sends a frame that asks for something; the parameters of its answer."""
        return self._exchange(int(command_id), GET, params)

    def queue_command(self, command_id: int, params: bytes = b"") -> int:
        """Queues a frame; returns the queue index."""
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
        """Empties the queue, at once as pydobotlab 0.2 does: the motion under way may end where it is."""
        self._exchange(245, SET)

    def queued_cmd_current_index(self) -> int:
        """The index of the command that was done last."""
        return self._index(self._exchange(246, GET))

    def queued_cmd_left_space(self) -> int:
        """Room in the queue."""
        return int.from_bytes(self._exchange(247, GET)[:4], "little")

    def wait_for(self, index: int, timeout: float | None = None, raise_on_alarm: bool = True, **_: object) -> None:
        """Waits until a queued command is done."""
        if self._line is not None:
            try:
                self._line.finish(index, raise_on_alarm)
            except Error as error:
                raise fault(error) from error

    def wait_idle(self, timeout: float | None = None, **named: Any) -> None:
        """Waits until all that this program has queued is done."""
        if last := self._connected().last:
            self.wait_for(last, **named)

    @contextmanager
    def batch(self) -> Generator[Magician]:
        """Queues calls without running them, runs them at the end, and waits. An exception leaves them out."""
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
        """The alarms that stand."""
        return AlarmSet(self._exchange(20, GET))

    def ensure_no_alarms(self) -> None:
        """Raises if an alarm stands."""
        if alarms := self.get_alarms():
            raise alarm_error(alarms)

    def get_device_serial_number(self) -> str:
        """The arm's serial number."""
        return self._exchange(0, GET).split(b"\0")[0].decode("utf-8", "replace")

    def get_device_name(self) -> str:
        """The name that the arm was given."""
        return self._exchange(1, GET).split(b"\0")[0].decode("utf-8", "replace")

    def set_device_name(self, name: str) -> None:
        """Names the arm."""
        self._exchange(1, SET, name.encode() + b"\0")

    def get_device_version(self) -> tuple[int, int, int]:
        """The firmware's version."""
        major, minor, revision = self._exchange(2, GET)[:3]
        return major, minor, revision


Dobot = Magician
