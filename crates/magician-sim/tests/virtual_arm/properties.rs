//! Properties of random runs: splitting time or bytes changes nothing, nothing panics, everything
//! ends.

use super::host;
use magician_motion::{Geometry, ToolBias};
use magician_protocol::{Ctrl, FrameBuf, TABLE};
use magician_sim::world::{Body, Press};
use magician_sim::{
    ArmInstant, Controller, ControllerState, ExternalEvent, Flash, LinkId, Profile,
};
use proptest::prelude::*;

/// Control period of the arm.
const PERIOD_US: u64 = 20_000;

/// A number: plausible, extreme, or of arbitrary bits. Boxed, because strategies are large on the
/// stack.
fn number() -> BoxedStrategy<f32> {
    prop_oneof![
        4 => -200.0f32..300.0,
        2 => -5.0f32..5.0,
        1 => prop::sample::select(vec![
            0.0, -0.0, 1.0, 45.0, 90.0, 135.0, -135.0, 1e-40, f32::MIN_POSITIVE, 1e-3, 1e9, 1e30,
            f32::MAX, f32::MIN, f32::INFINITY, f32::NEG_INFINITY, f32::NAN,
        ]),
        1 => any::<u32>().prop_map(f32::from_bits),
    ]
    .boxed()
}

/// Bytes of a request: a command with numbers of any kind, or sometimes garbage.
fn request() -> impl Strategy<Value = Vec<u8>> {
    let ids: Vec<u8> = TABLE.iter().map(|row| row.id).collect();
    let any_command = (
        prop::sample::select(ids),
        0..8u8,
        prop::collection::vec(number(), 0..9),
        0..11u8,
    );
    let motion = (
        0..11u8,
        prop::array::uniform4(number()),
        prop::sample::select(vec![1u8, 3, 3, 3]),
    );
    let reasonable = (
        0..10u8,
        prop::array::uniform4(-60.0f32..60.0),
        prop::sample::select(vec![1u8, 3, 3]),
    );
    let steering = prop::sample::select(vec![240u8, 240, 240, 241, 242, 245, 20, 31]);
    prop_oneof![
        2 => any_command.prop_map(|(id, ctrl, numbers, first)| {
            let mut params = vec![first];
            params.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
            frame(id, ctrl, &params)
        }),
        2 => motion.prop_map(|(mode, numbers, ctrl)| frame(84, ctrl, &ptp_params(mode, numbers))),
        3 => reasonable.prop_map(|(mode, by, ctrl)| {
            let [a, b, c, d] = by;
            let numbers = if matches!(mode, 6..=8) { by } else { [200.0 + a, b, c, d] };
            let numbers = if matches!(mode, 3..=5) { [a, 45.0 + b / 4.0, 45.0 + c / 4.0, d] } else { numbers };
            frame(84, ctrl, &ptp_params(mode, numbers))
        }),
        2 => (steering, prop::sample::select(vec![1u8, 1, 3])).prop_map(|(id, ctrl)| frame(id, ctrl, &[])),
        1 => (0u32..3000).prop_map(|ms| frame(110, 3, &ms.to_le_bytes())),
        1 => Just(frame(10, 0, &[])),
        1 => (prop::array::uniform4(-60.0f32..60.0), prop::collection::vec(any::<u32>(), 0..57)).prop_map(|(by, outputs)| {
            let mut params = ptp_params(7, by);
            params.extend(outputs.iter().flat_map(|output| [*output as u8 % 110, (output >> 8) as u8 % 22, 0, (output >> 16) as u8]));
            frame(88, 3, &params)
        }),
        1 => (number(), number(), number()).prop_map(|(x, y, z)| {
            let params: Vec<u8> = [x, y, z].iter().flat_map(|n| n.to_le_bytes()).collect();
            frame(60, 3, &params)
        }),
        6 => paths(),
        1 => prop::collection::vec(any::<u8>(), 0..30),
    ]
}

