//! Smallest possible model of an arm, its motors, and the programs that move it, around the gate.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use magician_host::build::{Axis, JogDirection};
use magician_host::connection::Micros;
use magician_host::gate::{GateEffect, Holder, JogEnd, JogId, JogKind, JogRequest, OUTPUTS};
use magician_protocol::commands::{EMotor, EMotorS, JogCmd};
use magician_protocol::{Ctrl, Flag, FrameBuf, Stepper, Writable};

use crate::mutant::{Bug, Mutant};
use crate::search::Explored;

/// Number of jogs with a guard at a time.
const GUARDS: usize = 2;
/// Hold time of a jog, moments.
pub(crate) const KEEP: Micros = 2;
/// Holder of jogs in pieces.
const IN_PIECES: Holder = Holder(2);
/// A jog that is over, whose guard still exists.
const STALE: JogId = JogId(99);
const DIRECTIONS: [JogDirection; 3] = [Axis::X.plus(), Axis::X.minus(), Axis::Y.plus()];

/// Event of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    /// A jog is requested. False if its command cannot be sent when its turn comes.
    Ask(Holder, JogDirection, bool),
    Keep(JogId),
    /// Kept up at its deadline, before the driver has noticed the deadline.
    KeepLate(JogId),
    /// The current jog is bounded, this many moments from now.
    Bound(JogId, Micros, JogEnd),
    /// The guard of an ended jog keeps it up, or a bound is found for such a jog.
    KeepStale,
    BoundStale,
    Release(JogId),
    /// A frame of a jog that belongs to no guard.
    Raw(JogDirection),
    /// The same from a program whose frames are passed on.
    Pass(JogDirection),
    Motor(Stepper, Turn),
    Stop,
    /// The driver reads two equal poses after a stop, or gives up.
    Rested(bool),
    /// A caller reads two equal poses.
    Stands,
    /// Time passes.
    Moment,
    LoseLine,
    FindLine,
    /// The connection ends.
    Close,
}

impl Event {
    /// True if it may end a jog whose deadline has passed.
    fn is_of_time(self) -> bool {
        let bounds = matches!(self, Self::Bound(..) | Self::BoundStale);
        bounds || matches!(self, Self::Moment | Self::KeepLate(_) | Self::KeepStale)
    }
}

/// Command to a motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    On,
    Off,
    Counted,
    QueuedOn,
    QueuedOff,
    /// Another program starts it.
    Foreign,
}

/// State of the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Arm {
    Stands,
    /// Jog of a guard. `None` for one of another program.
    Jogs(Option<JogId>, Holder, JogDirection),
    /// A jog that bypassed the gate.
    Unknown,
    Brakes,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Guard {
    holder: Holder,
    direction: JogDirection,
    /// True if its command can be sent.
    goes: bool,
    kind: JogKind,
    /// Moments until its hold time ends.
    left: Micros,
    /// Moments until its earliest bound.
    bound: Option<(Micros, JogEnd)>,
    released: bool,
    /// True if a stop came after it was requested.
    stopped: bool,
    begun: bool,
}

