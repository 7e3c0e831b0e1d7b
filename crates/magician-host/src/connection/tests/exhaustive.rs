//! Exhaustive exploration of short programs on a bad line.
//!
//! The model has a queue of a few places, a few commands, and a line that may lose, duplicate and
//! delay each frame; the controller may be reset and the queue cleared at each instant. All choices
//! are explored, with a bounded number of faults per run. The connection is the real one.
//!
//! The property: each command is taken once and in order, or its fate is reported as unknown.
//! Commands reported as not taken were not taken; confirmed commands have the index that they
//! claim.

use std::collections::{HashMap, VecDeque};

use magician_protocol::commands::{
    CpCmd, DeviceTime, QueuedCmdClear, QueuedCmdCurrentIndex, QueuedCmdLeftSpace, WaitCmd,
};
use magician_protocol::{Ctrl, FrameBuf, NoArgs, Writable};

use super::toy::{TICK, Toy};
use crate::connection::planted_bug::{PlantedBug, is_noticed};
use crate::connection::{
    Connection, Event, Failure, IndexLaw, Micros, Priority, Request, Settings, Ticket,
};
use crate::pair::index_of;

/// Tick by which every run has ended.
const END: u64 = 600;

/// Ticks without a line.
const AWAY: u64 = 6;

/// A numbered queued command; every third has another id.
fn command(number: u32) -> Request {
    let id = if number.is_multiple_of(3) {
        CpCmd::ROW.id
    } else {
        WaitCmd::ROW.id
    };
    Request::raw(id, Ctrl::QUEUED, &number.to_le_bytes()).unwrap()
}

/// Parameters of an exploration: settings, program, queue, and the faults allowed in one run.
#[derive(Clone, Copy, Debug)]
struct Scope {
    settings: Settings,
    commands: u32,
    places: usize,
    takes: u64,
    mishaps: u32,
    /// True if frames may be duplicated (datagrams).
    doubles: bool,
    resets: bool,
    clears: bool,
    /// True if the cable may be pulled; it is back after [`AWAY`] ticks.
    cuts: bool,
    /// For an arm that is only known to be at rest, because nothing was accepted before: the number
    /// of indices given to commands that an earlier connection dropped.
    fresh: Option<u64>,
    /// True if a read is submitted behind each command, not only behind one.
    reads: bool,
    /// True if the controller breaks errata E06 and answers reads before commands that arrived with
    /// them.
    reads_first: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Direction {
    ToArm,
    ToHost,
}

#[derive(Clone)]
struct World {
    scope: Scope,
    tick: u64,
    host: Connection,
    toy: Toy,
    /// Frames just put on the line, whose fates are chosen one by one.
    undecided: VecDeque<(Direction, FrameBuf)>,
    /// Frames under way, with the ticks at which they arrive.
    lines: [VecDeque<(u64, FrameBuf)>; 2],
    mishaps: u32,
    /// True once it is decided whether this tick has a reset, a Clear or a cut.
    calm: bool,
    tickets: HashMap<Ticket, u32>,
    fates: HashMap<u32, Result<u64, Failure>>,
    confirmed: Vec<u32>,
    reported: bool,
    /// Resets that were noticed. Earlier results are no longer confirmed.
    resets: u32,
    doubled: bool,
    /// True if a Clear was sent.
    cleared: bool,
    finishing: bool,
    /// Tick at which the cable is reconnected.
    back: Option<u64>,
}

impl World {
    fn new(scope: Scope) -> Self {
        let mut world = Self {
            scope,
            tick: 0,
            host: Connection::new(Settings {
                // A duplicate of the last command shows only in the left space, so the capacity
                // must be exact.
                capacity: if scope.doubles {
                    scope.places as u32
                } else {
                    scope.settings.capacity
                },
                ..scope.settings
            }),
            toy: Toy {
                places: scope.places,
                // Short, because set-up waits for an empty queue and `scope.takes` may be long.
                takes: 1,
                next: 1 + scope.fresh.unwrap_or(0),
                current: 0,
                queue: VecDeque::new(),
                begun: 0,
                booted: 0,
                accepted: Vec::new(),
            },
            undecided: VecDeque::new(),
            lines: [VecDeque::new(), VecDeque::new()],
            // No faults during set-up.
            mishaps: u32::MAX,
            calm: true,
            tickets: HashMap::new(),
            fates: HashMap::new(),
            confirmed: Vec::new(),
            reported: false,
            resets: 0,
            doubled: false,
            cleared: false,
            finishing: false,
            back: None,
        };
        world.look();
        world.settle();
        if scope.fresh.is_none() {
            // Enough accepted commands for the connection to know that the arm follows the law.
            for number in 1..=4 {
                world.submit(number, command(number));
                world.settle();
            }
        }
        for _ in 0..2 {
            world.look();
            world.settle();
        }
        assert_eq!(
            world.host.law() == IndexLaw::Followed,
            scope.fresh.is_none()
        );
        world.toy.takes = scope.takes;
        world.mishaps = 0;
        world.calm = false;
        for number in 5..5 + scope.commands {
            world.submit(number, command(number).repeatable());
            if number == 6 || scope.reads {
                // The three reads differ, as a reply goes to the oldest request of its id.
                let read = match number % 3 {
                    0 => Request::get::<DeviceTime>(&NoArgs),
                    1 => Request::get::<QueuedCmdLeftSpace>(&NoArgs),
                    _ => Request::get::<QueuedCmdCurrentIndex>(&NoArgs),
                };
                let deadline = world.now() + 100 * TICK;
                world.host.submit(read.unwrap().deadline(deadline));
            }
        }
        world
    }

