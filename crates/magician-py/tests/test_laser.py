"""The laser of a real arm burns only when that was allowed; real is every arm but one in this process."""

from __future__ import annotations

import socket
from collections.abc import Callable, Iterator

import pytest
from magician import Arm, errors, words

BURNING: list[Callable[[Arm, bool], object]] = [
    lambda arm, allow: arm.laser(True, allow_laser=allow),
    lambda arm, allow: arm.output(4, True, allow_laser=allow),
    lambda arm, allow: arm.pwm(4, 1000, 20, allow_laser=allow),
    lambda arm, allow: arm.set(words.laser(True), allow_laser=allow),
    lambda arm, allow: arm.enqueue(words.laser(True), allow_laser=allow),
    lambda arm, allow: arm.raw(61, 1, b"\x01\x01", allow_laser=allow),
    lambda arm, allow: arm.perform([words.laser(True), words.laser(False)], allow_laser=allow),
]


@pytest.fixture
def silent() -> Iterator[str]:
    """A port at which somebody listens and never answers."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield f"tcp:127.0.0.1:{server.getsockname()[1]}"


@pytest.mark.parametrize("burn", BURNING)
def test_a_virtual_arm_is_never_refused(arm: Arm, burn: Callable[[Arm, bool], object]) -> None:
    # Give the pin the function that the call drives.
    arm.multiplex(4, "PWM" if burn is BURNING[2] else "DO")
    burn(arm, False)


@pytest.mark.parametrize("burn", BURNING)
def test_a_real_arm_wants_a_permission(silent: str, burn: Callable[[Arm, bool], object]) -> None:
    with pytest.raises(errors.Error) as caught, Arm(silent, probe=False, timeout=0.05) as arm:
        burn(arm, False)
    assert isinstance(caught.value, errors.InvalidInputError)
    assert "allow_laser=True" in str(caught.value) and "nothing was sent" in str(caught.value)
    # With permission the command is sent, to a peer that does not answer.
    with pytest.raises(errors.Error) as caught, Arm(silent, probe=False, timeout=0.05) as arm:
        burn(arm, True)
    assert not isinstance(caught.value, errors.InvalidInputError)


def test_off_takes_no_permission(silent: str) -> None:
    with pytest.raises(errors.ResponseTimeoutError), Arm(silent, probe=False, timeout=0.05) as arm:
        arm.laser(False)


def test_a_block_that_ends_well_leaves_no_laser_burning() -> None:
    with Arm("sim") as arm:
        arm.laser(True)
        assert arm.info().laser is True
        arm.laser(False)
        assert arm.info().laser is False
