//! The controller behind its links: everything that a command can look at or change.

mod alarms;
pub(crate) mod dispatch;
pub(crate) mod external;
pub(crate) mod handlers;
pub(crate) mod io;
pub(crate) mod motion;
pub(crate) mod queue;
mod schedule;
pub(crate) mod store;

use magician_motion::ArmModel;
use magician_protocol::{
    Alarm, Ctrl, DecodeError, EncodeError, Frame, FrameBuf, QueuedCmdIndex, Request, Row, Set,
};

use crate::device::alarms::Alarms;
use crate::device::dispatch::{Step, Turn};
use crate::device::handlers::{io::Detectors, teach::Teaching};
use crate::device::io::pins::Connectors;
use crate::device::io::steppers::Steppers;
use crate::device::io::tools::Actuators;
use crate::device::motion::Motion;
use crate::device::queue::program::{Download, Run};
use crate::device::queue::{Order, Queue, moves};
use crate::device::store::flash::Flash;
use crate::device::store::settings::Settings;
use crate::event::{Event, Log, Refusal};
use crate::fidelity::{Assumption, Fidelity};
use crate::world::Grip;
use crate::{LineState, LinkId, Micros, Profile, World};

/// The controller behind its links.
#[derive(Clone)]
pub(crate) struct Device {
    pub(crate) now: Micros,
    pub(crate) profile: Profile,
    /// The profile as motions are planned with it.
    pub(crate) model: ArmModel,
    pub(crate) settings: Settings,
    pub(crate) queue: Queue,
    pub(crate) alarms: Alarms,
    pub(crate) motion: Motion,
    pub(crate) actuators: Actuators,
    pub(crate) connectors: Connectors,
    pub(crate) steppers: Steppers,
    pub(crate) color_sensors: Detectors,
    pub(crate) infrared_sensors: Detectors,
    pub(crate) homed: bool,
    pub(crate) teaching: Teaching,
    pub(crate) flash: Flash,
    /// How often the flash has been written since power-up.
    pub(crate) flash_writes: u64,
    /// The program that is being stored.
    pub(crate) download: Option<Download>,
    pub(crate) run: Run,
    pub(crate) world: World,
    /// Tool state last reported to the world.
    pub(crate) grip: Grip,
    pub(crate) line: LineState,
    /// When the controller was switched on or reset last.
    pub(crate) booted: Micros,
    /// Since when the Wi-Fi module has been looking for its network, if not since then.
    pub(crate) wifi_begun: Micros,
    /// The controller has reset and its links do not know yet.
    pub(crate) restarted: bool,
    pub(crate) log: Log,
    pub(crate) fidelity: Fidelity,
}

impl Device {
    pub(crate) fn new(profile: Profile, world: World, flash: Flash) -> Self {
        let rules = &profile.queue;
        let mut core = Self {
            now: 0,
            settings: Settings::new(&profile),
            queue: Queue::new(
                rules.depth,
                rules.first_index,
                profile.power_up.queue_started,
            ),
            alarms: Alarms::default(),
            motion: Motion::at(profile.power_up.joints.into(), profile.rail.length),
            actuators: Actuators::default(),
            connectors: Connectors::default(),
            steppers: Steppers::default(),
            color_sensors: Detectors::default(),
            infrared_sensors: Detectors::default(),
            homed: false,
            teaching: Teaching::default(),
            flash,
            flash_writes: 0,
            download: None,
            run: Run::Off,
            world,
            grip: Grip::default(),
            line: LineState::default(),
            booted: 0,
            wifi_begun: 0,
            restarted: false,
            log: Log::default(),
            fidelity: Fidelity::default(),
            model: profile.arm_model(),
            profile,
        };
        if core.profile.power_up.reset_alarm {
            core.raise(Alarm::ResetOccurred);
            core.assume(Assumption::ResetAlarm);
        }
        core
    }

