//! Rehearsal of plans on an in-process virtual arm: their exact result, to the microsecond and the
//! byte.
//!
//! Every command is sent as a frame, and the queue is kept as full as possible. The arm's clock
//! jumps from event to event, so an hour of motion costs only its commands. No other clock and no
//! randomness are involved: the same plan gives the same rehearsal, bit for bit.

mod stage;

use std::time::Duration;

use magician_host::{AlarmSet, Error, JointAngles, Set};
use magician_motion::Pose;
use magician_protocol::Ctrl;
use magician_protocol::commands::QueuedCmdStartExec;
use magician_sim::world::Drawing;
use magician_sim::{ArmInstant, Controller, Event, LinkId};

use crate::Plan;
use stage::send;
pub(crate) use stage::tool_kind;
pub use stage::{RehearseOptions, stage, start_of, start_of_stage, tool_of};

/// The host's link.
const HOST_LINK: LinkId = LinkId(0);
/// Largest number of recorded tool positions. Bounds memory for long plans.
const MAX_SAMPLES: usize = 1_000_000;
/// Largest number of logged events.
const MAX_EVENTS: usize = 1000;

/// Result of a plan on a virtual arm.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Rehearsal {
    /// Marks of pen or laser.
    pub drawing: Drawing,
    /// Duration by the arm's clock.
    pub time: Duration,
    /// Number of finished steps; fewer than planned if an alarm or an endless wait held the arm.
    pub steps: usize,
    /// Final pose.
    pub pose: Pose,
    /// Final joint angles.
    pub joints: JointAngles,
    /// Alarms at the end.
    pub alarms: AlarmSet,
    /// Events with their times, except for normal commands: alarms, touches, refusals; the first
    /// 1000.
    pub log: Vec<(Duration, Event)>,
    /// Recorded tool positions (x, y, z) if watched; at most a million.
    pub way: Vec<[f64; 3]>,
    planned: usize,
}

impl Rehearsal {
    /// True if all steps finished without an alarm.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.steps == self.planned && self.alarms.is_empty()
    }
}

/// Runs a plan on a virtual arm at full speed.
///
/// ```
/// use magician_program::rehearse::{RehearseOptions, rehearse};
/// use magician_program::{Action, Origin, Plan, Surface, Tool, Travel};
///
/// let mut plan = Plan::new("a line");
/// plan.tool = Some(Tool::Pen);
/// plan.surface = Some(Surface::level(-60.0));
/// plan.push(Action::Move { to: [200.0, 0.0, -60.0, 0.0], by: Travel::Joints }, Origin::NONE);
/// plan.push(Action::Path { to: [240.0, 0.0, -60.0] }, Origin::NONE);
///
/// let done = rehearse(&plan, &RehearseOptions::default())?;
/// assert!(done.is_good());
/// let [from, to] = done.drawing.bounds().unwrap();
/// assert!((to[0] - from[0] - 40.0).abs() < 1e-6);
/// # Ok::<(), magician_host::Error>(())
/// ```
///
/// # Errors
/// Same as [`stage`], and for a command that fits no frame. A refusal by the arm is not an error
/// but an alarm in the [`Rehearsal`].
pub fn rehearse(plan: &Plan, options: &RehearseOptions) -> Result<Rehearsal, Error> {
    let mut run = Run::on(stage(plan, options)?, options.watch);
    let mut commands = plan.commands();
    run.fill(&mut commands)?;
    // The queue is filled before it starts, as a driver does, so that the first path sees what
    // follows.
    let start = Set::QueuedCmdStartExec(QueuedCmdStartExec {});
    send(&mut run.arm, &start, Ctrl::SET)?;
    while run.next() {
        run.fill(&mut commands)?;
    }
    Ok(run.finish(plan))
}

/// Rehearsal in progress.
struct Run {
    arm: Controller,
    began: ArmInstant,
    /// Number of commands handed over.
    sent: usize,
    log: Vec<(Duration, Event)>,
    /// Interval between recorded positions.
    watch: Option<Duration>,
    way: Vec<[f64; 3]>,
}

impl Run {
    fn on(arm: Controller, watch: Option<Duration>) -> Self {
        let mut run = Self {
            began: arm.now(),
            arm,
            sent: 0,
            log: Vec::new(),
            watch: watch.map(|each| each.max(Duration::from_micros(1))),
            way: Vec::new(),
        };
        run.record_position();
        while run.arm.poll_event().is_some() {}
        run
    }

    fn now(&self) -> Duration {
        self.arm.now() - self.began
    }

    /// Number of commands in the queue, including the current one.
    fn unfinished(&self) -> usize {
        let queue = self.arm.state().queue;
        queue.waiting + usize::from(queue.running.is_some())
    }

    /// Queues commands while there is room.
    fn fill(&mut self, commands: &mut impl Iterator<Item = Set>) -> Result<(), Error> {
        let capacity = self.arm.state().queue.capacity;
        let room = capacity.saturating_sub(self.unfinished());
        for command in commands.take(room) {
            send(&mut self.arm, &command, Ctrl::QUEUED)?;
            self.sent += 1;
        }
        Ok(())
    }

    /// Advances to the next event; false if the arm is done or held.
    fn next(&mut self) -> bool {
        let queue = self.arm.state().queue;
        let idle = queue.running.is_none() && (queue.waiting == 0 || queue.held);
        if idle && !self.arm.state().moving {
            return false;
        }
        let Some(at) = self.arm.poll_timeout() else {
            return false;
        };
        self.watch_until(at);
        self.arm.advance(at);
        self.record_position();
        self.log_events();
        true
    }

    fn watch_until(&mut self, end: ArmInstant) {
        while let Some(next) = (self.watch).map(|each| self.arm.now() + each)
            && next < end
            && self.arm.state().moving
            && self.way.len() < MAX_SAMPLES
        {
            self.arm.advance(next);
            self.record_position();
        }
    }

    fn record_position(&mut self) {
        if self.watch.is_some() && self.way.len() < MAX_SAMPLES {
            let Pose { x, y, z, .. } = self.arm.state().pose;
            self.way.push([x, y, z]);
        }
    }

    fn log_events(&mut self) {
        let now = self.now();
        while let Some(event) = self.arm.poll_event() {
            if !event.is_routine() && self.log.len() < MAX_EVENTS {
                self.log.push((now, event));
            }
        }
    }

    fn finish(mut self, plan: &Plan) -> Rehearsal {
        self.log_events();
        let state = self.arm.state();
        let done = self.sent.saturating_sub(self.unfinished());
        // The command that sets the tool is not a step.
        let sent_first = plan.preamble().into_iter().count();
        Rehearsal {
            drawing: self.arm.drawing(),
            time: self.now(),
            steps: done.saturating_sub(sent_first),
            pose: state.pose,
            joints: state.joints,
            alarms: state.alarms,
            log: self.log,
            way: self.way,
            planned: plan.steps.len(),
        }
    }
}
