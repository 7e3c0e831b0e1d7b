"""Pins and connectors of the arm, named by their printed labels.

A pin is its EIO address, 1 to 20, a :class:`Pin`, or a string: ``"EIO19"``, ``"GP1 PWM"``, ``"SW1"``. A
connector of a sensor is a :class:`~magician.commands.Port` or its label, ``"GP1"``.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import IntEnum
from typing import TypeVar

from ._arguments import whole
from .commands import IoFunction, Port, RailVersion, SensorVersion, Stepper
from .errors import InvalidInputError

__all__ = [
    "FunctionLike",
    "Pin",
    "PinLike",
    "PortLike",
    "StepperLike",
    "VersionLike",
    "function",
    "pin",
    "pins",
    "port",
    "rail_version",
    "sensor_version",
    "stepper",
]


class Pin(IntEnum):
    """A pin; its value is the EIO address (model section 13)."""

    TEMP = 1
    """Forearm, ANALOG: output, inputs digital and analog; 3.3 V."""
    SW4 = 2
    """Forearm, fan, or power of the laser: output; 12 V."""
    SW3 = 3
    """Forearm, heater: output; 12 V."""
    GP5_PWM = 4
    """Forearm, GP5: output, PWM; 3.3 V. The laser's."""
    GP5_ADC = 5
    """Forearm, GP5: digital input; 3.3 V."""
    GP4_PWM = 6
    """Forearm, GP4: output, PWM; 3.3 V."""
    GP4_ADC = 7
    """Forearm, GP4: digital input; 3.3 V."""
    GP3_PWM = 8
    """Forearm, GP3: output, PWM; 3.3 V. The servo at the end."""
    GP3_ADC = 9
    """Forearm, GP3: output, inputs digital and analog; 3.3 V."""
    GP1_REV = 10
    """Base, GP1: output; 5 V."""
    GP1_PWM = 11
    """Base, GP1: output, PWM; 3.3 V."""
    GP1_ADC = 12
    """Base, GP1: digital input; 3.3 V."""
    GP2_REV = 13
    """Base, GP2: output; 5 V."""
    GP2_PWM = 14
    """Base, GP2: output, PWM, digital input; 3.3 V."""
    GP2_ADC = 15
    """Base, GP2: output, inputs digital and analog; 3.3 V."""
    SW1 = 16
    """Base, valve: output; 12 V."""
    SW2 = 17
    """Base, pump: output; 12 V."""
    E2 = 18
    """Base, UART pin 3: output; 3.3 V."""
    E1 = 19
    """Base, UART pin 8: digital input; 3.3 V."""
    STOP_KEY = 20
    """Base, UART pin 7: digital input; 3.3 V."""


PinLike = Pin | int | str
"""A pin: its EIO address, or its label (``"EIO19"``, ``"GP1 PWM"``)."""
PortLike = Port | int | str
"""A connector: ``"GP1"``, ``"GP2"``, ``"GP4"`` or ``"GP5"``."""
StepperLike = Stepper | int | str
"""A motor output: ``"STEPPER1"`` or ``"STEPPER2"``."""
VersionLike = SensorVersion | int | str
"""Version of a sensor: ``"V1"`` or ``"V2"``."""
FunctionLike = IoFunction | int | str
"""Function of a pin: the name in :class:`~magician.commands.IoFunction`, or a short form: ``"DO"``, ``"DI"``,
``"PWM"``, ``"ADC"``."""

_E = TypeVar("_E", bound=IntEnum)

_ABBREVIATIONS = {"DO": "DIGITAL_OUTPUT", "DI": "DIGITAL_INPUT", "ADC": "ANALOG_INPUT", "AI": "ANALOG_INPUT"}


def pin(name: str, value: PinLike) -> int:
    """Returns the EIO address of a pin."""
    if not isinstance(value, str) or value.isdecimal():
        return whole(name, value, 1, 20)  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    label = _label(value)
    number = label.removeprefix("EIO").strip("_")
    if number.isdecimal() and 1 <= int(number) <= 20:
        return int(number)
    if label not in Pin.__members__:
        raise InvalidInputError(f"{name} is {value!r}; it takes EIO1 to EIO20 or {', '.join(Pin.__members__)}")
    return int(Pin[label])


def pins(name: str, values: Iterable[PinLike]) -> list[int]:
    """Returns the EIO addresses of pins."""
    if isinstance(values, str) or not hasattr(values, "__iter__"):
        raise TypeError(f"{name} is {values!r}; it takes pins in a list: [{values!r}]")
    return [pin(f"{name}[{nth}]", each) for nth, each in enumerate(values)]


def port(value: PortLike) -> Port:
    """Returns the connector of a sensor."""
    return _member("port", Port, value)


def stepper(value: StepperLike) -> Stepper:
    """Returns a motor output."""
    return _member("index", Stepper, value, len(Stepper) - 1)


def sensor_version(value: VersionLike) -> SensorVersion:
    """Returns the version of a sensor."""
    return _member("version", SensorVersion, value)


def rail_version(value: RailVersion | int | str) -> RailVersion:
    """Returns the version of a rail."""
    return _member("version", RailVersion, value)


def function(value: FunctionLike) -> IoFunction:
    """Returns the function of a pin."""
    return _member("function", IoFunction, value)


def _label(value: str) -> str:
    return value.strip().upper().replace(" ", "_").replace("-", "_")


def _member(name: str, kind: type[_E], value: _E | int | str, most: int = 255) -> _E:
    if isinstance(value, str) and not value.isdecimal():
        label = _label(value)
        label = _ABBREVIATIONS.get(label, label)
        if label not in kind.__members__:
            raise InvalidInputError(f"{name} is {value!r}; it takes {', '.join(kind.__members__)}")
        return kind[label]
    # Let numbers without a name pass: the arm may know more than the table.
    return kind(whole(name, value, 0, most))  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