    fn now(&self) -> Micros {
        self.tick * TICK
    }

    fn submit(&mut self, number: u32, request: Request) {
        let ticket = self.host.submit(request.deadline(self.now() + 150 * TICK));
        self.tickets.insert(ticket, number);
    }

    /// Reads values that reveal another host's commands and settle earlier ones.
    fn look(&mut self) {
        let deadline = self.now() + 200 * TICK;
        for read in [
            Request::get::<QueuedCmdCurrentIndex>(&NoArgs).unwrap(),
            Request::get::<QueuedCmdLeftSpace>(&NoArgs).unwrap(),
            Request::get::<DeviceTime>(&NoArgs).unwrap(),
        ] {
            self.host.submit(read.deadline(deadline));
        }
    }

    /// Runs without further faults until nothing is left to do.
    fn settle(&mut self) {
        self.listen();
        while !(self.host.is_idle() && self.undecided.is_empty() && self.toy.queue.is_empty()) {
            assert!(self.tick < END, "no end");
            match self.undecided.pop_front() {
                Some((way, frame)) => self.put(way, frame, 0),
                None => self.pass(),
            }
            self.listen();
        }
    }

    fn put(&mut self, way: Direction, frame: FrameBuf, late: u64) {
        let line = &mut self.lines[way as usize];
        let mut at = self.tick + 1 + late;
        if self.scope.settings.ordered {
            // A delayed frame holds back those behind it.
            at = at.max(line.back().map_or(0, |(at, _)| *at));
        }
        line.push_back((at, frame));
    }

    /// Advances by one tick.
    fn pass(&mut self) {
        self.tick += 1;
        self.calm = false;
        self.toy.pass(self.tick);
        if self.back.take_if(|at| *at <= self.tick).is_some() {
            self.host.restored();
        }
        let mut requests: Vec<_> = std::iter::from_fn(|| self.take(Direction::ToArm)).collect();
        // The sort is stable, so only reads and commands change places.
        if self.scope.reads_first {
            requests.sort_by_key(|request| request.frame().ctrl().queued());
        }
        for request in requests {
            let reply = self.toy.answer(&request, self.tick);
            self.undecided.push_back((Direction::ToHost, reply));
        }
        while let Some(reply) = self.take(Direction::ToHost) {
            let now = self.now();
            self.host.receive(now, reply.bytes());
            self.listen();
        }
        if self.host.poll_timeout().is_some_and(|at| at <= self.now()) {
            self.host.handle_timeout(self.now());
            self.listen();
        }
    }

    fn take(&mut self, way: Direction) -> Option<FrameBuf> {
        let line = &mut self.lines[way as usize];
        let at = line.iter().position(|(at, _)| *at <= self.tick)?;
        line.remove(at).map(|(_, frame)| frame)
    }

    fn listen(&mut self) {
        while let Some(frame) = self.host.poll_transmit(self.now()) {
            self.undecided.push_back((Direction::ToArm, frame));
        }
        while let Some(event) = self.host.poll_event() {
            match event {
                Event::Done { ticket, result } => {
                    if let Some(number) = self.tickets.remove(&ticket) {
                        let fate = result.map(|reply| index_of(&reply));
                        self.fates.insert(number, fate);
                    }
                }
                Event::Unaccounted { .. } => self.reported = true,
                Event::Reset => self.resets += 1,
            }
        }
        self.check_confirmed();
    }

