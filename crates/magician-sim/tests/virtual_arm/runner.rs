//! The runner in virtual time: pacing, speed, silence, and independence of cuts.

use std::ops::{Deref, DerefMut};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician_protocol::{Ctrl, FrameBuf};
use magician_sim::{
    ArmInstant, Controller, HostInstant, LineTiming, LinkId, Observer, Profile, Scenario, Speed,
    World,
};
use proptest::prelude::*;

const USB: LinkId = LinkId(0);
const WIFI: LinkId = LinkId(1);

/// Microseconds of the wall clock.
type Micros = u64;

/// A runner with the wall clock in microseconds.
struct Runner(magician_sim::Runner);

impl Runner {
    fn new(controller: Controller, speed: Speed, line: LineTiming) -> Self {
        Self(magician_sim::Runner::new(controller, speed, line))
    }

    fn receive(&mut self, now: Micros, link: LinkId, bytes: &[u8]) {
        self.0.receive(HostInstant::from_micros(now), link, bytes);
    }

    fn handle_timeout(&mut self, now: Micros) {
        self.0.handle_timeout(HostInstant::from_micros(now));
    }

    fn set_speed(&mut self, now: Micros, speed: Speed) {
        self.0.set_speed(HostInstant::from_micros(now), speed);
    }

    fn set_delay(&mut self, delay: Micros) {
        self.0.set_delay(Duration::from_micros(delay));
    }

    fn poll_timeout(&self) -> Option<Micros> {
        self.0.poll_timeout().map(HostInstant::as_micros)
    }

    fn poll_change(&self) -> Option<Micros> {
        self.0.poll_change().map(HostInstant::as_micros)
    }

    fn poll_transmit(&mut self, now: Micros, link: LinkId) -> Option<FrameBuf> {
        self.0.poll_transmit(HostInstant::from_micros(now), link)
    }

    /// Reading of the arm's clock.
    fn arm_now(&self) -> u64 {
        self.controller().now().as_micros()
    }
}

