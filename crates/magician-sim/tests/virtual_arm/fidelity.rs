//! Behaviour of a strict controller. The conformance cases (`magician-conform/tests/assumptions`)
//! check that each assumption is counted, and refused where a command relies on it.

use super::arm;
use std::collections::BTreeSet;

use super::arm::{TestArm, arm, arm_with, home, joints_to, ptp, running_arm, suck, wait};
use magician_protocol::commands::*;
use magician_protocol::{Ctrl, FrameBuf, NoArgs, Readable, Writable};
use magician_sim::fidelity::{Assumption, Confidence, Strictness};
use magician_sim::world::ExternalEvent;
use magician_sim::{Controller, Event, Profile, Refusal};

/// Sends a set; returns all replies.
fn now<T: Writable>(bench: &mut TestArm, value: &T) -> Vec<FrameBuf> {
    let frame = FrameBuf::encode(T::ROW.id, Ctrl::SET, value).expect("fits");
    bench.send(frame.bytes())
}

/// Queues a command; returns all replies.
fn queue<T: Writable>(bench: &mut TestArm, value: &T) -> Vec<FrameBuf> {
    let frame = FrameBuf::encode(T::ROW.id, Ctrl::QUEUED, value).expect("fits");
    bench.send(frame.bytes())
}

/// Sends a get; returns all replies.
fn ask<T: Readable<Query = NoArgs>>(bench: &mut TestArm) -> Vec<FrameBuf> {
    let frame = FrameBuf::encode(T::ROW.id, Ctrl::GET, &NoArgs).expect("fits");
    bench.send(frame.bytes())
}

fn raw(bench: &mut TestArm, id: u8, ctrl: u8, params: &[u8]) -> Vec<FrameBuf> {
    let frame = FrameBuf::new(id, Ctrl(ctrl), params).expect("fits");
    bench.send(frame.bytes())
}

fn start(bench: &mut TestArm) {
    now(bench, &QueuedCmdStartExec {});
}

fn strict() -> TestArm {
    arm_with(|profile| profile.fidelity.strict = true)
}

/// Assumptions that a strict arm refused, in order.
fn refusals(bench: &mut TestArm) -> Vec<Assumption> {
    let assumption = |event| match event {
        Event::Refused {
            reason: Refusal::OnlyAChoice(assumption),
            ..
        } => Some(assumption),
        _ => None,
    };
    bench.events().into_iter().filter_map(assumption).collect()
}

/// A refused command changes nothing but the queue's indices.
#[test]
fn what_strict_refuses_is_not_carried_out() {
    let mut bench = strict();
    start(&mut bench);
    let before = bench.state();
    for set in [
        ptp(1, [f32::NAN, 0.0, 0.0, 0.0]),
        ptp(77, [200.0, 0.0, 0.0, 0.0]),
    ] {
        let replies = queue(&mut bench, &set);
        let params = replies[0].frame();
        assert_eq!(params.params().len(), 8, "answered as usual");
    }
    assert_eq!(bench.current_index(), 2, "and consumed");
    assert!(bench.alarms().is_empty());
    assert_eq!(bench.state().joints, before.joints);
    assert!(!bench.state().moving);

    let replies = ask::<HomeParams>(&mut bench);
    let [reply] = &replies[..] else {
        panic!("one reply")
    };
    assert_eq!(reply.frame().params(), [0u8; 0], "a get without an answer");
    assert_eq!(Ctrl::GET, reply.frame().ctrl());
    let ratios = &PtpCommonParams {
        velocity_ratio: 150.0,
        acceleration_ratio: 50.0,
    };
    let [reply] = &now(&mut bench, ratios)[..] else {
        panic!("one reply")
    };
    assert_eq!(reply.frame().params(), [0u8; 0]);
    assert_eq!(bench.get::<PtpCommonParams>().velocity_ratio, 50.0);
}

#[test]
fn strict_is_silent_when_the_queue_is_full() {
    let mut bench = strict();
    for _ in 0..32 {
        assert_eq!(queue(&mut bench, &wait(0)).len(), 1);
    }
    assert!(queue(&mut bench, &wait(0)).is_empty());
    assert!(
        bench
            .send(&[0xAA, 0xAA, 0x03, 0x54, 0x03, 0x01, 0xA8])
            .is_empty()
    );
    assert_eq!(bench.left_space(), 0);
}

