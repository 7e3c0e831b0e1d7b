//! Other actors: programs that fill the queue, clear it, use the same connection, or give the
//! program up.

use magician_protocol::commands::{QueuedCmdClear, QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use magician_protocol::{Ctrl, FrameBuf, Readable, Writable};
use magician_sim::LinkId;

use super::rig::{Rig, SECOND, path, wait};
use crate::connection::{Request, Settings};
use crate::stream::{Item, StreamFailure, StreamSettings};

fn one_by_one(program: &[Item]) -> Rig {
    Rig::new(Settings::ORDERED, StreamSettings::default(), program)
}

#[test]
fn a_full_queue_is_asked_for_its_places_before_anything_is_sent_to_it_again() {
    let program: Vec<_> = (1..60).map(|at| wait(150 + at, [0.0; 3])).collect();
    let mut rig = one_by_one(&program);
    while rig.pair.now < 2 * SECOND {
        rig.turn(2 * SECOND);
    }
    // Another program takes every place that becomes free.
    let theirs = FrameBuf::new(110, Ctrl::QUEUED, &[100, 0, 0, 0]).unwrap();
    let (mut heard, mut asked, mut refused) = (rig.pair.heard.len(), true, 0);
    while rig.pair.now < 6 * SECOND && !rig.stream.is_over() {
        for _ in rig.pair.arm.state().queue.waiting..32 {
            rig.pair.arm.receive(LinkId(7), theirs.bytes());
        }
        rig.turn(6 * SECOND);
        for frame in &rig.pair.heard[heard..] {
            asked |= frame.frame().id() == QueuedCmdLeftSpace::ROW.id;
            if frame.frame().ctrl().queued() {
                assert!(asked, "it was refused and came again");
                (asked, refused) = (false, refused + 1);
            }
        }
        heard = rig.pair.heard.len();
    }
    assert!(refused > 0);
}

#[test]
fn nothing_goes_into_a_queue_from_which_commands_are_missing() {
    let program = path(300, 1.5, 15_000);
    let mut rig = one_by_one(&program);
    let sent = |rig: &Rig| program.len() - rig.feed.len() - rig.stream.waiting().count();
    while rig.pair.now < SECOND || sent(&rig) < 100 {
        rig.turn(60 * SECOND);
    }
    let clear = FrameBuf::new(QueuedCmdClear::ROW.id, Ctrl::SET, &[]).unwrap();
    rig.pair.arm.receive(LinkId(7), clear.bytes());
    // The first reading after the Clear begins with left space; nothing is sent after that reply.
    let cleared = rig.pair.heard.len();
    let reads = |frame: &FrameBuf| frame.frame().id() == QueuedCmdCurrentIndex::ROW.id;
    while !rig.pair.heard[cleared..].iter().any(reads) {
        rig.turn(60 * SECOND);
    }
    let before = sent(&rig);
    let failure = rig.run(60 * SECOND).unwrap_err();
    assert!(
        matches!(failure, StreamFailure::Dropped { .. }),
        "{failure}"
    );
    assert_eq!(sent(&rig), before);
}

#[test]
fn unsent_commands_of_an_abandoned_program_are_never_sent() {
    let program: Vec<_> = (1..12).map(|at| wait(20 + at, [0.0; 3])).collect();
    let (mut commands, mut controls) = (0, 0);
    for turns in 0.. {
        let mut rig = one_by_one(&program);
        for _ in 0..turns {
            rig.turn(60 * SECOND);
        }
        if rig.stream.is_over() {
            break;
        }
        // Another caller uses the connection, and the arm does not answer.
        rig.pair.mute = true;
        let theirs = Request::raw(110, Ctrl::QUEUED, &[5, 0, 0, 0]).unwrap();
        rig.pair.host.submit(theirs.deadline(60 * SECOND));
        for _ in 0..3 {
            rig.turn(60 * SECOND);
        }
        let sent = rig.pair.host.stats().sent as usize;
        commands += rig.stream.flying();
        controls += usize::from(rig.stream.control.is_some());
        rig.stream.withdraw(&mut rig.pair.host);
        rig.pair.mute = false;
        let later = rig.pair.now + 20 * SECOND;
        rig.pair.run_until(later);
        let ours = |frame: &&FrameBuf| {
            let view = frame.frame();
            view.ctrl().write() && !(view.id() == 110 && view.params() == [5, 0, 0, 0])
        };
        let after = rig.pair.heard[sent..].iter().filter(ours).count();
        assert_eq!(after, 0, "{turns}");
    }
    assert!(commands > 0 && controls > 0, "{commands} {controls}");
}