    /// Asserts that confirmed commands have the index that they claim.
    fn check_confirmed(&mut self) {
        let Some(confirmed) = self.host.confirmed_index() else {
            return;
        };
        for (number, fate) in &self.fates {
            let new = !self.confirmed.contains(number);
            if let Ok(index) = fate
                && *index <= confirmed.0
                && new
            {
                self.confirmed.push(*number);
                let mut accepted = self.toy.accepted.iter();
                let taken =
                    accepted.any(|(taken, at)| taken == number && self.is_told(*at, *index));
                assert!(taken, "{}", self.story());
            }
        }
    }

    /// True if a command with this `index` may be reported with index `told`. On an arm at rest the
    /// first one may be too low by the number of dropped commands.
    fn is_told(&self, index: u64, told: u64) -> bool {
        (told..=told + self.scope.fresh.unwrap_or(0)).contains(&index)
    }

    /// All possible next states; empty when the run is over.
    fn successors(mut self) -> Vec<Self> {
        // Several frames of one instant are decided one by one, which gives all combinations.
        if let Some((way, frame)) = self.undecided.pop_front() {
            return self.decide(way, &frame);
        }
        if !self.calm && !self.finishing && self.mishaps < self.scope.mishaps {
            self.calm = true;
            // At most one reset, Clear or cut per tick.
            let mut all = Vec::new();
            if self.scope.resets {
                let mut other = self.clone();
                other.mishaps += 1;
                other.toy.reset(self.tick);
                all.push(other);
            }
            if self.scope.clears && !self.tickets.is_empty() {
                let mut other = self.clone();
                other.mishaps += 1;
                let clear = Request::set(&QueuedCmdClear {}).unwrap();
                let clear = clear.priority(Priority::Stop);
                other.host.submit(clear.deadline(self.now() + 100 * TICK));
                other.cleared = true;
                other.listen();
                all.push(other);
            }
            if self.scope.cuts && self.back.is_none() {
                for answers_survive in [false, true] {
                    let mut other = self.clone();
                    other.cut(answers_survive);
                    all.push(other);
                }
            }
            all.push(self);
            return all;
        }
        let silent = self.lines.iter().all(VecDeque::is_empty);
        if self.tickets.is_empty() && self.host.is_idle() && silent && self.back.is_none() {
            if self.finishing {
                self.judge();
                return Vec::new();
            }
            // Final reads confirm the last indices.
            self.finishing = true;
            self.look();
            self.listen();
            return vec![self];
        }
        // Every run ends, so a livelock is a fault.
        assert!(self.tick < END, "no end: {}", self.story());
        self.pass();
        self.listen();
        vec![self]
    }

    /// Pulls the cable. Replies already sent may wait in an adapter until it is back.
    fn cut(&mut self, answers_survive: bool) {
        self.mishaps += 1;
        let [to_arm, to_host] = &mut self.lines;
        to_arm.clear();
        if answers_survive {
            (to_host.iter_mut()).for_each(|(at, _)| *at = self.tick + AWAY + 1);
        } else {
            to_host.clear();
        }
        self.host.interrupt();
        self.back = Some(self.tick + AWAY);
        self.listen();
    }

    fn decide(mut self, way: Direction, frame: &FrameBuf) -> Vec<Self> {
        let mut all = Vec::new();
        if self.mishaps < self.scope.mishaps && !self.finishing {
            let mut lost = self.clone();
            lost.mishaps += 1;
            all.push(lost);
            for late in 1..=2 {
                let mut other = self.clone();
                other.mishaps += 1;
                other.put(way, *frame, late);
                all.push(other);
            }
            if self.scope.doubles {
                for late in [0, 2] {
                    let mut other = self.clone();
                    other.mishaps += 1;
                    // Only a duplicated queued command can be executed twice.
                    other.doubled |= way == Direction::ToArm && frame.frame().ctrl().queued();
                    other.put(way, *frame, 0);
                    other.put(way, *frame, late);
                    all.push(other);
                }
            }
        }
        self.put(way, *frame, 0);
        all.push(self);
        all
    }

