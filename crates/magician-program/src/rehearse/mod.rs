//! Plans on a virtual arm in this process: what would really come of them, to the microsecond and the byte.
//!
//! Every command is sent as the frame that it is, and the queue is kept as full as it can be; the arm's clock jumps from
//! event to event, so an hour of motion takes as long as its commands cost. There is no other clock and no chance in it:
//! the same plan gives the same rehearsal, bit for bit.

mod stage;

use std::time::Duration;

use magician_host::{AlarmSet, Error, JointAngles, Set};
use magician_motion::Pose;
use magician_protocol::Ctrl;
use magician_protocol::commands::QueuedCmdStartExec;
use magician_sim::world::Drawing;
use magician_sim::{ArmInstant, Controller, Event, LinkId};

use crate::Plan;
pub(crate) use stage::kind_of;
use stage::tell;
pub use stage::{RehearseOptions, stage, stands, start_of, tool_of};

/// The host's link.
const HOST: LinkId = LinkId(0);
/// As many looks at the tool are kept.
const MOST_LOOKS: usize = 1_000_000;
/// As many events are kept.
const MOST_EVENTS: usize = 1000;

/// What came of a plan on a virtual arm.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Rehearsal {
    /// What pen or laser have left.
    pub drawing: Drawing,
    /// How long it took, on the arm's clock.
    pub time: Duration,
    /// How many steps have ended; fewer than the plan has if an alarm or a wait without an end held the arm.
    pub steps: usize,
    /// Where the arm stands at the end.
    pub pose: Pose,
    /// The same as joint angles.
    pub joints: JointAngles,
    /// The alarms that stand at the end.
    pub alarms: AlarmSet,
    /// What happened in it and when, but for commands that came and went: alarms, touches, refusals; the first 1000.
    pub log: Vec<(Duration, Event)>,
    /// Where the tool was from look to look, if it was watched: x, y, z; a million looks at most.
    pub way: Vec<[f64; 3]>,
    planned: usize,
}

impl Rehearsal {
    /// Whether all steps have ended without an alarm.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.steps == self.planned && self.alarms.is_empty()
    }
}

/// Has a virtual arm do a plan, at full speed.
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
/// As [`stage`], and for a command that fits no frame. What the arm refuses is no error but an alarm in the
/// [`Rehearsal`].
pub fn rehearse(plan: &Plan, options: &RehearseOptions) -> Result<Rehearsal, Error> {
    let mut run = Run::on(stage(plan, options)?, options.watch);
    let mut commands = plan.commands();
    run.fill(&mut commands)?;
    let start = Set::QueuedCmdStartExec(QueuedCmdStartExec {});
    tell(&mut run.arm, &start, Ctrl::SET)?;
    while run.next() {
        run.fill(&mut commands)?;
    }
    Ok(run.finish(plan))
}

/// A rehearsal under way.
struct Run {
    arm: Controller,
    began: ArmInstant,
    /// Number of commands handed over.
    told: usize,
    log: Vec<(Duration, Event)>,
    /// From one look to the next.
    watch: Option<Duration>,
    way: Vec<[f64; 3]>,
}

impl Run {
    fn on(arm: Controller, watch: Option<Duration>) -> Self {
        let mut run = Self {
            began: arm.now(),
            arm,
            told: 0,
            log: Vec::new(),
            watch: watch.map(|each| each.max(Duration::from_micros(1))),
            way: Vec::new(),
        };
        run.look();
        while run.arm.poll_event().is_some() {}
        run
    }

    fn now(&self) -> Duration {
        self.arm.now() - self.began
    }

    /// Number of commands in the queue, the one under way among them.
    fn unfinished(&self) -> usize {
        let queue = self.arm.state().queue;
        queue.waiting + usize::from(queue.running.is_some())
    }

    /// Hands over commands as long as there is room.
    fn fill(&mut self, commands: &mut impl Iterator<Item = Set>) -> Result<(), Error> {
        let capacity = self.arm.state().queue.capacity;
        let room = capacity.saturating_sub(self.unfinished());
        for command in commands.take(room) {
            tell(&mut self.arm, &command, Ctrl::QUEUED)?;
            self.told += 1;
        }
        Ok(())
    }

    /// Goes to the next event; `false` if the arm has done all that it had, or is held.
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
        self.look();
        self.note();
        true
    }

    fn watch_until(&mut self, end: ArmInstant) {
        while let Some(next) = (self.watch).map(|each| self.arm.now() + each)
            && next < end
            && self.arm.state().moving
            && self.way.len() < MOST_LOOKS
        {
            self.arm.advance(next);
            self.look();
        }
    }

    fn look(&mut self) {
        if self.watch.is_some() && self.way.len() < MOST_LOOKS {
            let Pose { x, y, z, .. } = self.arm.state().pose;
            self.way.push([x, y, z]);
        }
    }

    fn note(&mut self) {
        let now = self.now();
        while let Some(event) = self.arm.poll_event() {
            if !event.is_routine() && self.log.len() < MOST_EVENTS {
                self.log.push((now, event));
            }
        }
    }

    fn finish(mut self, plan: &Plan) -> Rehearsal {
        self.note();
        let state = self.arm.state();
        let done = self.told.saturating_sub(self.unfinished());
        let told_first = plan.preamble().into_iter().count();
        Rehearsal {
            drawing: self.arm.drawing(),
            time: self.now(),
            steps: done.saturating_sub(told_first),
            pose: state.pose,
            joints: state.joints,
            alarms: state.alarms,
            log: self.log,
            way: self.way,
            planned: plan.steps.len(),
        }
    }
}