impl Deref for Runner {
    type Target = magician_sim::Runner;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl DerefMut for Runner {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

fn frame(id: u8, ctrl: Ctrl, params: &[u8]) -> Vec<u8> {
    FrameBuf::new(id, ctrl, params).unwrap().bytes().to_vec()
}

fn get_pose() -> Vec<u8> {
    frame(10, Ctrl::GET, &[])
}

fn current_index() -> Vec<u8> {
    frame(246, Ctrl::GET, &[])
}

fn device_time() -> Vec<u8> {
    frame(4, Ctrl::GET, &[])
}

fn wait(ms: u32) -> Vec<u8> {
    frame(110, Ctrl::QUEUED, &ms.to_le_bytes())
}

/// Clears the alarm of power-up and starts the queue.
fn start() -> Vec<u8> {
    [frame(20, Ctrl::SET, &[]), frame(240, Ctrl::SET, &[])].concat()
}

fn runner(speed: Speed, line: LineTiming) -> Runner {
    Runner::new(Controller::new(Profile::default()), speed, line)
}

fn paced(turnaround: Micros) -> LineTiming {
    LineTiming {
        baud: Some(115_200),
        turnaround: Duration::from_micros(turnaround),
    }
}

fn number(reply: &FrameBuf) -> u64 {
    let params = reply.frame().params().to_vec();
    let low = |bytes: &[u8]| {
        bytes
            .iter()
            .rev()
            .fold(0, |sum, byte| sum << 8 | u64::from(*byte))
    };
    low(&params[..params.len().min(8)])
}

/// Replies that have reached a peer by an instant.
fn replies(runner: &mut Runner, now: Micros, link: LinkId) -> Vec<FrameBuf> {
    std::iter::from_fn(|| runner.poll_transmit(now, link)).collect()
}

/// Next reply on a link, and its time.
fn reply(runner: &mut Runner, now: &mut Micros, link: LinkId) -> FrameBuf {
    loop {
        if let Some(reply) = runner.poll_transmit(*now, link) {
            return reply;
        }
        *now = runner
            .poll_timeout()
            .expect("a reply is on its way")
            .max(*now);
        runner.handle_timeout(*now);
    }
}

/// Sends requests one by one, each after the answer to the last; returns the number per second.
fn stop_and_wait(request: &[u8], turnaround: Micros) -> f64 {
    let mut runner = runner(Speed::default(), paced(turnaround));
    let mut now = 0;
    for _ in 0..500 {
        runner.receive(now, USB, request);
        reply(&mut runner, &mut now, USB);
    }
    500e6 / now as f64
}

#[track_caller]
fn within_2_percent(found: f64, expected: f64) {
    assert!(
        (found / expected - 1.0).abs() < 0.02,
        "{found} is not {expected}"
    );
}

#[test]
fn stop_and_wait_runs_at_the_rate_of_the_line() {
    let ptp = frame(84, Ctrl::QUEUED, &[0; 17]);
    for (request, rates) in [
        (get_pose(), [262.0, 172.0, 128.0]),
        (ptp, [311.0, 192.0, 139.0]),
        (current_index(), [576.0, 268.0, 174.0]),
    ] {
        for (turnaround, rate) in [0, 2_000, 4_000].into_iter().zip(rates) {
            within_2_percent(stop_and_wait(&request, turnaround), rate);
        }
    }
}

#[test]
fn a_pipelined_stream_is_bound_by_the_slower_direction() {
    let ptp = frame(84, Ctrl::QUEUED, &[0; 17]);
    for (request, rate) in [(get_pose(), 303.0), (ptp, 501.0), (current_index(), 823.0)] {
        let mut runner = runner(Speed::default(), paced(0));
        let mut now = 0;
        for _ in 0..400 {
            runner.receive(0, USB, &request);
        }
        for _ in 0..400 {
            reply(&mut runner, &mut now, USB);
        }
        within_2_percent(400e6 / now as f64, rate);
    }
}

#[test]
fn a_reply_begins_after_its_request_even_if_more_follows() {
    let mut runner = runner(Speed::default(), paced(0));
    let mut now = 0;
    runner.receive(
        0,
        USB,
        &[get_pose(), get_pose(), b"M10".repeat(100)].concat(),
    );
    reply(&mut runner, &mut now, USB);
    assert_eq!(now, 3820); // 44 bytes
    reply(&mut runner, &mut now, USB);
    assert_eq!(now, 7119); // 38 more
}

#[test]
fn a_frame_inside_a_damaged_one_is_answered_when_the_damage_shows() {
    let mut damaged = frame(60, Ctrl::GET, &[0; 20]);
    damaged[10..16].copy_from_slice(&get_pose());
    let mut runner = runner(Speed::default(), paced(0));
    let mut now = 0;
    runner.receive(0, USB, &[damaged, b"M10".repeat(100)].concat());
    reply(&mut runner, &mut now, USB);
    assert_eq!(now, 5556); // 26 bytes there, 38 back
}

#[test]
fn links_do_not_share_a_line() {
    let mut runner = runner(Speed::default(), paced(0));
    for link in [USB, WIFI] {
        runner.receive(0, link, &get_pose());
    }
    for link in [USB, WIFI] {
        let mut now = 0;
        reply(&mut runner, &mut now, link);
        assert_eq!(now, 3820);
    }
}

#[test]
fn turnaround_counts_without_a_baud_rate_too() {
    let mut runner = runner(
        Speed::Max,
        LineTiming {
            baud: None,
            turnaround: Duration::from_micros(700),
        },
    );
    let mut now = 5;
    runner.receive(now, USB, &[get_pose(), get_pose()].concat());
    for _ in 0..2 {
        reply(&mut runner, &mut now, USB);
        assert_eq!(now, 705);
    }
}

#[test]
fn the_arms_clock_is_the_walls_times_the_speed() {
    for (speed, wall) in [(1.0, 3_000_000), (10.0, 300_000), (0.5, 6_000_000)] {
        let mut runner = runner(Speed::Times(speed), LineTiming::default());
        let mut now = 0;
        runner.receive(0, USB, &[start(), wait(3_000)].concat());
        replies(&mut runner, 0, USB);
        while runner.controller().state().queue.current_index == 0 {
            now = runner.poll_timeout().unwrap();
            runner.handle_timeout(now);
        }
        assert_eq!(now, wall, "{speed}");
        runner.receive(wall, USB, &device_time());
        assert_eq!(number(&reply(&mut runner, &mut now, USB)), 3_000);
    }
}

#[test]
fn a_stopped_clock_still_answers() {
    for speed in [0.0, -1.0, f64::NAN] {
        let mut runner = runner(Speed::Times(speed), paced(0));
        let mut now = 0;
        runner.receive(0, USB, &[start(), wait(5), device_time()].concat());
        for _ in 0..3 {
            reply(&mut runner, &mut now, USB);
        }
        assert_eq!(number(&reply(&mut runner, &mut now, USB)), 0);
    }
}

#[test]
fn at_full_speed_a_command_has_finished_before_the_next_request_is_read() {
    let mut runner = runner(Speed::Max, LineTiming::default());
    let mut now = 0;
    let requests = [
        start(),
        wait(60_000),
        current_index(),
        wait(3_600_000),
        current_index(),
        device_time(),
    ];
    runner.receive(0, USB, &requests.concat());
    let answers: Vec<u64> = (0..7)
        .map(|_| number(&reply(&mut runner, &mut now, USB)))
        .collect();
    assert_eq!(answers[2..], [2, 2, 3, 3, 3_660_000]);
    assert_eq!(now, 0);
}

#[test]
fn at_full_speed_the_arm_is_there_when_it_is_asked() {
    let mut runner = runner(Speed::Max, LineTiming::default());
    let target: [f32; 4] = [220.0, 30.0, 40.0, 15.0];
    let mode = [1]; // MOVJ to Cartesian coordinates
    let move_to = [&mode[..], target.map(f32::to_le_bytes).as_flattened()].concat();
    let requests = [start(), frame(84, Ctrl::QUEUED, &move_to), get_pose()];
    runner.receive(0, USB, &requests.concat());
    let pose = (0..4)
        .map(|_| runner.poll_transmit(0, USB).unwrap())
        .last()
        .unwrap();
    assert_eq!(pose.frame().params()[..16], move_to[1..]);
    assert!(runner.arm_now() > 100_000);
}

#[test]
fn at_full_speed_nothing_scheduled_runs_at_wall_speed() {
    let mut runner = runner(Speed::Max, LineTiming::default());
    let mut now = 2_000_000;
    runner.receive(now, USB, &[start(), wait(60_000)].concat());
    now += 1_500_000;
    runner.handle_timeout(now);
    runner.receive(now, USB, &device_time());
    for _ in 0..3 {
        reply(&mut runner, &mut now, USB);
    }
    assert_eq!(number(&reply(&mut runner, &mut now, USB)), 63_500);
}

/// A belt with a cube, a sensor that waits for it, and a button.
const CELL: &str = r#"
    table = { height = -70 }
    conveyor = { start = [200, -100], direction = 90, length = 200, width = 60, height = -40, stepper = 0 }
    object = [{ name = "cube", size = [20, 20, 20], at = [200, -80], on = "belt" }]
    input = [{ address = 15, level = 0 }, { address = 15, level = 1, at = 5 }]
"#;

fn runner_in(scenario: &str) -> Runner {
    let world = World::from_scenario(&Scenario::from_toml(scenario).unwrap());
    let controller = Controller::in_world(Profile::default(), world);
    Runner::new(controller, Speed::Max, LineTiming::default())
}

#[test]
fn at_full_speed_the_world_waits_for_the_host() {
    let mut runner = runner_in(CELL);
    // 5000 pulses per second: 33.4 mm/s.
    let belt = frame(135, Ctrl::SET, &[0, 1, 0x88, 0x13, 0, 0]);
    runner.receive(0, USB, &[start(), belt].concat());
    assert_eq!(runner.arm_now(), 0);
    for second in 1..4 {
        runner.handle_timeout(second * 1_000_000);
        assert_eq!(runner.arm_now(), second * 1_000_000);
    }
    let look = runner.controller().look();
    assert!((look.belt_travel() - 100.14).abs() < 0.01);
    assert!(look.object("cube").unwrap().on_belt());
    replies(&mut runner, 3_000_000, USB);
    assert_eq!(runner.poll_timeout(), Some(5_000_000)); // the button, at its time

    // The arm's own work takes no wall time, and the world follows its clock.
    runner.receive(3_000_000, USB, &wait(1_500));
    assert_eq!(runner.arm_now(), 4_500_000);
    runner.handle_timeout(3_400_000);
    replies(&mut runner, 3_400_000, USB);
    assert_eq!(runner.poll_timeout(), Some(3_500_000));
}

#[test]
fn at_full_speed_a_trigger_does_not_wait_for_the_wall_clock() {
    let mut runner = runner_in(CELL);
    let input = frame(130, Ctrl::SET, &[15, 3]);
    let trigger = frame(120, Ctrl::QUEUED, &[15, 0, 0, 1, 0]);
    runner.receive(0, USB, &[start(), input, trigger].concat());
    let answers = replies(&mut runner, 0, USB).len();
    assert_eq!((answers, runner.arm_now()), (4, 5_000_000));
}

#[test]
fn at_full_speed_a_trigger_that_only_a_person_can_meet_is_waited_for() {
    let mut runner = runner_in(CELL);
    let belt = frame(135, Ctrl::SET, &[0, 1, 0x88, 0x13, 0, 0]);
    let trigger = frame(120, Ctrl::QUEUED, &[16, 0, 0, 1, 0]);
    runner.receive(0, USB, &[start(), belt, trigger].concat());
    runner.handle_timeout(1_000_000);
    assert_eq!(runner.arm_now(), 1_000_000);
    assert!(!runner.controller().busy());
}

#[test]
fn at_full_speed_what_the_line_brings_later_is_read_later() {
    let mut runner = runner(Speed::Max, paced(0));
    let mut now = 0;
    runner.receive(0, USB, &[start(), wait(10_000), device_time()].concat());
    for _ in 0..3 {
        reply(&mut runner, &mut now, USB);
    }
    // 28 bytes later, without the wait.
    assert_eq!(number(&reply(&mut runner, &mut now, USB)), 10_002);
}

#[test]
fn at_full_speed_a_move_that_never_ends_does_not_use_up_the_clock() {
    let mut runner = runner(Speed::Max, LineTiming::default());
    let speeds = [f32::MIN_POSITIVE; 8].map(f32::to_le_bytes).concat();
    let slow = frame(80, Ctrl::SET, &speeds);
    let target = [10.0f32, 45.0, 45.0, 0.0].map(f32::to_le_bytes).concat();
    let go = frame(84, Ctrl::QUEUED, &[vec![4], target].concat());
    runner.receive(0, USB, &[start(), slow, go].concat());
    runner.handle_timeout(2_000_000);
    assert_eq!(runner.arm_now(), 2_000_000);
    replies(&mut runner, 2_000_000, USB);
    assert!(runner.poll_timeout().is_none_or(|at| at > 2_000_000));
    runner.receive(2_000_000, USB, &frame(242, Ctrl::SET, &[]));
    assert!(!runner.controller().state().moving);
}

#[test]
fn a_silence_of_50_ms_ends_a_frame() {
    for line in [LineTiming::default(), paced(0)] {
        for (pause, answers) in [(49_000, 1), (51_500, 0)] {
            let mut runner = runner(Speed::default(), line);
            let request = get_pose();
            runner.receive(0, USB, &request[..4]);
            runner.receive(pause, USB, &request[4..]);
            runner.handle_timeout(pause + 10_000);
            let answered = runner.poll_transmit(pause + 10_000, USB);
            assert_eq!(usize::from(answered.is_some()), answers, "{line:?} {pause}");
        }
    }
}

#[test]
fn after_a_silence_the_next_frame_is_taken() {
    let mut runner = runner(Speed::default(), paced(0));
    runner.receive(0, USB, &[0xAA, 0xAA, 0x20, 1, 2, 3]);
    let mut now = 100_000;
    runner.receive(now, USB, &get_pose());
    reply(&mut runner, &mut now, USB);
    assert_eq!(now, 103_820);
}

#[test]
fn nothing_is_due_when_all_is_done() {
    let mut runner = runner(Speed::Max, paced(100));
    let mut now = 0;
    runner.receive(0, USB, &get_pose());
    reply(&mut runner, &mut now, USB);
    while let Some(next) = runner.poll_timeout() {
        assert!(next > now && next < 100_000);
        now = next;
        runner.handle_timeout(now);
    }
}

#[test]
fn what_a_peer_wrote_before_it_left_is_obeyed() {
    let mut runner = runner(Speed::Max, paced(0));
    runner.receive(
        0,
        USB,
        &[start(), wait(1), wait(1), vec![0xAA, 0xAA, 9]].concat(),
    );
    runner.handle_timeout(1_500);
    runner.close(USB);
    runner.handle_timeout(20_000);
    assert_eq!(runner.controller().state().queue.current_index, 3);
    assert!(replies(&mut runner, 20_000, USB).is_empty());
    assert_eq!(runner.poll_timeout(), None);
}

#[test]
fn room_shrinks_by_what_is_under_way() {
    let mut runner = runner(Speed::default(), paced(0));
    assert_eq!(runner.room(USB), 4096);
    runner.receive(0, USB, &get_pose().repeat(100));
    assert_eq!(runner.room(USB), 4096 - 600);
    runner.handle_timeout(100_000);
    assert_eq!(runner.room(USB), 4096usize.saturating_sub(100 * 38));
    runner.receive(100_000, USB, &get_pose().repeat(1000));
    assert_eq!(runner.room(USB), 0);
}

#[test]
fn what_is_on_its_way_when_the_cable_is_pulled_is_lost() {
    for line in [LineTiming::default(), paced(2_000)] {
        let mut runner = runner(Speed::default(), line);
        // Two unread replies, and a request and a half on the line.
        runner.receive(0, USB, &[get_pose(), get_pose()].concat());
        runner.receive(0, WIFI, &[get_pose(), get_pose()[..4].to_vec()].concat());
        runner.unplug();
        assert!(!runner.plugged());
        assert_eq!(runner.poll_timeout(), None, "{line:?}");
        runner.plug();
        // The other half is not a request, and is dropped before the next one.
        runner.receive(10, WIFI, &get_pose()[4..]);
        let mut now = 10;
        runner.receive(now, USB, &current_index());
        runner.receive(now, WIFI, &current_index());
        for link in [USB, WIFI] {
            assert_eq!(reply(&mut runner, &mut now, link).frame().id(), 246);
        }
    }
}

#[test]
fn without_the_cable_the_arm_goes_on_and_hears_nothing() {
    let mut runner = runner(Speed::default(), LineTiming::default());
    runner.receive(0, USB, &[start(), wait(3_000)].concat());
    runner.unplug();
    runner.receive(1_000, USB, &[wait(1), get_pose()].concat());
    assert_eq!(runner.room(USB), 4096);
    assert_eq!(runner.poll_timeout(), Some(3_000_000));
    runner.handle_timeout(4_000_000);
    assert!(replies(&mut runner, 4_000_000, USB).is_empty());
    runner.plug();
    let mut now = 4_000_000;
    runner.receive(now, USB, &current_index());
    assert_eq!(number(&reply(&mut runner, &mut now, USB)), 2);
    assert_eq!(runner.controller().state().queue.waiting, 0);
}

#[test]
fn every_pull_is_counted_once() {
    let mut runner = runner(Speed::default(), LineTiming::default());
    assert_eq!((runner.plugged(), runner.pulls()), (true, 0));
    for pulls in [1, 2] {
        runner.unplug();
        runner.unplug();
        assert_eq!((runner.plugged(), runner.pulls()), (false, pulls));
        runner.plug();
        runner.plug();
        assert_eq!((runner.plugged(), runner.pulls()), (true, pulls));
    }
}

#[test]
fn a_slow_arm_answers_later_and_in_order() {
    for (line, quick) in [(LineTiming::default(), 0), (paced(2_000), 5_820)] {
        let mut runner = runner(Speed::Max, line);
        let mut now = 0;
        runner.set_delay(300_000);
        runner.receive(0, USB, &get_pose());
        reply(&mut runner, &mut now, USB);
        assert_eq!(now, 300_000 + quick);

        // The fast answer waits for the slow one before it.
        let begin = now;
        runner.receive(now, USB, &get_pose());
        runner.handle_timeout(now + 1_000);
        runner.set_delay(0);
        runner.receive(now + 1_000, USB, &current_index());
        assert_eq!(reply(&mut runner, &mut now, USB).frame().id(), 10);
        assert_eq!(now - begin, 300_000 + quick);
        assert_eq!(reply(&mut runner, &mut now, USB).frame().id(), 246);

        let begin = now + 100_000;
        runner.receive(begin, USB, &get_pose());
        now = begin;
        reply(&mut runner, &mut now, USB);
        assert_eq!(now - begin, quick);
    }
}

#[test]
fn the_wall_clock_does_not_run_back() {
    let mut runner = runner(Speed::default(), LineTiming::default());
    runner.handle_timeout(5_000_000);
    runner.receive(1_000, USB, &device_time());
    assert_eq!(
        number(&runner.poll_transmit(5_000_000, USB).unwrap()),
        5_000
    );
}

fn speeds() -> impl Strategy<Value = Speed> {
    prop_oneof![Just(Speed::Max), (0.01f64..100.0).prop_map(Speed::Times)]
}

fn lines() -> impl Strategy<Value = LineTiming> {
    let baud = prop_oneof![Just(None), (9_600u32..1_000_000).prop_map(Some)];
    (baud, 0u64..5_000).prop_map(|(baud, turnaround)| LineTiming {
        baud,
        turnaround: Duration::from_micros(turnaround),
    })
}

/// Bytes that hosts send, and some that they do not.
fn requests() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        Just(get_pose()),
        Just(current_index()),
        Just(device_time()),
        Just(start()),
        (0u32..500).prop_map(wait),
        Just(b"M10\r\n".to_vec()),
        prop::collection::vec(prop_oneof![Just(0xAA), any::<u8>()], 1..12),
    ]
}