    /// Asserts the property at the end of a run.
    fn judge(&self) {
        let accepted = &self.toy.accepted;
        let mut numbers: Vec<u32> = accepted.iter().map(|(number, _)| *number).collect();
        // Sorted numbers have their repeats side by side, where `dedup` finds them.
        let in_order = numbers.is_sorted();
        numbers.dedup();
        let once = numbers.len() == accepted.len();
        let from = |fate: &Result<u64, Failure>| match fate {
            Err(Failure::Uncertain { from, .. }) => Some(from.unwrap_or(0)),
            _ => None,
        };
        let gap = self.fates.values().filter_map(from).min();
        // A reset clears the whole queue, duplicates included.
        let reported = self.reported || gap.is_some() || self.resets > 0;
        // A second copy of the last command that a Clear dropped shows only when the next command
        // is taken.
        let last = |number: &u32| accepted.iter().filter(|(taken, _)| taken == number).count() > 1;
        let cleared = self.cleared && accepted.last().is_some_and(|(number, _)| last(number));
        // On an arm at rest, a finished second copy of the first command looks like an index that
        // an earlier Clear dropped.
        let first =
            self.scope.fresh.is_some() && accepted.first().is_some_and(|(number, _)| last(number));
        let excused = self.doubled && (reported || cleared || first);
        assert!(once && in_order || excused, "{}", self.story());
        assert!(
            !self.reported || self.doubled || gap.is_some(),
            "without need: {}",
            self.story()
        );
        for (number, fate) in &self.fates {
            let taken = accepted.iter().filter(|(taken, _)| taken == number);
            let right = match fate {
                Ok(index) => {
                    let confirmed = self.confirmed.contains(number)
                        || self.resets > 0
                        || self.scope.settings.window == 1;
                    let doubtful = gap.is_some_and(|from| from <= *index);
                    let mut taken = taken.map(|(_, taken)| self.is_told(*taken, *index));
                    confirmed && taken.next() == Some(true) && taken.next().is_none() || doubtful
                }
                // An unknown fate allows both outcomes, but not two executions.
                Err(Failure::Uncertain { .. }) => taken.count() <= 1,
                Err(_) => taken.count() == 0,
            };
            assert!(right || excused, "{number}: {}", self.story());
        }
    }

