use magician_protocol::commands::{CpLeCmd, CpParams};
use magician_protocol::{CpMode, Ctrl, Flag, FrameBuf, Set};
use magician_sim::LinkId;

use super::rig::{Rig, SECOND, START, along, burnt, laser, rest_to_rest, segment, started};
use crate::connection::{Request, Settings};
use crate::stream::{Item, StreamSettings};

/// Time for which the laser of this arm stays lit without further requests.
fn burns_on(rig: &Rig) -> u64 {
    let mut arm = rig.pair.arm.clone();
    let begin = arm.now();
    let mut last = begin;
    for step in 1..=1500 {
        let now = begin.after_micros(step * 5_000);
        arm.advance(now);
        if arm.state().laser {
            last = now;
        }
    }
    last.micros_since(begin)
}

/// Engraves, and lets the host die in the middle, again and again. Returns the longest time that
/// the laser burned on, and true if it burned at all.
fn engrave(program: &[Item], settings: StreamSettings) -> (u64, bool) {
    let mut rig = Rig::new(Settings::ORDERED, settings, program);
    let (mut longest, mut lit, mut turns) = (0, false, 0_u32);
    while !rig.stream.is_over() {
        rig.turn(600 * SECOND);
        turns += 1;
        lit |= rig.pair.arm.state().laser;
        if turns.is_multiple_of(7) {
            longest = longest.max(burns_on(&rig));
        }
    }
    assert_eq!(rig.failure(), None);
    assert!(!rig.pair.arm.state().laser);
    let sent: Vec<_> = rig.taken(program).into_iter().flatten().collect();
    let dark = |item: &Item| matches!(item.command, Set::SetEndEffectorLaser(_));
    let order: Vec<_> = sent.iter().filter(|at| !dark(&program[**at])).collect();
    let expected: Vec<_> = (0..program.len())
        .filter(|at| !dark(&program[*at]))
        .collect();
    assert_eq!(
        order,
        expected.iter().collect::<Vec<_>>(),
        "every segment once"
    );
    (longest, lit)
}

/// A line of the switched laser between two dark moves.
fn switched(count: usize, step: f64) -> Vec<Item> {
    let dark = |at: usize| segment(along(step, at), rest_to_rest(step, at));
    let lit = |at: usize| Item {
        laser: true,
        ..dark(at)
    };
    let mut program = vec![dark(1), laser(true, along(step, 1))];
    program.extend((2..count).map(lit));
    program.push(laser(false, along(step, count - 1)));
    program.push(dark(count));
    program
}

/// Duration of the longest command of a program, us.
fn longest_of(program: &[Item]) -> u64 {
    program.iter().map(|item| item.time).max().unwrap()
}

#[test]
fn a_host_that_dies_leaves_the_switched_laser_dark_within_a_second_and_a_segment() {
    // About three segments per second, and about twenty.
    for (step, count) in [(1.0, 40), (0.02, 150)] {
        let program = switched(count, step);
        let (longest, lit) = engrave(&program, StreamSettings::default());
        assert!(lit);
        assert!(longest > 200_000, "{longest}");
        assert!(longest <= 1_000_000 + longest_of(&program), "{longest}");
    }
}

#[test]
fn a_host_that_dies_leaves_the_laser_of_a_path_dark_within_a_second_and_a_segment() {
    for (step, count) in [(1.0, 40), (0.1, 120)] {
        let lit = |at| burnt(along(step, at), rest_to_rest(step, at));
        let mut path = vec![segment(along(step, 0), 900_000)];
        path.extend((1..count).map(lit));
        let (longest, lit) = engrave(&path, StreamSettings::default());
        assert!(lit);
        assert!(longest > 200_000, "{longest}");
        assert!(longest <= 1_000_000 + longest_of(&path), "{longest}");
    }
}

#[test]
fn a_path_whose_laser_is_not_trusted_goes_in_chunks_too() {
    let settings = StreamSettings {
        dark_at_rest: false,
        ..StreamSettings::default()
    };
    let mut path = vec![segment(along(0.5, 0), 900_000)];
    path.extend((1..60).map(|at| burnt(along(0.5, at), rest_to_rest(0.5, at))));
    let mut rig = Rig::new(Settings::ORDERED, settings, &path);
    rig.run(60 * SECOND).unwrap();
    let sealed = rig
        .taken(&path)
        .iter()
        .filter(|place| place.is_none())
        .count();
    assert!(sealed >= 2, "{sealed}");
    assert!(rig.taken(&path).last().unwrap().is_none());
    let (longest, _) = engrave(&path, settings);
    assert!(longest <= 1_000_000 + longest_of(&path), "{longest}");
}