/// Executes a script of (pause, link, bytes); returns all replies with their times.
fn transcript(
    speed: Speed,
    line: LineTiming,
    script: &[(Micros, LinkId, Vec<u8>)],
    cut: usize,
    looks: &[Micros],
) -> Vec<(Micros, LinkId, Vec<u8>)> {
    let mut runner = runner(speed, line);
    let mut story = Vec::new();
    let mut now = 0;
    let run = |runner: &mut Runner, until: Micros, story: &mut Vec<_>| {
        let mut looks = looks.iter().copied().filter(|look| *look <= until);
        loop {
            let due = runner.poll_timeout().filter(|due| *due <= until);
            let Some(at) = due.into_iter().chain(looks.next()).min() else {
                break;
            };
            runner.handle_timeout(at);
            for link in [USB, WIFI] {
                for reply in replies(runner, at, link) {
                    story.push((at, link, reply.bytes().to_vec()));
                }
            }
            if due.is_none() {
                break;
            }
        }
    };
    for (pause, link, bytes) in script {
        now += pause;
        run(&mut runner, now, &mut story);
        for piece in bytes.chunks(cut) {
            runner.receive(now, *link, piece);
        }
    }
    run(&mut runner, now + 60_000_000, &mut story);
    story
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn cuts_of_bytes_and_time_change_nothing(
        speed in speeds(),
        line in lines(),
        script in prop::collection::vec(
            (0u64..80_000, prop_oneof![Just(USB), Just(WIFI)], requests()), 1..30),
        cut in 1usize..8,
        looks in prop::collection::vec(0u64..2_000_000, 0..20),
    ) {
        let whole = transcript(speed, line, &script, 300, &[]);
        let cut = transcript(speed, line, &script, cut, &looks);
        prop_assert_eq!(whole, cut);
    }

    #[test]
    fn no_bytes_stall_or_break_it(
        speed in speeds(),
        line in lines(),
        chunks in prop::collection::vec(
            (0u64..100_000, prop::collection::vec(prop_oneof![Just(0xAA), any::<u8>()], 0..300)),
            0..20),
    ) {
        let mut runner = runner(speed, line);
        let mut now = 0;
        for (pause, bytes) in chunks {
            now += pause;
            runner.receive(now, USB, &bytes);
            replies(&mut runner, now, USB);
        }
        // Whatever came before: after a silence the next request is answered.
        now += 10_000_000;
        runner.handle_timeout(now);
        replies(&mut runner, now, USB);
        runner.receive(now, USB, &get_pose());
        prop_assert_eq!(reply(&mut runner, &mut now, USB).frame().id(), 10);
    }
}