    /// Does what a frame asks and says what to reply.
    pub(crate) fn answer(&mut self, frame: &Frame<'_>) -> Result<FrameBuf, EncodeError> {
        let (id, ctrl) = (frame.id(), frame.ctrl());
        let nothing = || FrameBuf::new(id, ctrl, &[]);
        let request = Request::decode(frame);
        let taken = (request.as_ref()).is_ok_and(|request| self.allows_frame(id, ctrl, request));
        match request {
            Ok(Request::Get(get)) if taken && self.allows_report(id, &get) => {
                dispatch::report(self, &get, id, ctrl)
            }
            Ok(Request::Set(set)) if taken => {
                self.act_at_once(&set);
                nothing()
            }
            Ok(Request::Queue(set)) if taken => self.enqueue(id, ctrl, Order::Set(set)),
            Ok(Request::Queue(_)) => self.enqueue(id, ctrl, Order::Nothing),
            Ok(Request::Get(_) | Request::Set(_) | Request::Nothing) => nothing(),
            Err(error) => {
                self.assume(Assumption::WrongCount);
                let reason = Refusal::Parameters;
                self.log.push(Event::Refused { id, reason });
                if is_queued(ctrl, id, error) {
                    self.enqueue(id, ctrl, Order::Nothing)
                } else {
                    nothing()
                }
            }
        }
    }

    fn act_at_once(&mut self, set: &Set) {
        if !self.allows_apply(set, Turn::Immediate) {
            return;
        }
        if self.teaching.held() && (moves(set) || matches!(set, Set::JogCmd(_))) {
            // The motors are released.
            let _: Step = self.refuse(set.row().id, Refusal::Busy);
            return;
        }
        // The step of an immediate command is of no concern: nothing waits for it.
        let _: Step = self.carry_out(set, Turn::Immediate);
        self.feel_grip();
        self.settle();
    }

    pub(crate) fn carry_out(&mut self, set: &Set, turn: Turn) -> Step {
        self.settings.told.add(set.row().id);
        dispatch::apply(self, set, turn)
    }

    fn enqueue(&mut self, id: u8, ctrl: Ctrl, order: Order) -> Result<FrameBuf, EncodeError> {
        self.count_index_assumptions();
        let stored = self.store_line(id, &order);
        let Some(index) = stored.unwrap_or_else(|| self.hosts_mut().push(id, order)) else {
            self.log.push(Event::QueueFull { id });
            return FrameBuf::encode(id, ctrl.with_error(), &QueuedCmdIndex(0));
        };
        if stored.is_some() {
            self.assume(Assumption::StoredLineIndex);
        } else {
            self.log.push(Event::Accepted { index, id });
            if !self.runs_program() {
                self.path_grows();
            }
            self.settle();
        }
        FrameBuf::encode(id, ctrl, &QueuedCmdIndex(index))
    }

    /// Whether a frame is answered although it finds the queue full, if it does.
    pub(crate) fn may_overflow(&mut self, frame: &Frame<'_>) -> bool {
        let id = frame.id();
        !(frame.ctrl().queued() && queues(id) && self.is_full())
            || self.allows(id, Assumption::FullQueue)
    }

    pub(crate) fn damaged_frame(&mut self, link: LinkId) {
        self.log.push(Event::BadFrame { link });
        self.assume(Assumption::DamagedFrame);
    }

    pub(crate) fn unknown_id(&mut self, link: LinkId, id: u8) {
        self.log.push(Event::UnknownId { link, id });
        if !self.allows(id, Assumption::UnknownId) {
            return;
        }
        self.raise(Alarm::UndefinedInstruction);
    }

    pub(crate) fn raise(&mut self, code: u8) {
        let held = self.alarms.held();
        if self.alarms.raise(code) {
            self.log.push(Event::AlarmRaised { code });
            if Alarm::is_kinematic(code) && self.settings.bias.is_zero() {
                self.log.push(Event::ToolUnknown { code });
            }
        }
        if !Alarm::blocks(code) {
            self.assume(Assumption::QuietAlarms);
        } else if !held {
            self.assume(Assumption::AlarmHold);
        }
        self.replan_segment();
    }

    pub(crate) fn refuse(&mut self, id: u8, reason: Refusal) -> Step {
        self.log.push(Event::Refused { id, reason });
        Step::Done
    }

    pub(crate) fn not_simulated(&mut self, row: &'static Row) -> Step {
        self.log.not_simulated(row);
        Step::Done
    }
}

/// Whether a frame that could not be read would have been queued.
fn is_queued(ctrl: Ctrl, id: u8, error: DecodeError) -> bool {
    ctrl.queued() && queues(id) && !matches!(error, DecodeError::UnknownId(_))
}

/// Whether a command may wait in the queue.
fn queues(id: u8) -> bool {
    Row::with_id(id).is_some_and(|row| row.set.is_some() && !row.steers_queue())
}