/// Commands of paths, arcs and jogs, most of them plausible.
fn paths() -> BoxedStrategy<Vec<u8>> {
    let queued = || prop::sample::select(vec![1u8, 3, 3, 3, 3]);
    let near = || prop::array::uniform3(-25.0f32..25.0);
    let place =
        || prop::array::uniform4(-60.0f32..60.0).prop_map(|[x, y, z, r]| [200.0 + x, y, z, r]);
    let speed = || prop_oneof![4 => 1.0f32..500.0, 1 => number()].boxed();
    prop_oneof![
        6 => (near(), 91u8..93, queued(), 0.0f32..120.0).prop_map(|([x, y, z], id, ctrl, power)| {
            frame(id, ctrl, &after(0, &[x, y, z, power]))
        }),
        2 => (place(), 91u8..93, queued()).prop_map(|([x, y, z, power], id, ctrl)| {
            frame(id, ctrl, &after(1, &[x, y, z, power]))
        }),
        1 => (0..3u8, prop::array::uniform4(number()), 91u8..93).prop_map(|(mode, numbers, id)| {
            frame(id, 3, &after(mode, &numbers))
        }),
        1 => (speed(), speed(), 1.0f32..100.0, 0..4u8, queued()).prop_map(
            |(acceleration, velocity, period, real_time, ctrl)| {
                let mut params = numbers(&[acceleration, velocity, period]);
                params.push(u8::from(real_time == 0));
                frame(90, ctrl, &params)
            }
        ),
        3 => (place(), place(), queued(), prop::option::of(0u32..4)).prop_map(|(via, to, ctrl, count)| {
            let mut params = numbers(&[via, to].concat());
            match count {
                None => frame(101, ctrl, &params),
                Some(count) => {
                    params.extend(count.to_le_bytes());
                    frame(102, ctrl, &params)
                }
            }
        }),
        1 => (prop::array::uniform4(speed()), queued()).prop_map(|(speeds, ctrl)| frame(100, ctrl, &numbers(&speeds))),
        4 => (0..2u8, 0..10u8, queued()).prop_map(|(is_joint, command, ctrl)| frame(73, ctrl, &[is_joint, command])),
        1 => (prop::array::uniform8(speed()), 70u8..72, queued()).prop_map(|(speeds, id, ctrl)| {
            frame(id, ctrl, &numbers(&speeds))
        }),
        1 => (speed(), speed(), queued()).prop_map(|(velocity, acceleration, ctrl)| {
            frame(72, ctrl, &numbers(&[velocity, acceleration]))
        }),
    ]
    .boxed()
}

fn numbers(numbers: &[f32]) -> Vec<u8> {
    numbers
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect()
}

fn after(first: u8, rest: &[f32]) -> Vec<u8> {
    let mut params = vec![first];
    params.extend(numbers(rest));
    params
}

fn ptp_params(mode: u8, numbers: [f32; 4]) -> Vec<u8> {
    let mut params = vec![mode];
    params.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    params
}

fn frame(id: u8, ctrl: u8, params: &[u8]) -> Vec<u8> {
    FrameBuf::new(id, Ctrl(ctrl), params)
        .unwrap()
        .bytes()
        .to_vec()
}

/// A frame of an interrupted path: a segment, start, stop, forced stop, clear, or clear alarms.
fn interfered() -> impl Strategy<Value = Vec<u8>> {
    let near = prop::array::uniform3(-12.0f32..12.0);
    let place = prop::array::uniform3(-60.0f32..60.0);
    let steering = prop::sample::select(vec![240u8, 240, 241, 245, 242, 20]);
    prop_oneof![
        12 => (near, 91u8..93).prop_map(|([x, y, z], id)| frame(id, 3, &after(0, &[x, y, z, 50.0]))),
        2 => (place, 91u8..93).prop_map(|([x, y, z], id)| frame(id, 3, &after(1, &[200.0 + x, y, z, 50.0]))),
        2 => steering.prop_map(|id| frame(id, 1, &[])),
    ]
}

/// Tolerance for a motion beyond a limit, degrees. A crossing is exact to a microsecond, in which
/// the fastest joint turns by 0.0003 degrees.
const BEYOND: f64 = 3e-4;

/// True if the joints are within the controller's limits (model section 4).
fn within_limits(state: &ControllerState) -> bool {
    let [j1, j2, j3, j4] = state.joints.to_array();
    let within =
        |angle: f64, least: f64, most: f64| angle > least - BEYOND && angle < most + BEYOND;
    within(j1, -135.0, 135.0)
        && within(j2, -13.5, 90.0)
        && within(j3, -15.0, 90.0)
        && within(j4, -150.0, 150.0)
        && within(j2 - j3, -70.0, 55.0)
}