/// Asks for a sample every 20 ms and counts them.
#[derive(Default)]
struct Counting {
    seen: u64,
    next: ArmInstant,
}

impl Observer for Counting {
    fn next_sample(&self) -> Option<ArmInstant> {
        Some(self.next)
    }

    fn observe(&mut self, arm: &Controller) {
        if arm.now() == self.next {
            self.seen += 1;
            self.next += Duration::from_millis(20);
        }
    }
}

fn watched(speed: Speed) -> (Runner, Arc<Mutex<Counting>>) {
    let mut runner = Runner::new(Controller::default(), speed, LineTiming::default());
    let counting = Arc::new(Mutex::new(Counting::default()));
    runner.observe(Arc::clone(&counting));
    (runner, counting)
}

#[test]
fn an_observer_of_a_leap_over_weeks_does_not_keep_everybody_waiting() {
    let weeks = [start(), wait(u32::MAX)].concat();
    for speed in [Speed::Max, Speed::Times(1e9)] {
        let (mut runner, counting) = watched(speed);
        runner.receive(0, USB, &weeks);
        let (mut wall, mut most) = (0, 0);
        for _ in 0..10 {
            let before = counting.lock().unwrap().seen;
            wall = runner.poll_timeout().unwrap().max(wall);
            runner.handle_timeout(wall);
            most = most.max(counting.lock().unwrap().seen - before);
            replies(&mut runner, wall, USB);
        }
        // At full speed the caller does a pass and a jump.
        assert!((1..=200_000).contains(&most), "{speed}: {most}");
        let seen = counting.lock().unwrap().seen;
        assert_eq!(runner.arm_now() / 20_000, seen - 1, "{speed}");
        runner.receive(wall, WIFI, &device_time());
        assert!(!replies(&mut runner, wall, WIFI).is_empty());
    }
}