#[test]
fn a_first_use_is_told_once_and_all_are_counted() {
    let mut bench = arm();
    bench.events();
    let told = |bench: &mut TestArm| {
        std::iter::from_fn(|| bench.arm.poll_event())
            .filter(|event| {
                matches!(
                    event,
                    Event::Assumes {
                        assumption: Assumption::Clock
                    }
                )
            })
            .count()
    };
    for told_now in [1, 0, 0] {
        ask::<DeviceTime>(&mut bench);
        assert_eq!(told(&mut bench), told_now);
    }
    assert_eq!(bench.arm.fidelity().uses(Assumption::Clock), 3);
    bench.arm.inject(ExternalEvent::Reset);
    assert_eq!(
        bench.arm.fidelity().uses(Assumption::Clock),
        3,
        "through a reset"
    );
    let listed: Vec<_> = bench.arm.fidelity().iter().collect();
    assert!(listed.contains(&(Assumption::Clock, 3)));
    assert!(listed.iter().all(|(_, uses)| *uses > 0));
}

/// A strict arm still does everyday work: connect, set, home, move, wait, read.
#[test]
fn strict_arm_accepts_everyday_commands() {
    let mut bench = TestArm {
        arm: Controller::new(Profile {
            fidelity: magician_sim::FidelityRules { strict: true },
            ..Profile::continuous()
        }),
    };
    now(&mut bench, &ClearAlarmsState {});
    ask::<DeviceVersion>(&mut bench);
    bench.suction_bias();
    bench.full_speed();
    start(&mut bench);
    queue(&mut bench, &home());
    queue(&mut bench, &ptp(1, [200.0, 30.0, 20.0, 0.0]));
    queue(&mut bench, &ptp(2, [220.0, -30.0, 0.0, 0.0]));
    queue(&mut bench, &ptp(0, [200.0, 30.0, -30.0, 0.0]));
    queue(&mut bench, &arm::suck(true));
    queue(&mut bench, &wait(500));
    ask::<QueuedCmdCurrentIndex>(&mut bench);
    ask::<QueuedCmdLeftSpace>(&mut bench);
    bench.rest();
    assert_eq!(bench.current_index(), 7);
    assert_eq!(bench.pose()[0], 200.0);
    now(&mut bench, &QueuedCmdForceStopExec {});
    now(&mut bench, &QueuedCmdClear {});
    start(&mut bench);
    assert_eq!(refusals(&mut bench), []);
}

/// Only choices are refused or kept. Every assumption has a section and a text of its own.
#[test]
fn only_choices_are_refused_or_kept_and_each_assumption_has_its_text() {
    for assumption in Assumption::ALL {
        let choice = assumption.confidence() == Confidence::Choice;
        assert_eq!(
            choice,
            assumption.strictness() != Strictness::Fact,
            "{assumption:?}"
        );
        assert!(!assumption.says().ends_with('.') && !assumption.says().is_empty());
        assert!(!assumption.section().is_empty());
    }
    let says: BTreeSet<&str> = Assumption::ALL
        .iter()
        .map(|assumption| assumption.says())
        .collect();
    assert_eq!(says.len(), Assumption::ALL.len());
}

#[test]
fn a_refused_reading_is_answered_without_parameters_and_with_its_ctrl() {
    let reply = raw(&mut strict(), 10, 0x50, &[]);
    assert_eq!(reply[0].bytes(), [0xAA, 0xAA, 0x02, 0x0A, 0x50, 0xA6]);
}

#[test]
fn what_ends_where_it_should_rests_on_nothing_about_refusals() {
    let mut bench = running_arm();
    bench.enqueue(&joints_to([20.0, 45.0, 45.0, 0.0]));
    bench.enqueue(&suck(true));
    bench.rest();
    assert_eq!(bench.current_index(), 2);
    assert_eq!(bench.arm.fidelity().uses(Assumption::RefusedFinishes), 0);
}