/// Runs a program and asserts that whenever the laser burns, the command that switches it off is in
/// the queue.
fn is_never_lit_without_its_end(rig: &mut Rig) {
    let mut lit = false;
    while !rig.stream.is_over() {
        rig.turn(60 * SECOND);
        let state = rig.pair.arm.state();
        if !state.laser {
            continue;
        }
        lit = true;
        let waiting = (rig.pair.accepted.iter()).filter(|(_, at)| *at > state.queue.current_index);
        let dark = waiting.filter(|(params, _)| params[..] == [1, 0]);
        assert!(dark.count() >= 1);
    }
    assert_eq!(rig.failure(), None);
    assert!(lit);
}

#[test]
fn a_chunk_is_only_started_with_its_end_in_it() {
    let program = switched(100, 0.1);
    let mut rig = Rig::new(Settings::ORDERED, StreamSettings::default(), &program);
    is_never_lit_without_its_end(&mut rig);
}

#[test]
fn a_short_engraving_behind_commands_of_others_is_not_started_in_parts_either() {
    let program = switched(5, 0.1);
    let rig = Rig::new(Settings::ORDERED, StreamSettings::default(), &program);
    let mut rig = started(rig);
    let wait = FrameBuf::new(110, Ctrl::QUEUED, &[4, 0, 0, 0]).unwrap();
    for _ in 0..4 {
        rig.pair.arm.receive(LinkId(7), wait.bytes());
    }
    is_never_lit_without_its_end(&mut rig);
}

/// Limits the speed of the arm's path segments, mm/s.
fn slow(rig: &mut Rig, speed: f32) {
    let speeds = CpParams {
        plan_acc: 100.0,
        junction_vel: speed,
        acc_or_period: 100.0,
        real_time_track: Flag::OFF,
    };
    rig.pair
        .ask(Request::set(&speeds).unwrap(), SECOND)
        .unwrap();
}

#[test]
fn a_long_segment_that_burns_is_cut_into_pieces_of_a_second() {
    // If the end of a path is not dark by itself, a segment without power is added.
    for dark_at_rest in [true, false] {
        let settings = StreamSettings {
            dark_at_rest,
            ..StreamSettings::default()
        };
        long_segments_are_cut(settings);
    }
}

fn long_segments_are_cut(settings: StreamSettings) {
    let [x, _, z] = START;
    let from = segment([x, 1.0, z], 400_000);
    // 60 mm at 3 mm/s: 20 s of burning in a single command.
    let way = [-20.0, 55.0, 13.2];
    let long = burnt([x + way[0], 1.0 + way[1], z + way[2]], 20_000_000);
    let back = Item {
        command: relative(long.command, way.map(|way| -way as f32)),
        end: from.end,
        ..long
    };
    let program = [from, long, back];
    let mut rig = Rig::new(Settings::ORDERED, settings, &program);
    slow(&mut rig, 3.0);
    let begun = rig.pair.now;
    let (mut longest, mut turns, mut most) = (0, 0_u32, 0);
    while !rig.stream.is_over() {
        rig.turn(600 * SECOND);
        turns += 1;
        let state = rig.pair.arm.state();
        if state.laser {
            let share = (state.pose.y - 1.0) / way[1];
            let off = [
                state.pose.x - x - share * way[0],
                state.pose.z - z - share * way[2],
            ];
            assert!(off.iter().all(|off| off.abs() < 0.01), "{:?}", state.pose);
        }
        if turns.is_multiple_of(25) {
            longest = longest.max(burns_on(&rig));
            most = most.max(state.queue.waiting);
        }
    }
    assert_eq!(rig.failure(), None);
    assert!(longest > 500_000, "it burns: {longest}");
    assert!(
        longest <= 2_100_000,
        "a piece and the one under way: {longest}"
    );
    assert!(most <= 3, "{most}");
    let pose = rig.pair.arm.state().pose;
    let ends = [pose.x - x, pose.y - 1.0, pose.z - z];
    assert!(ends.iter().all(|off| off.abs() < 1e-3), "{pose:?}");
    // The pieces follow each other without a stop.
    let took = rig.pair.now - begun;
    assert!(!settings.dark_at_rest || took < 41_500_000, "{took}");
}

/// A relative segment by this increment, mm, with the power of the given one.
fn relative(command: Set, [x, y, z]: [f32; 3]) -> Set {
    let Set::CpLeCmd(segment) = command else {
        panic!()
    };
    let cp_mode = CpMode::Relative;
    Set::CpLeCmd(CpLeCmd {
        cp_mode,
        x,
        y,
        z,
        ..segment
    })
}
