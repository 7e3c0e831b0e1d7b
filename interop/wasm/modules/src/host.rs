//! Host connection and virtual arm on the caller's clock.

use std::cell::RefCell;

use magician_host::connection::{Connection, Event, Settings};
use magician_host::preflight::Preflight;
use magician_host::stream::{Item, Stream, StreamSettings};
use magician_host::{JointAngles, ToolBias};
use magician_protocol::{ArmInstant, Set};
use magician_sim::{Controller, LinkId, Profile};

struct TestPair {
    connection: Connection,
    stream: Stream,
    check: Preflight,
    arm: Controller,
}

thread_local! {
    static PAIR: RefCell<TestPair> = RefCell::new(TestPair {
        connection: Connection::new(Settings::ORDERED),
        stream: Stream::new(StreamSettings::default()),
        check: Preflight::at(JointAngles::HOME, ToolBias::SUCTION),
        arm: Controller::new(Profile::default()),
    });
}

/// Checks and submits the command with this id and the given parameters. Returns 0 if it was
/// accepted.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn offer(id: u32) -> u32 {
    let Ok(command) = Set::decode(id as u8, &crate::take_input()) else {
        return 1;
    };
    PAIR.with_borrow_mut(|ends| match ends.check.check(&command) {
        Err(error) => {
            crate::set_output(error.to_string().as_bytes());
            2
        }
        Ok(step) => {
            let item = Item {
                command,
                time: u64::try_from(step.time.as_micros()).unwrap_or(u64::MAX),
                end: step.end.map(|end| end.pose.to_array()),
                laser: step.laser,
            };
            u32::from(ends.stream.offer(item).is_err()) * 3
        }
    })
}

/// Advances time to this instant, µs. Its output is the arm's position.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn advance(now: u64) {
    const LINK: LinkId = LinkId(0);
    PAIR.with_borrow_mut(|ends| {
        ends.arm.advance(ArmInstant::from_micros(now));
        ends.connection.handle_timeout(now);
        ends.stream.advance(now, &mut ends.connection);
        while let Some(frame) = ends.connection.poll_transmit(now) {
            ends.arm.receive(LINK, frame.bytes());
        }
        while let Some(answer) = ends.arm.poll_transmit(LINK) {
            ends.connection.receive(now, answer.bytes());
        }
        while let Some(event) = ends.connection.poll_event() {
            if let Event::Done { ticket, result } = event {
                (ends.stream).answered(now, ticket, &result, &mut ends.connection);
            }
        }
        for value in ends.arm.state().pose.to_array() {
            crate::set_output(&value.to_le_bytes());
        }
    });
}
