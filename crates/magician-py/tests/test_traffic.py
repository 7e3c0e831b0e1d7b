from __future__ import annotations

import pickle
import struct
from pathlib import Path

import magician
import pytest
from magician import commands, errors
from magician.traffic import Decoded, Rejected

GET_POSE = bytes.fromhex("AA AA 02 0A 00 F6")


def block(kind: int, body: bytes) -> bytes:
    """A block of a pcapng file."""
    body += bytes(-len(body) % 4)
    size = struct.pack("<I", 12 + len(body))
    return struct.pack("<I", kind) + size + body + size


def trace(*frames: tuple[int, bytes]) -> bytes:
    """A trace of one link, "./arm": frames with 2 for a request and 1 for a reply, a second apart."""
    file = block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1))
    options = struct.pack("<HH", 2, 5) + b"./arm\0\0\0" + struct.pack("<HHB3xHH", 9, 1, 6, 0, 0)
    file += block(1, struct.pack("<HHI", 147, 0, 0) + options)
    for nth, (flags, data) in enumerate(frames):
        time = (1_700_000_000 + nth) * 1_000_000
        head = struct.pack("<IIIII", 0, time >> 32, time & 0xFFFFFFFF, len(data), len(data))
        file += block(6, head + data + bytes(-len(data) % 4) + struct.pack("<HHIHH", 2, 4, flags, 0, 0))
    return file


def frame(id: int, ctrl: int, params: bytes) -> bytes:
    payload = bytes((id, ctrl)) + params
    return b"\xaa\xaa" + bytes((len(payload),)) + payload + bytes((-sum(payload) & 0xFF,))


@pytest.mark.parametrize(
    "source", [GET_POSE, bytearray(GET_POSE), memoryview(GET_POSE), "AAAA020A00F6", "0xAA,0xAA 2 A 0 F6"]
)
def test_a_frame_is_a_value(source: bytes | str) -> None:
    (piece,) = magician.decode(source)
    assert isinstance(piece, Decoded)
    assert (piece.offset, piece.data, piece.id, piece.command) == (0, GET_POSE, 10, "GetPose")
    assert (piece.direction, piece.write, piece.queued, piece.params) == ("request", False, False, b"")
    assert piece.ok
    assert str(piece).startswith("request GetPose")
    assert pickle.loads(pickle.dumps(piece)) == piece


def test_decoded_frame_has_its_command() -> None:
    move = commands.PtpCmd(commands.PtpMode.MOVL_XYZ, 200, 10, 20, 0)
    queued = frame(84, 3, bytes(move))
    (request,) = magician.decode(queued)
    assert isinstance(request, Decoded)
    assert (request.value, request.index, request.queued, request.write) == (move, None, True, True)
    (reply,) = magician.decode(frame(84, 3, struct.pack("<Q", 17)), sender="arm")
    assert isinstance(reply, Decoded)
    assert (reply.value, reply.index, reply.direction) == (None, 17, "reply")
    assert str(reply) == "reply SetPTPCmd queued index 17"


@pytest.mark.parametrize(
    ("data", "error", "why", "kind"),
    [
        ("AA AA 02 0A 00 F7", "checksum", "checksum is F7, expected F6", ""),
        ("AA AA 06 0A 00", "truncated", "the input ends inside the frame", "truncated: "),
        ("AA AA 01", "length", "length is 1, a frame has 2 to 250", ""),
        ("AA AA 02 C8 00 38", "unknown", "unknown command id 200", ""),
        ("01 02 03", "noise", "no frame begins in these bytes", "noise: "),
    ],
)
def test_rejected_bytes_state_their_error_once(data: str, error: str, why: str, kind: str) -> None:
    piece = magician.decode(data)[0]
    assert isinstance(piece, Rejected)
    assert (piece.error, piece.why, piece.ok) == (error, why, False)
    assert str(piece) == f"{kind}{why} ({piece.data.hex(' ')})"
    assert bytes.fromhex(data).startswith(piece.data)


def test_a_frame_after_noise_is_found() -> None:
    noise, found = magician.decode(b"hello" + GET_POSE)
    assert isinstance(noise, Rejected)
    assert isinstance(found, Decoded)
    assert (noise.data, noise.offset, found.offset) == (b"hello", 0, 5)


def test_parameters_of_a_wrong_length_name_their_command() -> None:
    piece = magician.decode(frame(84, 3, b"\0"), sender="host")[0]
    assert isinstance(piece, Rejected)
    assert (piece.error, piece.id, piece.command) == ("length", 84, "SetPTPCmd")


def test_a_trace_tells_link_time_and_direction(tmp_path: Path) -> None:
    file = tmp_path / "session.pcapng"
    written = trace((2, GET_POSE), (1, frame(10, 0, struct.pack("<8f", *range(8)))))
    file.write_bytes(written)
    for source in (file, str(file), written):
        asked, told = magician.decode(source)
        assert isinstance(asked, Decoded)
        assert isinstance(told, Decoded)
        assert (asked.direction, asked.link, asked.time) == ("request", "./arm", 1_700_000_000.0)
        assert told.direction == "reply"
        assert told.value == commands.Pose(0, 1, 2, 3, (4, 5, 6, 7))


def test_a_trace_that_was_cut_off_is_read_up_to_there() -> None:
    *good, bad = magician.decode(trace((2, GET_POSE), (2, GET_POSE))[:-5])
    assert [piece.ok for piece in good] == [True]
    assert isinstance(bad, Rejected)
    assert bad.error == "trace"
    assert "ends inside the block" in bad.why


def test_files_of_bytes_and_of_hex(tmp_path: Path) -> None:
    (tmp_path / "bytes").write_bytes(GET_POSE)
    (tmp_path / "text").write_text("AA AA 02\n0A 00 F6\n", encoding="ascii")
    assert magician.decode(tmp_path / "bytes") == magician.decode(tmp_path / "text") == magician.decode(GET_POSE)


def test_undecodable_input_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        magician.decode("no such file.pcapng")
    with pytest.raises(FileNotFoundError):
        magician.decode(tmp_path / "AA")
    with pytest.raises(errors.InvalidInputError, match="odd number of hex digits"):
        magician.decode("AAA")
    with pytest.raises(TypeError, match="source is 5 "):
        magician.decode(5)  # type: ignore[arg-type] # pyright: ignore[reportArgumentType]
    with pytest.raises(errors.InvalidInputError, match="sender is 'me'"):
        magician.decode(GET_POSE, sender="me")  # type: ignore[arg-type] # pyright: ignore[reportArgumentType]
    assert magician.decode(b"") == []
