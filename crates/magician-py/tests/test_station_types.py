"""Types of a station's messages: they name each other rightly, and are what messages are."""

from __future__ import annotations

import typing

from magician import station_types
from magician.station_types import ArmSubscribeParams, JobChangedNotification, StateChange

NAMES = dict(vars(station_types))


def test_every_type_can_be_read() -> None:
    for name in station_types.__all__:
        of = getattr(station_types, name)
        if isinstance(of, type):
            typing.get_type_hints(of, NAMES)


def test_a_client_is_typed() -> None:
    asked: ArmSubscribeParams = {"rate": 20, "pins": [{"kind": "input", "address": 5}]}
    changed: StateChange = {"t": 1.5, "link": "lost"}
    assert asked["rate"] == 20 and "x" not in changed
    hints = typing.get_type_hints(JobChangedNotification, NAMES)
    assert "queued" in typing.get_args(typing.get_type_hints(hints["job"], NAMES)["state"])