/// Commands for pins, tools, triggers, motors and the rail.
fn connectors() -> impl Strategy<Value = Vec<u8>> {
    let pin = prop::sample::select(vec![1u8, 2, 4, 9, 14, 15, 16, 17, 21]);
    let ctrl = || prop::sample::select(vec![1u8, 3, 3]);
    let motor = (0..3u8, 0..2u8, -5000i32..5000, 0..20_000u32, ctrl());
    let modes = (
        0..10u8,
        prop::array::uniform4(-30.0f32..30.0),
        -200.0f32..1200.0,
    );
    prop_oneof![
        2 => (pin.clone(), 0..7u8, ctrl()).prop_map(|(pin, what, ctrl)| frame(130, ctrl, &[pin, what])),
        2 => (pin.clone(), 0..2u8, ctrl()).prop_map(|(pin, level, ctrl)| frame(131, ctrl, &[pin, level])),
        1 => (pin.clone(), number(), number()).prop_map(|(pin, frequency, duty)| {
            let mut params = vec![pin];
            params.extend([frequency, duty].iter().flat_map(|n| n.to_le_bytes()));
            frame(132, 1, &params)
        }),
        2 => (pin, 0..2u8, 0..4u8, 0..4096u16, ctrl()).prop_map(|(pin, mode, condition, threshold, ctrl)| {
            let [low, high] = if mode == 0 { [threshold as u8 % 2, 0] } else { threshold.to_le_bytes() };
            frame(120, ctrl, &[pin, mode, condition, low, high])
        }),
        2 => motor.prop_map(|(motor, enabled, speed, distance, ctrl)| {
            let mut params = vec![motor, enabled];
            params.extend(speed.to_le_bytes());
            params.extend(distance.to_le_bytes());
            if distance % 2 == 0 { frame(136, ctrl, &params) } else { frame(135, ctrl, &params[..6]) }
        }),
        1 => (0..3u8, 0..2u8, 0..2u8, ctrl()).prop_map(|(tool, enabled, on, ctrl)| frame(61 + tool, ctrl, &[enabled, on])),
        1 => (0..4u8).prop_map(|on| frame(3, 1, &[on.min(1), 0])),
        3 => (modes, ctrl()).prop_map(|((mode, by, rail), ctrl)| {
            let [a, b, c, d] = by;
            let numbers = if matches!(mode, 3..=5) { [a, 45.0 + b / 4.0, 45.0 + c / 4.0, d] } else { [200.0 + a, b, c, d] };
            let numbers = if matches!(mode, 6..=8) { by } else { numbers };
            let mut params = ptp_params(mode, numbers);
            params.extend(rail.to_le_bytes());
            if c > 0.0 { return frame(86, ctrl, &params) }
            params.extend([a.abs() as u8, 16, 0, 1, 60, 17, 0, 1]);
            frame(89, ctrl, &params)
        }),
        2 => prop::sample::select(vec![0u8, 9, 9, 10]).prop_map(|cmd| frame(73, 1, &[0, cmd])),
        1 => (number(), number(), prop::sample::select(vec![74u8, 85])).prop_map(|(velocity, acceleration, id)| {
            let params: Vec<u8> = [velocity, acceleration].iter().flat_map(|n| n.to_le_bytes()).collect();
            frame(id, 3, &params)
        }),
    ]
}

/// An action in a run: the host sends, or an external event.
#[derive(Clone, Debug)]
enum Deed {
    Send(Vec<u8>),
    Happen(ExternalEvent),
    Level(u8, bool),
    Voltage(u8, u16),
}

/// Key presses, hands and faults.
fn external_event() -> impl Strategy<Value = ExternalEvent> {
    let degrees = prop_oneof![4 => -20.0f64..20.0, 1 => number().prop_map(f64::from)];
    let joint_state = (
        -150.0f64..150.0,
        -20.0f64..100.0,
        -30.0f64..100.0,
        -160.0f64..160.0,
    );
    prop_oneof![
        2 => (0..6u8, degrees).prop_map(|(joint, degrees)| ExternalEvent::Slip { joint, degrees }),
        3 => any::<bool>().prop_map(ExternalEvent::Unlock),
        2 => joint_state.prop_map(|(a, b, c, d)| ExternalEvent::Guide([a, b, c, d].into())),
        1 => any::<bool>().prop_map(|stalls| ExternalEvent::Touch { body: Body::Table, stalls }),
        1 => any::<u8>().prop_map(ExternalEvent::Alarm),
        1 => Just(ExternalEvent::Reset),
        3 => Just(ExternalEvent::Key(Press::Short)),
        1 => Just(ExternalEvent::Key(Press::Long)),
    ]
}