impl Guard {
    /// Reason if its time is over.
    fn due(&self) -> Option<JogEnd> {
        let bound = self.bound.filter(|(left, _)| *left == 0);
        if self.left == 0 {
            Some(JogEnd::NotKept)
        } else {
            bound.map(|(_, why)| why)
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
struct Motor {
    runs: bool,
    /// True if this connection started it.
    own: bool,
    /// True if the queue holds a command that starts or stops it.
    waits: Option<bool>,
}

/// A state of the search.
#[derive(Clone)]
pub(crate) struct Model {
    gate: Mutant,
    now: Micros,
    /// True if the line was lost during a jog in pieces.
    lost_pieces: bool,
    arm: Arm,
    motors: [Motor; 2],
    guards: BTreeMap<JogId, Guard>,
    line: bool,
    open: bool,
    /// True if the stop of a jog is to be sent, or was sent and the arm was not seen at rest yet.
    ending: bool,
}

type Checked = Result<(), String>;

fn must(good: bool, what: &str) -> Checked {
    if good { Ok(()) } else { Err(what.to_owned()) }
}

fn jog_frame(direction: JogDirection) -> FrameBuf {
    FrameBuf::encode(JogCmd::ROW.id, Ctrl::SET, &JogCmd::from(direction)).expect("a frame")
}

fn motor_frame(index: Stepper, turn: Turn) -> FrameBuf {
    let on = matches!(turn, Turn::On | Turn::QueuedOn | Turn::Counted);
    let (is_enabled, speed) = (Flag::from(on), i32::from(on) * 1000);
    let ctrl = match turn {
        Turn::QueuedOn | Turn::QueuedOff => Ctrl::QUEUED,
        _ => Ctrl::SET,
    };
    let frame = match turn {
        Turn::Counted => FrameBuf::encode(
            EMotorS::ROW.id,
            ctrl,
            &EMotorS {
                index,
                is_enabled,
                speed,
                distance: 1000,
            },
        ),
        _ => FrameBuf::encode(
            EMotor::ROW.id,
            ctrl,
            &EMotor {
                index,
                is_enabled,
                speed,
            },
        ),
    };
    frame.expect("a frame")
}

impl Model {
    pub(crate) fn new(bug: Option<Bug>) -> Self {
        Self {
            gate: Mutant::new(bug),
            now: 0,
            lost_pieces: false,
            arm: Arm::Stands,
            motors: Default::default(),
            guards: BTreeMap::new(),
            line: true,
            open: true,
            ending: false,
        }
    }

    fn happen(&mut self, event: Event) -> Checked {
        match event {
            Event::Ask(holder, direction, goes) => {
                let free = (0..).map(JogId).find(|id| !self.guards.contains_key(id));
                let id = free.ok_or("a number")?;
                let kind = match holder {
                    IN_PIECES => JogKind::Pieces,
                    _ => JogKind::Own,
                };
                let guard = Guard {
                    holder,
                    direction,
                    goes,
                    kind,
                    left: KEEP,
                    bound: None,
                    released: false,
                    stopped: false,
                    begun: false,
                };
                self.guards.insert(id, guard);
                self.gate.ask(JogRequest {
                    id,
                    holder,
                    direction,
                    keep: KEEP,
                    kind,
                });
            }
            Event::Keep(id) => {
                self.guards.get_mut(&id).ok_or("a guard")?.left = KEEP;
                let kept = self.gate.keep(id, self.now);
                must(kept, "a jog that is in time is kept up")?;
            }
            Event::KeepLate(id) => {
                let guard = self.guards[&id];
                let bound = guard.bound.map_or(guard.left, |(left, _)| left);
                for _ in 0..bound.min(guard.left) {
                    self.time_passes();
                }
                self.gate.keep(id, self.now);
                self.gate.handle_timeout(self.now);
            }
            Event::Bound(id, left, why) => {
                let guard = self.guards.get_mut(&id).ok_or("a guard")?;
                if guard.bound.is_none_or(|(bound, _)| left < bound) {
                    guard.bound = Some((left, why));
                }
                self.gate.bound(id, self.now + left, why);
                self.gate.handle_timeout(self.now);
            }
            Event::KeepStale => {
                self.gate.keep(STALE, self.now);
            }
            Event::BoundStale => {
                self.gate.bound(STALE, self.now, JogEnd::Fence);
                self.gate.handle_timeout(self.now);
            }
            Event::Release(id) => {
                self.guards.get_mut(&id).ok_or("a guard")?.released = true;
                self.gate.release(id);
            }
            Event::Raw(direction) => {
                if !self.gate.refuses(&jog_frame(direction).frame()) {
                    self.arm = Arm::Unknown;
                }
            }
            Event::Pass(direction) => {
                self.gate.gate.note_foreign_jog();
                self.ending = false;
                self.arm = Arm::Jogs(None, Holder(9), direction);
            }
            Event::Motor(output, turn) => self.turn(output, turn),
            Event::Stop => {
                for guard in self.guards.values_mut() {
                    guard.stopped = true;
                }
                let off = self.gate.stop();
                self.brake();
                self.switch_off(&off);
                for motor in &mut self.motors {
                    motor.waits = None;
                }
            }
            Event::Rested(seen) => {
                if seen {
                    self.arm = Arm::Stands;
                }
                self.ending = false;
                self.gate.rested(seen);
            }
            Event::Stands => {
                self.arm = Arm::Stands;
                self.gate.gate.note_rest();
            }
            Event::Moment => {
                self.time_passes();
                self.gate.handle_timeout(self.now);
            }
            Event::LoseLine => {
                self.line = false;
                if matches!(self.arm, Arm::Jogs(Some(_), IN_PIECES, _)) {
                    // Pieces end by themselves.
                    self.arm = Arm::Brakes;
                }
                self.gate.gate.lose_line();
            }
            Event::FindLine => {
                self.line = true;
                if self.ending {
                    self.brake();
                }
            }
            Event::Close => {
                self.open = false;
                let moving = self.motors.iter().any(|motor| motor.waits.is_some());
                let off = self.gate.held_motors(moving);
                self.gate.gate.close();
                self.switch_off(&off);
                // The driver's last frames also stop other motion.
                self.arm = Arm::Stands;
            }
        }
        Ok(())
    }

    fn time_passes(&mut self) {
        self.now += 1;
        for guard in self.guards.values_mut().filter(|guard| guard.begun) {
            guard.left = guard.left.saturating_sub(1);
            if let Some((left, _)) = &mut guard.bound {
                *left = left.saturating_sub(1);
            }
        }
    }

    fn brake(&mut self) {
        if self.line && self.arm != Arm::Stands {
            self.arm = Arm::Brakes;
        }
    }

    fn turn(&mut self, output: Stepper, turn: Turn) {
        let at = OUTPUTS.iter().position(|one| *one == output).unwrap_or(0);
        let motor = &mut self.motors[at];
        match turn {
            Turn::On | Turn::Counted => (motor.runs, motor.own) = (true, true),
            Turn::Off => (motor.runs, motor.own) = (false, false),
            Turn::QueuedOn => motor.waits = Some(true),
            Turn::QueuedOff => motor.waits = Some(false),
            Turn::Foreign => (motor.runs, motor.own) = (true, false),
        }
        if turn == Turn::QueuedOn {
            // The queue runs: the command has begun before anything else happens.
            (motor.runs, motor.own, motor.waits) = (true, true, None);
        }
        if turn != Turn::Foreign {
            let frame = motor_frame(output, turn);
            self.gate.motors.sent(&frame.frame());
            self.gate.motors.answered(&frame.frame());
        }
    }

    fn switch_off(&mut self, outputs: &[Stepper]) {
        for output in outputs {
            self.turn(*output, Turn::Off);
        }
    }

    fn take_effects(&mut self, event: Event) -> Checked {
        loop {
            let effects = self.gate.effects();
            if effects.is_empty() {
                return Ok(());
            }
            for effect in effects {
                self.take(effect, event)?;
            }
        }
    }

    fn take(&mut self, effect: GateEffect, event: Event) -> Checked {
        match effect {
            GateEffect::Begin(id) => {
                let guard = *self.guards.get(&id).ok_or("a jog of a guard begins")?;
                must(!guard.released, "what is let go of does not begin")?;
                must(!guard.stopped, "what a stop ended does not begin")?;
                must(self.line, "nothing begins without a line")?;
                let fits = match self.arm {
                    Arm::Stands => true,
                    Arm::Jogs(Some(_), holder, direction) => {
                        holder == guard.holder && direction.axis == guard.direction.axis
                    }
                    _ => false,
                };
                must(fits, "a jog begins at rest, or reverses on its axis")?;
                if !guard.goes {
                    self.gate.not_begun(id);
                    return Ok(());
                }
                self.arm = Arm::Jogs(Some(id), guard.holder, guard.direction);
                if let Some(guard) = self.guards.get_mut(&id) {
                    guard.begun = true;
                }
                self.gate.gate.hold(id, self.now + KEEP);
            }
            GateEffect::End(jog, why) => {
                if event.is_of_time()
                    && let Some(guard) = jog.and_then(|jog| self.guards.get(&jog))
                {
                    let due = guard.due() == Some(why);
                    must(due, "a jog ends for the reason of its deadline")?;
                }
                let owed = event == Event::LoseLine && self.lost_pieces;
                must(!owed, "the end of pieces is not owed over the next line")?;
                self.ending = true;
                self.brake();
            }
            GateEffect::Over(id, _, seen) => {
                must(!seen || self.arm == Arm::Stands, "rest is seen")?;
                let guard = self.guards.remove(&id).ok_or("an end is told once")?;
                let lost = event == Event::LoseLine && guard.kind == JogKind::Pieces;
                (self.lost_pieces, self.ending) = (lost, self.ending && !lost);
            }
            GateEffect::Refused(id, _) => {
                let guard = self.guards.remove(&id).ok_or("an end is told once")?;
                must(!guard.begun, "what has begun is not refused")?;
            }
        }
        Ok(())
    }

    fn check(&self, event: Event) -> Checked {
        if self.line && self.open {
            let held = match self.arm {
                Arm::Stands | Arm::Brakes | Arm::Jogs(None, ..) => true,
                Arm::Jogs(Some(id), ..) => self
                    .guards
                    .get(&id)
                    .is_some_and(|guard| !guard.released && guard.due().is_none()),
                Arm::Unknown => false,
            };
            must(held, "what moves without an end has a holder")?;
        }
        if event == Event::Stop {
            let jogs = matches!(self.arm, Arm::Jogs(..) | Arm::Unknown) && self.line;
            let turns = self.motors.iter().any(|motor| motor.runs);
            must(!jogs && !turns, "after a stop nothing runs")?;
        }
        if !self.open {
            let turns = self.motors.iter().any(|motor| motor.runs && motor.own);
            must(!turns, "a motor ends with its holder")?;
        }
        let under_way = self.ending || matches!(self.arm, Arm::Jogs(Some(_), ..)) || !self.line;
        must(
            under_way || self.guards.is_empty(),
            "a guard is told the end of its jog",
        )
    }
}

impl Explored for Model {
    type Event = Event;

    fn events(&self) -> Vec<Event> {
        if !self.open {
            return Vec::new();
        }
        let mut out = vec![Event::Stop, Event::Close];
        if self.ending && self.line {
            out.extend([Event::Rested(true), Event::Rested(false)]);
        }
        if self.arm == Arm::Brakes && !self.ending {
            out.push(Event::Stands);
        }
        if !self.guards.is_empty() {
            out.push(Event::Moment);
        }
        for (id, guard) in &self.guards {
            let jogs = Arm::Jogs(Some(*id), guard.holder, guard.direction);
            if self.line && self.arm == jogs {
                if guard.left < KEEP {
                    out.extend([Event::Keep(*id), Event::KeepStale]);
                }
                out.extend([Event::KeepLate(*id), Event::BoundStale]);
                out.extend([1, 2].map(|left| Event::Bound(*id, left, JogEnd::Fence)));
                out.push(Event::Bound(*id, 0, JogEnd::Limit));
            }
            if !guard.released {
                out.push(Event::Release(*id));
            }
        }
        let turns = [
            Turn::On,
            Turn::Off,
            Turn::Counted,
            Turn::QueuedOn,
            Turn::QueuedOff,
            Turn::Foreign,
        ];
        // The outputs are equivalent, so only the first is tried.
        let first = self.motors[0] == Motor::default() && self.motors[1] == Motor::default();
        for output in OUTPUTS.into_iter().take(if first { 1 } else { 2 }) {
            out.extend(turns.map(|turn| Event::Motor(output, turn)));
        }
        if !self.line {
            out.push(Event::FindLine);
            return out;
        }
        out.push(Event::LoseLine);
        out.push(Event::Raw(Axis::X.plus()));
        out.extend([Axis::X.plus(), Axis::Y.plus()].map(Event::Pass));
        if self.guards.len() < GUARDS {
            for holder in [Holder(0), Holder(1)] {
                for direction in DIRECTIONS {
                    out.extend([true, false].map(|goes| Event::Ask(holder, direction, goes)));
                }
            }
            let pieces = DIRECTIONS.map(|direction| Event::Ask(IN_PIECES, direction, true));
            out.extend(pieces);
        }
        out
    }

    fn step(&mut self, _: &Self, event: Event) -> Checked {
        self.happen(event)?;
        self.take_effects(event)?;
        self.check(event)
    }

    fn key(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        let gate = self.gate.rebased(self.now);
        (&gate, self.arm, self.motors, &self.guards).hash(&mut hasher);
        (self.line, self.open, self.ending).hash(&mut hasher);
        hasher.finish()
    }
}
