//! Queued commands that are unique among thousands of neighbours, so that the parameters the arm
//! accepted identify the command.

use magician::connection::Request;
use magician::stream::Item;
use magician_protocol::commands::{CpCmd, PtpCmd, WaitCmd};
use magician_protocol::{CpMode, Ctrl, FrameBuf, PtpMode, Set};

/// Returns a unique position for each number, on a grid well inside the reach.
pub(super) fn position(number: u64) -> [f32; 4] {
    let (column, row) = (number % 250, number / 250 % 200);
    [
        200.0 + column as f32 * 0.2,
        -40.0 + row as f32 * 0.4,
        10.0,
        0.0,
    ]
}

/// Returns the command with this number, in turn a wait or a move of one of three kinds.
pub(super) fn mixed(number: u64) -> Set {
    match number % 4 {
        0 => WaitCmd {
            timeout: (number % 4096) as u32,
        }
        .into(),
        1 => segment(number),
        2 => to_point(number, PtpMode::MovlXyz),
        _ => to_point(number, PtpMode::MovjXyz),
    }
}

pub(super) fn to_point(number: u64, ptp_mode: PtpMode) -> Set {
    let [x, y, z, r] = position(number);
    PtpCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
    }
    .into()
}

pub(super) fn segment(number: u64) -> Set {
    let [x, y, z, _] = position(number);
    CpCmd {
        cp_mode: CpMode::Absolute,
        x,
        y,
        z,
        velocity_or_power: 100.0,
    }
    .into()
}

/// Returns the command as an item of a stream.
pub(super) fn item(number: u64) -> Item {
    let command = mixed(number);
    let end_number = if number.is_multiple_of(4) {
        number.saturating_sub(1)
    } else {
        number
    };
    let time = match command {
        Set::WaitCmd(wait) => u64::from(wait.timeout) * 1_000,
        _ => 60_000,
    };
    Item {
        command,
        time,
        end: (end_number > 0).then(|| position(end_number).map(f64::from)),
        laser: false,
    }
}

pub(super) fn frame(command: &Set) -> FrameBuf {
    FrameBuf::set(command, Ctrl::QUEUED).expect("short enough")
}

/// Returns the command as a queued request.
pub(super) fn request(command: &Set) -> Request {
    let frame = frame(command);
    let view = frame.frame();
    Request::raw(view.id(), Ctrl::QUEUED, view.params()).expect("short enough")
}
