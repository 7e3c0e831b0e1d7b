//! The controller behind its links: everything that a command can look at or change.

use magician_protocol::{
    Ctrl, DecodeError, EncodeError, Frame, FrameBuf, QueuedCmdIndex, Request, Row, Set,
};

use crate::alarms::Alarms;
use crate::chapter::{io::Connectors, teach::Teaching, tool::Actuators};
use crate::dispatch::{self, Step, Turn};
use crate::event::{Event, Log, Refusal};
use crate::flash::Flash;
use crate::motion::Motion;
use crate::program::{Download, Run};
use crate::queue::{Order, Queue, moves};
use crate::settings::Settings;
use crate::world::Grip;
use crate::{LineState, LinkId, Micros, Profile, World};

/// The controller behind its links.
#[derive(Clone)]
pub(crate) struct Core {
    pub(crate) now: Micros,
    pub(crate) profile: Profile,
    pub(crate) settings: Settings,
    pub(crate) queue: Queue,
    pub(crate) alarms: Alarms,
    pub(crate) motion: Motion,
    pub(crate) actuators: Actuators,
    pub(crate) connectors: Connectors,
    pub(crate) homed: bool,
    pub(crate) teaching: Teaching,
    pub(crate) flash: Flash,
    /// How often the flash has been written since power-up.
    pub(crate) flash_writes: u64,
    /// The program that is being stored.
    pub(crate) download: Option<Download>,
    pub(crate) run: Run,
    pub(crate) world: World,
    /// The tool as the world was told last.
    pub(crate) grip: Grip,
    pub(crate) line: LineState,
    /// When the controller was switched on or reset last.
    pub(crate) booted: Micros,
    /// The controller has reset and its links do not know yet.
    pub(crate) restarted: bool,
    pub(crate) log: Log,
}

impl Core {
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
            motion: Motion::at(profile.power_up.joints.into()),
            actuators: Actuators::default(),
            connectors: Connectors::default(),
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
            restarted: false,
            log: Log::default(),
            profile,
        };
        if core.profile.power_up.reset_alarm {
            core.raise(magician_protocol::Alarm::ResetOccurred);
        }
        core
    }

    /// Does what a frame asks and says what to reply.
    pub(crate) fn answer(&mut self, frame: &Frame<'_>) -> Result<FrameBuf, EncodeError> {
        let (id, ctrl) = (frame.id(), frame.ctrl());
        let nothing = || FrameBuf::new(id, ctrl, &[]);
        match Request::decode(frame) {
            Ok(Request::Get(get)) => dispatch::report(self, &get, id, ctrl),
            Ok(Request::Set(set)) => {
                self.act_at_once(&set);
                nothing()
            }
            Ok(Request::Queue(set)) => self.enqueue(id, ctrl, Order::Set(set)),
            Ok(Request::Nothing) => nothing(),
            Err(error) => {
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
        if self.teaching.held() && (moves(set) || matches!(set, Set::JogCmd(_))) {
            // The motors are released.
            let _: Step = self.refuse(set.row().id, Refusal::Busy);
            return;
        }
        // The step of an immediate command is of no concern: nothing waits for it.
        let _: Step = dispatch::apply(self, set, Turn::Immediate);
        self.feel_grip();
        self.settle();
    }

    fn enqueue(&mut self, id: u8, ctrl: Ctrl, order: Order) -> Result<FrameBuf, EncodeError> {
        let stored = self.store_line(id, &order);
        let Some(index) = stored.unwrap_or_else(|| self.hosts_mut().push(id, order)) else {
            self.log.push(Event::QueueFull { id });
            return FrameBuf::encode(id, ctrl.with_error(), &QueuedCmdIndex(0));
        };
        if stored.is_none() {
            self.log.push(Event::Accepted { index, id });
            if !self.runs_program() {
                self.path_grows();
            }
            self.settle();
        }
        FrameBuf::encode(id, ctrl, &QueuedCmdIndex(index))
    }

    pub(crate) fn unknown_id(&mut self, link: LinkId, id: u8) {
        self.log.push(Event::UnknownId { link, id });
        self.raise(magician_protocol::Alarm::UndefinedInstruction);
    }

    pub(crate) fn raise(&mut self, code: u8) {
        if self.alarms.raise(code) {
            self.log.push(Event::AlarmRaised { code });
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
    let queues = Row::with_id(id).is_some_and(|row| row.set.is_some() && !row.steers_queue());
    ctrl.queued() && queues && !matches!(error, DecodeError::UnknownId(_))
}