/// A run: pauses and actions.
fn life() -> impl Strategy<Value = Vec<(u64, Deed)>> {
    let pause =
        prop_oneof![2 => Just(0), 2 => 0..200_000u64, 2 => 0..5_000_000u64, 1 => 0..40_000_000u64];
    let input = prop::sample::select(vec![1u8, 9, 14, 15, 200]);
    let deed = prop_oneof![
        4 => request().prop_map(Deed::Send),
        4 => connectors().prop_map(Deed::Send),
        1 => (input.clone(), any::<bool>()).prop_map(|(input, level)| Deed::Level(input, level)),
        1 => (input, 0..5000u16).prop_map(|(input, value)| Deed::Voltage(input, value)),
        1 => external_event().prop_map(Deed::Happen),
        1 => (0..4u32).prop_map(|loops| {
            let [a, b] = [loops, 3].map(u32::to_le_bytes);
            Deed::Send(frame(243, 1, &[a, b].concat()))
        }),
        1 => Just(Deed::Send(frame(244, 1, &[]))),
    ];
    prop::collection::vec((pause, deed), 1..40)
}

/// Applies an action to an arm.
fn act(arm: &mut Controller, deed: &Deed) {
    act_by(arm, deed, |arm, bytes| arm.receive(LinkId(0), bytes));
}

/// Applies an action to an arm; the caller decides how bytes are sent.
fn act_by(arm: &mut Controller, deed: &Deed, send: impl FnOnce(&mut Controller, &[u8])) {
    match deed {
        Deed::Send(bytes) => send(arm, bytes),
        Deed::Happen(event) => arm.inject(*event),
        Deed::Level(input, level) => {
            arm.set_input(*input, *level);
        }
        Deed::Voltage(input, value) => {
            arm.set_analog(*input, *value);
        }
    }
}

/// Ends a stored program and releases the unlock key, since either may last forever.
fn let_go(arm: &mut Controller) {
    if arm.state().program {
        arm.press(Press::Short);
    }
    arm.unlock(false);
}

/// Ends a trigger that may wait forever. Returns true if there was one.
fn give_up(arm: &mut Controller) -> bool {
    let waits = arm.state().awaits_input.is_some();
    if waits {
        arm.receive(LinkId(0), &frame(241, 1, &[]));
        arm.receive(LinkId(0), &frame(240, 1, &[]));
    }
    waits
}

/// Complete visible state of an arm, bit for bit.
fn fingerprint(arm: &Controller) -> String {
    let state = arm.state();
    let bits = |values: [f64; 4]| values.map(f64::to_bits);
    let steppers = arm.steppers();
    format!(
        "{:x?} {:x?} {:x?} {:x?} {state:?} {steppers:?} {:?}",
        bits(state.pose.to_array()),
        bits(state.joints.to_array()),
        state.rail.map(f64::to_bits),
        steppers.map(|stepper| stepper.pulses.to_bits()),
        arm.pins().map(|pin| (pin.signal, pin.input, pin.analog)),
    )
}

fn switched_on() -> Controller {
    let mut arm = Controller::new(Profile::default());
    arm.receive(LinkId(0), &frame(240, 1, &[]));
    arm
}

/// Executes a run; returns the replies and the states after each action as text.
fn live(
    life: &[(u64, Deed)],
    mut advance: impl FnMut(&mut Controller, ArmInstant),
    mut send: impl FnMut(&mut Controller, &[u8]),
) -> String {
    let mut arm = switched_on();
    let mut story = String::new();
    for (pause, deed) in life {
        let to = arm.now().after_micros(*pause);
        advance(&mut arm, to);
        act_by(&mut arm, deed, &mut send);
        tell(&mut arm, &mut story);
    }
    story
}