#[test]
fn an_observer_is_shown_the_arm_in_good_time() {
    for (speed, apart) in [
        (Speed::Times(0.5), 40_000),
        (Speed::Times(1.0), 20_000),
        (Speed::Times(100.0), 10_000),
        (Speed::Max, 20_000),
    ] {
        let (mut runner, counting) = watched(speed);
        let mut wall = 0;
        for _ in 0..100 {
            let due = runner.poll_timeout().unwrap();
            assert_eq!(due - wall, apart, "{speed}");
            wall = due;
            runner.handle_timeout(wall);
        }
        let now = runner.arm_now();
        assert_eq!(counting.lock().unwrap().seen, now / 20_000 + 1, "{speed}");
    }
    let (runner, _) = watched(Speed::Times(0.0));
    assert_eq!(runner.poll_timeout(), None);
}

/// The arm's clock continues from its reading at either speed; pending work takes its time or none.
#[test]
fn the_speed_may_change_on_the_way() {
    let mut runner = runner(Speed::Times(1.0), LineTiming::default());
    runner.receive(0, USB, &[start(), wait(1000), wait(2000)].concat());
    runner.handle_timeout(400_000);
    let at = |runner: &Runner| (runner.arm_now(), runner.controller().current_index());
    assert_eq!((at(&runner), runner.busy()), ((400_000, 0), true));
    runner.set_speed(500_000, Speed::Times(10.0));
    runner.handle_timeout(600_000);
    assert_eq!(at(&runner), (1_500_000, 2));
    runner.set_speed(600_000, Speed::Max);
    assert_eq!(runner.speed(), Speed::Max);
    runner.handle_timeout(600_000);
    assert_eq!((at(&runner), runner.busy()), ((3_000_000, 3), false));
    runner.set_speed(700_000, Speed::Times(1.0));
    runner.receive(700_000, USB, &wait(100));
    runner.handle_timeout(700_000);
    assert_eq!(at(&runner), (3_100_000, 3));
    runner.handle_timeout(800_000);
    assert_eq!(at(&runner), (3_200_000, 4));
}

/// Replies that a peer does not read stay available, and are no future change.
#[test]
fn unread_replies_are_no_future_change() {
    let line = LineTiming {
        baud: None,
        turnaround: Duration::from_micros(500),
    };
    let mut runner = runner(Speed::Times(1.0), line);
    runner.receive(0, USB, &get_pose());
    assert!(runner.busy());
    assert_eq!(runner.poll_change(), Some(500));
    runner.handle_timeout(500);
    assert!(!runner.busy());
    assert_eq!(runner.poll_timeout(), Some(500));
    assert!(runner.poll_change().is_none_or(|at| at > 500));
    assert!(!replies(&mut runner, 500, USB).is_empty());
}