    fn story(&self) -> String {
        let mut fates: Vec<_> = self.fates.iter().collect();
        fates.sort_by_key(|(number, _)| **number);
        format!(
            "at tick {} with {} mishaps, cleared {}: accepted {:?}, told {fates:?}, confirmed {:?}",
            self.tick, self.mishaps, self.cleared, self.toy.accepted, self.confirmed
        )
    }
}

/// Explores all states. Returns the number of states and of complete runs.
fn explore(scope: Scope) -> (u64, u64) {
    let (mut states, mut runs) = (0, 0);
    let mut open = vec![World::new(scope)];
    // Submitted requests are sent.
    open[0].listen();
    while let Some(world) = open.pop() {
        states += 1;
        let next = world.successors();
        runs += u64::from(next.is_empty());
        open.extend(next);
    }
    (states, runs)
}

/// Link with timeouts shorter than its longest delays, so that a reply may arrive after its
/// timeout.
const TIGHT: Settings = Settings {
    initial_timeout: 3 * TICK,
    floor: 3 * TICK,
    ceiling: 3 * TICK,
    ..Settings::ORDERED
};

const SERIAL: Scope = Scope {
    settings: TIGHT,
    commands: 3,
    places: 4,
    takes: 3,
    mishaps: 3,
    doubles: false,
    resets: true,
    clears: true,
    cuts: false,
    fresh: None,
    reads: false,
    reads_first: false,
};

const PAIRS: Scope = Scope {
    settings: Settings {
        reads_beside: true,
        ..TIGHT
    },
    reads: true,
    mishaps: 2,
    ..SERIAL
};

const WINDOW: Scope = Scope {
    settings: Settings { window: 4, ..TIGHT },
    commands: 5,
    ..SERIAL
};

const DATAGRAMS: Scope = Scope {
    settings: Settings {
        ordered: false,
        // Eight times the shortest round trip equals the longest one.
        lifetime: 8 * TICK,
        shortest: TICK,
        echo: 4 * TICK,
        ..TIGHT
    },
    takes: 40,
    doubles: true,
    ..SERIAL
};

fn report(name: &str, scope: Scope) {
    let (states, runs) = explore(scope);
    let Scope {
        commands,
        places,
        takes,
        mishaps,
        ..
    } = scope;
    println!(
        "{name}, {commands} commands of {takes} ticks, {places} places, {mishaps} mishaps: {states} states, {runs} runs"
    );
    // A scope that explores almost nothing would pass every check.
    assert!(runs > 100);
}

#[test]
pub(super) fn over_a_serial_line_each_command_is_taken_once_or_reported() {
    report("serial", SERIAL);
    for (takes, places) in [(1, 1), (3, 2), (5, 3), (200, 4)] {
        let scope = Scope {
            takes,
            places,
            commands: 6,
            mishaps: 2,
            ..SERIAL
        };
        report("serial", scope);
    }
}

#[test]
pub(super) fn in_a_window_each_command_is_taken_once_or_reported() {
    report("window 4", WINDOW);
    for (takes, places) in [(1, 1), (3, 2), (5, 3), (200, 4)] {
        let scope = Scope {
            takes,
            places,
            mishaps: 2,
            commands: 6,
            ..WINDOW
        };
        report("window 4", scope);
    }
}

#[test]
pub(super) fn with_reads_beside_each_command_is_taken_once_or_reported() {
    for reads_first in [false, true] {
        for (takes, places, commands, mishaps) in
            [(3, 4, 2, 3), (1, 1, 4, 2), (3, 2, 4, 2), (200, 4, 4, 2)]
        {
            let scope = Scope {
                takes,
                places,
                commands,
                mishaps,
                reads_first,
                ..PAIRS
            };
            report("reads beside", scope);
        }
    }
}

#[test]
pub(super) fn reads_answered_before_their_commands_leave_no_command_uncertain() {
    let mut world = World::new(Scope {
        reads_first: true,
        commands: 6,
        mishaps: 0,
        ..PAIRS
    });
    world.listen();
    while let Some(next) = world.clone().successors().pop() {
        world = next;
    }
    assert!(
        world.fates.values().all(Result::is_ok) && !world.reported,
        "{}",
        world.story()
    );
}

#[test]
pub(super) fn over_datagrams_each_command_is_taken_once_or_reported() {
    // Three faults of the line, or two of all kinds.
    let scope = Scope {
        commands: 2,
        resets: false,
        clears: false,
        ..DATAGRAMS
    };
    report("datagrams", scope);
    for (takes, places) in [(1, 1), (3, 2), (5, 3)] {
        let scope = Scope {
            takes,
            places,
            commands: 4,
            mishaps: 2,
            ..DATAGRAMS
        };
        report("datagrams", scope);
    }
}

#[test]
pub(super) fn when_the_cable_is_pulled_each_command_is_taken_once_or_reported() {
    for scope in [SERIAL, PAIRS, WINDOW, DATAGRAMS] {
        let scope = Scope {
            cuts: true,
            doubles: false,
            clears: false,
            mishaps: 2,
            ..scope
        };
        report("cable", scope);
    }
}

#[test]
pub(super) fn the_first_command_of_an_arm_at_rest_is_taken_once_or_reported() {
    for fresh in [0, 2] {
        for (takes, places) in [(1, 1), (3, 4), (40, 2)] {
            let serial = Scope {
                takes,
                places,
                commands: 2,
                mishaps: 2,
                fresh: Some(fresh),
                ..SERIAL
            };
            report("serial, at rest", serial);
            // No resets: after an early one the first indices would equal those before it.
            let datagrams = Scope {
                settings: DATAGRAMS.settings,
                doubles: true,
                resets: false,
                ..serial
            };
            report("datagrams, at rest", datagrams);
        }
    }
}

/// A check that cannot fail proves nothing: without a safeguard the same exploration must find a
/// fault.
#[test]
fn the_exploration_finds_what_is_planted() {
    let serial = over_a_serial_line_each_command_is_taken_once_or_reported;
    let window = in_a_window_each_command_is_taken_once_or_reported;
    let datagrams = over_datagrams_each_command_is_taken_once_or_reported;
    let beside = with_reads_beside_each_command_is_taken_once_or_reported;
    let reads_first = reads_answered_before_their_commands_leave_no_command_uncertain;
    let is_planted: [(PlantedBug, fn()); 8] = [
        (PlantedBug::ResendBlindly, serial),
        (PlantedBug::ResendBlindly, beside),
        (PlantedBug::OneOrderOnly, reads_first),
        (PlantedBug::ResendBlindly, datagrams),
        (PlantedBug::NoDuplicateCheck, datagrams),
        (PlantedBug::AcceptGaps, window),
        (PlantedBug::ConfirmAtOnce, window),
        (PlantedBug::JudgeInWindow, window),
    ];
    let silent: Vec<_> = (is_planted.iter())
        .filter(|(flaw, check)| !is_noticed(*flaw, *check))
        .map(|(flaw, _)| flaw)
        .collect();
    assert!(silent.is_empty(), "{silent:?} would go unnoticed");
}