/// Appends the pending replies and events of an arm and its visible state to the log.
fn tell(arm: &mut Controller, story: &mut String) {
    while let Some(reply) = arm.poll_transmit(LinkId(0)) {
        story.push_str(&format!("{reply:?}\n"));
    }
    story.push_str(&fingerprint(arm));
    story.push_str(&format!("{:?}\n", arm.poll_timeout()));
    while let Some(event) = arm.poll_event() {
        story.push_str(&format!("{event:?}\n"));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn cuts_of_time_and_bytes_change_nothing(life in life(), seed in any::<u64>()) {
        let whole = live(&life, |arm, to| arm.advance(to), |arm, bytes| arm.receive(LinkId(0), bytes));
        let mut dice = seed | 1;
        let mut roll = move |below: u64| {
            dice ^= dice << 13;
            dice ^= dice >> 7;
            dice ^= dice << 17;
            dice % below.max(1)
        };
        let mut other = roll;
        let cut = live(
            &life,
            |arm, to| {
                while arm.now() < to {
                    let step = 1 + roll(to.micros_since(arm.now()).min(700_000));
                    arm.advance(arm.now().after_micros(step).min(to));
                    let _ = arm.state();
                }
            },
            |arm, bytes| {
                let mut left = bytes;
                while !left.is_empty() {
                    let (now, later) = left.split_at(1 + other(left.len() as u64) as usize);
                    let mut input = now;
                    while arm.receive_one(LinkId(0), &mut input) {}
                    left = later;
                }
            },
        );
        prop_assert_eq!(&whole, &cut);
        let again = live(&life, |arm, to| arm.advance(to), |arm, bytes| arm.receive(LinkId(0), bytes));
        prop_assert_eq!(whole, again);
    }

    #[test]
    fn going_from_event_to_event_always_ends(life in life()) {
        let mut arm = switched_on();
        for (pause, deed) in &life {
            arm.advance(arm.now().after_micros(*pause));
            act(&mut arm, deed);
            prop_assert!(arm.poll_timeout().is_none_or(|at| at > arm.now()), "nothing due is left undone");
        }
        let_go(&mut arm);
        let mut steps = 0;
        loop {
            while let Some(at) = arm.poll_timeout() {
                prop_assert!(at > arm.now());
                arm.advance(at);
                steps += 1;
                prop_assert!(steps < 3000, "32 commands hold no more events than that");
            }
            if !give_up(&mut arm) {
                break;
            }
        }
        let state = arm.state();
        prop_assert!(!state.moving && state.queue.running.is_none());
    }

    #[test]
    fn no_path_leaves_the_limits_and_none_outruns_what_was_set_by_more_than_half(
        steps in prop::collection::vec((prop_oneof![3 => Just(0u64), 2 => 0..400_000u64], interfered()), 1..60),
        plan_acc in 20.0f32..400.0,
        junction_vel in 5.0f32..300.0,
    ) {
        let mut arm = switched_on();
        let mut params = numbers(&[plan_acc, junction_vel, 100.0]);
        params.push(0);
        arm.receive(LinkId(0), &frame(90, 1, &params));
        let mut pieces = steps.iter();
        loop {
            let until = match pieces.next() {
                Some((pause, bytes)) => {
                    arm.receive(LinkId(0), bytes);
                    arm.now().after_micros(*pause)
                }
                None => match arm.poll_timeout() {
                    Some(at) => at,
                    None => break,
                },
            };
            while arm.now() < until {
                let before = arm.state();
                arm.advance(before.now.after_micros(1000).min(until));
                let now = arm.state();
                prop_assert!(within_limits(&now), "{now:?}");
                // Poses change only at the end of a period. A segment of less than 1.5 periods is
                // done in one period, so it may run up to 50 % faster.
                let period = before.now.as_micros() / PERIOD_US != now.now.as_micros() / PERIOD_US;
                let way = now.pose.distance_to(&before.pose);
                let most = if period { 1.5 * f64::from(junction_vel) * PERIOD_US as f64 / 1e6 } else { 0.0 };
                prop_assert!(way <= most + 1e-9, "{way} mm at {:?}", now.now);
                prop_assert!(now.moving || !now.laser, "the laser never burns at rest: {now:?}");
            }
        }
        let state = arm.state();
        prop_assert!(!state.moving && !state.laser && state.queue.running.is_none());
    }

    #[test]
    fn arcs_and_jogs_stay_within_the_limits(life in prop::collection::vec((0..1_500_000u64, paths()), 1..20)) {
        let mut arm = switched_on();
        for (pause, bytes) in &life {
            arm.receive(LinkId(0), bytes);
            let until = arm.now().after_micros(*pause);
            while arm.now() < until {
                arm.advance(arm.now().after_micros(5_000).min(until));
                let state = arm.state();
                prop_assert!(within_limits(&state), "{state:?}");
            }
        }
    }

    #[test]
    fn no_order_tears_the_arm_from_where_it_is(life in life()) {
        let mut arm = switched_on();
        for (pause, deed) in &life {
            arm.advance(arm.now().after_micros(*pause));
            let before = arm.state();
            act(&mut arm, deed);
            let state = arm.state();
            let joints = state.true_joints.to_array().into_iter().zip(before.true_joints.to_array());
            for (is, was) in joints.filter(|_| matches!(deed, Deed::Send(_))) {
                prop_assert!((is - was).abs() < 2e-3, "{before:?}\n{state:?}");
            }
            let ToolBias { x, y, z } = state.tool;
            if [x, y, z].iter().all(|bias| bias.abs() < 1e3) {
                let pose = Geometry::magician(state.tool).forward(&state.joints);
                prop_assert!(pose.distance_to(&state.pose) < 1e-4, "{pose:?}\n{state:?}");
            }
        }
    }

    #[test]
    fn indices_and_places_add_up(life in life()) {
        let mut arm = switched_on();
        let mut last = 0;
        for (pause, deed) in &life {
            arm.advance(arm.now().after_micros(*pause));
            act(&mut arm, deed);
            let state = arm.state();
            let taken = state.queue.waiting + usize::from(state.queue.running.is_some());
            prop_assert!(taken <= state.queue.capacity);
            if matches!(deed, Deed::Happen(ExternalEvent::Reset)) {
                last = 0;
            }
            prop_assert!(state.queue.current_index >= last, "the current index never falls");
            last = state.queue.current_index;
            prop_assert!(state.joints.is_finite() && state.true_joints.is_finite());
            prop_assert!(state.rail.is_none_or(|at| (0.0..=1000.0).contains(&at)));
            prop_assert!(!(state.suction.commanded && state.gripper.commanded), "one pump");
            prop_assert!((0.0..=100.0).contains(&state.laser_power));
        }
    }

    #[test]
    fn a_copy_goes_on_as_the_original_does(life in life(), at in any::<prop::sample::Index>(), within in any::<u64>()) {
        let (before, after) = life.split_at(at.index(life.len()));
        let mut arm = switched_on();
        for (pause, deed) in before {
            arm.advance(arm.now().after_micros(*pause));
            act(&mut arm, deed);
        }
        // At some point before the next action.
        let pause = after.first().map_or(0, |(pause, _)| *pause);
        let to = arm.now().after_micros(pause);
        arm.advance(arm.now().after_micros(within % (pause + 1)));
        let mut copy = arm.clone();
        let go_on = |arm: &mut Controller| {
            let mut story = String::new();
            arm.advance(to);
            for (at, (pause, deed)) in after.iter().enumerate() {
                arm.advance(arm.now().after_micros(if at == 0 { 0 } else { *pause }));
                act(arm, deed);
                tell(arm, &mut story);
            }
            let_go(arm);
            for _ in 0..3000 {
                let Some(at) = arm.poll_timeout() else { break };
                arm.advance(at);
                tell(arm, &mut story);
            }
            format!("{story}{:?}", arm.flash())
        };
        let told = go_on(&mut arm);
        prop_assert_eq!(go_on(&mut copy), told, "and what one does is nothing to the other");
    }

    #[test]
    fn a_flash_reads_back_as_it_was_written(life in life()) {
        let mut arm = switched_on();
        let mut writes = 0;
        for (pause, deed) in &life {
            let before = arm.flash().clone();
            arm.advance(arm.now().after_micros(*pause));
            act(&mut arm, deed);
            let text = format!("{:?}", arm.flash());
            if arm.flash_writes() == writes {
                prop_assert_eq!(&text, &format!("{before:?}"));
            }
            writes = arm.flash_writes();
            let read = Flash::from_toml(&arm.flash().to_toml()).unwrap();
            prop_assert_eq!(format!("{read:?}"), text);
        }
    }
}

/// The hostile host of the fuzz target and the soak run: no panic, no endless motion, a consistent
/// arm.
#[test]
fn a_hostile_host() {
    for seed in 1..=60u64 {
        let mut dice = seed;
        let mut roll = || {
            dice = dice.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
            (dice >> 33) as u8
        };
        let script: Vec<u8> = (0..20_000).map(|_| roll()).collect();
        let mut life = host::Life::default();
        life.live(&script);
        assert!(life.steps > 500);
        let mut pieces = host::Life::in_pieces();
        pieces.live(&script);
        assert_eq!(life.story, pieces.story, "seed {seed}: cuts of time");
        life.end();
    }
}
