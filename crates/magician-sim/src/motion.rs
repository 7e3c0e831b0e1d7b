//! Where the arm is and how it moves (model sections 4, 7, 11 and 14).

use magician_motion::{
    ArmState, Bound, Crossing, Geometry, JointAngles, MotionError, Move, MoveKind, Plan, Planner,
    Speeds, Target, Trajectory,
};
use magician_protocol::commands::HomeCmd;
use magician_protocol::{Alarm, PoList, Writable};

use crate::Micros;
use crate::convert::micros;
use crate::core::Core;
use crate::dispatch::Step;
use crate::event::{Event, Refusal};
use crate::limits::{alarm_of, is_at};
use crate::outputs::Outputs;

/// The commanded position of the arm: at rest, or on its way.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    rest: ArmState,
    /// The arm's measures under which `rest.pose` holds; another tool bias makes another pose of the same joints.
    measured: Geometry,
    under_way: Option<UnderWay>,
}

/// A motion and when it began.
#[derive(Clone, Debug)]
struct UnderWay {
    kind: Kind,
    started: Micros,
    ends: Micros,
    /// What to raise when it has ended: something stops it before its target.
    alarm: Option<u8>,
    /// What it switches on its way.
    outputs: Outputs,
    /// When a limit alarm drops because the joint has come back inside.
    leaves_limit: Option<Micros>,
}

/// A trajectory is most of an arm's memory, and moving about is what arms do: it stays in place.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)]
enum Kind {
    /// Homing, while it looks for the switch of J1: no joint is commanded.
    Search,
    /// A planned motion.
    Path(Trajectory),
    /// The end of a motion that was force-stopped.
    Brake(Trajectory),
}

impl UnderWay {
    fn trajectory(&self) -> Option<&Trajectory> {
        match &self.kind {
            Kind::Search => None,
            Kind::Path(trajectory) | Kind::Brake(trajectory) => Some(trajectory),
        }
    }

    fn elapsed(&self, now: Micros) -> Micros {
        now.saturating_sub(self.started)
    }
}

impl Motion {
    pub(crate) fn at(joints: JointAngles) -> Self {
        let measured = Geometry::default();
        Self {
            rest: ArmState::at_joints(&measured, &joints),
            measured,
            under_way: None,
        }
    }

    /// Whether anything moves; the search of homing counts.
    pub(crate) fn is_moving(&self) -> bool {
        self.under_way.is_some()
    }

    /// When the motion ends, or on its way switches an output or drops a limit alarm.
    pub(crate) fn next_event(&self) -> Option<Micros> {
        let motion = self.under_way.as_ref()?;
        let switches = motion.outputs.next_due();
        let on_the_way = [
            motion.leaves_limit,
            switches.map(|at| motion.started.saturating_add(at)),
        ];
        let first = on_the_way.into_iter().flatten().min();
        Some(first.map_or(motion.ends, |at| at.min(motion.ends)))
    }

    /// Where the arm is commanded to be, for the tool bias in force. A target that has been reached reads back as it
    /// was given.
    fn state(&self, now: Micros, geometry: &Geometry) -> ArmState {
        let path = self.under_way.as_ref().and_then(|motion| {
            let trajectory = motion.trajectory()?;
            Some(trajectory.sample(motion.elapsed(now)))
        });
        let state = path.unwrap_or(self.rest);
        if *geometry == self.measured {
            state
        } else {
            ArmState::at_joints(geometry, &state.joints)
        }
    }
}

impl Core {
    /// Where the arm is at the present instant.
    pub(crate) fn arm(&self) -> ArmState {
        self.motion.state(self.now, &self.geometry())
    }

    fn planner(&self, speeds: Speeds) -> Planner {
        Planner {
            geometry: self.geometry(),
            limits: self.profile.limits_in_force(),
            speeds,
        }
    }

    /// What the arm would do about a move from where it is, at the speeds set now.
    pub(crate) fn plan(&self, request: &Move) -> Result<Plan, MotionError> {
        self.planner(self.ptp_speeds()).plan(&self.arm(), request)
    }

    /// Begins a motion. One that is under way is replaced: if it was the queue's, its command has finished. A motion
    /// that cannot be planned is refused with an alarm and changes nothing.
    pub(crate) fn move_arm(&mut self, id: u8, request: &Move, outputs: PoList) -> Step {
        match self.plan(request) {
            Ok(plan) => {
                self.halt();
                let alarm = alarm_on_the_way(request, plan.crossing);
                let outputs = Outputs::new(outputs, &plan.trajectory);
                self.begin(Kind::Path(plan.trajectory), alarm, outputs)
            }
            Err(error) => {
                self.raise(alarm_in_planning(&error));
                self.refuse(id, Refusal::Unplannable)
            }
        }
    }

    /// Begins homing: first the search for the switch of J1, which finds the reference, then the joint move to the
    /// home point.
    pub(crate) fn home(&mut self) -> Step {
        self.halt();
        self.begin(Kind::Search, None, Outputs::default())
    }

    /// Brakes what moves; a motion that brakes already goes on doing so.
    pub(crate) fn brake(&mut self) {
        let Some(motion) = &self.motion.under_way else {
            return;
        };
        match &motion.kind {
            Kind::Brake(_) => {}
            Kind::Search => self.end_motion(),
            Kind::Path(trajectory) => {
                let (elapsed, factor) = (motion.elapsed(self.now), self.profile.stop.force_factor);
                let plan = (self.planner(self.ptp_speeds())).brake(trajectory, elapsed, factor);
                let alarm = plan.crossing.map(|crossing| alarm_at_limit(&crossing));
                self.motion.under_way = None;
                // Its command finishes when the arm stands.
                self.begin(Kind::Brake(plan.trajectory), alarm, Outputs::default());
            }
        }
    }

    /// Ends what moves on the spot, without a ramp.
    pub(crate) fn halt(&mut self) {
        if self.motion.is_moving() {
            let state = self.motion.state(self.now, &self.motion.measured);
            self.motion.rest = state;
            self.motion.under_way = None;
            self.drop_limit_alarms();
            self.finish_moving();
        }
    }

    /// Puts the commanded joints somewhere without a motion.
    pub(crate) fn place_at(&mut self, joints: JointAngles) {
        self.motion = Motion {
            rest: ArmState::at_joints(&self.geometry(), &joints),
            measured: self.geometry(),
            under_way: None,
        };
        self.drop_limit_alarms();
    }

    fn begin(&mut self, kind: Kind, alarm: Option<u8>, outputs: Outputs) -> Step {
        let lasting = match &kind {
            Kind::Search => micros(self.profile.home.search),
            Kind::Path(trajectory) | Kind::Brake(trajectory) => trajectory.duration_us(),
        };
        if let Kind::Path(trajectory) = &kind {
            self.motion.measured = self.geometry();
            self.motion.rest = *trajectory.start();
        }
        self.motion.under_way = Some(UnderWay {
            kind,
            started: self.now,
            ends: self.now.saturating_add(lasting),
            alarm,
            outputs,
            leaves_limit: None,
        });
        self.watch_limits();
        if lasting > 0 {
            return Step::Moving;
        }
        self.switch_outputs();
        self.end_motion();
        if self.motion.is_moving() {
            Step::Moving
        } else {
            Step::Done
        }
    }

    /// Something is due in the motion: an output, the drop of a limit alarm, its end.
    pub(crate) fn motion_event(&mut self) {
        self.switch_outputs();
        let ended = self.motion.under_way.as_ref().map(|motion| motion.ends);
        if ended.is_some_and(|ends| ends <= self.now) {
            self.end_motion();
        } else {
            self.drop_limit_alarms();
            self.watch_limits();
        }
    }

    fn switch_outputs(&mut self) {
        while let Some(motion) = &mut self.motion.under_way {
            let elapsed = motion.elapsed(self.now);
            let (Kind::Path(trajectory), outputs) = (&motion.kind, &mut motion.outputs) else {
                return;
            };
            let Some(output) = outputs.take_due(elapsed, trajectory) else {
                return;
            };
            self.switch(output);
        }
    }

    fn end_motion(&mut self) {
        let Some(motion) = self.motion.under_way.take() else {
            return;
        };
        if let Some(trajectory) = motion.trajectory() {
            self.motion.rest = *trajectory.end();
        }
        self.drop_limit_alarms();
        if let Some(code) = motion.alarm {
            self.raise(code);
        }
        let homing = matches!(motion.kind, Kind::Search) && motion.ends <= self.now;
        if !homing || self.leave_switch() == Step::Done {
            self.finish_moving();
        }
    }

    /// Homing has found its reference: now to the home point.
    fn leave_switch(&mut self) -> Step {
        self.homed = true;
        let request = Move {
            target: self.home_point(),
            kind: MoveKind::Joint,
        };
        let plan = self
            .planner(self.homing_speeds())
            .plan(&self.arm(), &request);
        match plan {
            Ok(plan) => {
                let alarm = alarm_on_the_way(&request, plan.crossing);
                self.begin(Kind::Path(plan.trajectory), alarm, Outputs::default())
            }
            Err(error) => {
                self.raise(alarm_in_planning(&error));
                let reason = Refusal::Unplannable;
                self.refuse(<HomeCmd as Writable>::ROW.id, reason)
            }
        }
    }

    /// Whether the joints stand at the limit that an alarm is about: its cause stands.
    pub(crate) fn limit_stands(&self, code: u8) -> bool {
        let limits = self.profile.limits_in_force();
        let joints = self.arm().joints;
        Bound::ALL
            .into_iter()
            .any(|bound| alarm_of(bound) == code && is_at(bound, &limits, &joints))
    }

    /// Drops the limit alarms of joints that are inside again; the hold on the queue stays (model section 4).
    fn drop_limit_alarms(&mut self) {
        for bound in Bound::ALL {
            let code = alarm_of(bound);
            if self.alarms.standing().contains(code) && !self.limit_stands(code) {
                self.alarms.drop_alarm(code);
                self.log.push(Event::AlarmCleared { code });
            }
        }
    }

    /// Finds out when the motion takes a joint back inside whose limit alarm stands.
    fn watch_limits(&mut self) {
        let (standing, now) = (self.alarms.standing(), self.now);
        let limits = self.profile.limits_in_force();
        let Some(motion) = &mut self.motion.under_way else {
            return;
        };
        motion.leaves_limit = None;
        if !standing.blocking() {
            return;
        }
        let from = motion.elapsed(now);
        let leaving = |trajectory: &Trajectory| {
            let leaves = |bound: Bound| {
                let outside = |t| is_at(bound, &limits, &trajectory.sample(t).joints);
                first_inside(from, trajectory.duration_us(), outside)
            };
            Bound::ALL
                .into_iter()
                .filter(|bound| standing.contains(alarm_of(*bound)))
                .filter_map(leaves)
                .min()
        };
        motion.leaves_limit = match &motion.kind {
            Kind::Search => None,
            Kind::Path(trajectory) | Kind::Brake(trajectory) => {
                leaving(trajectory).map(|t| motion.started.saturating_add(t))
            }
        };
    }
}

/// Looks at a motion for where it comes inside, one that goes out and back included.
const LOOKS: Micros = 64;

/// The first microsecond after `from` that is inside, if a motion gets there; one that is inside for less than a
/// [`LOOKS`]th of its time may be taken for one that does not.
fn first_inside(from: Micros, to: Micros, outside: impl Fn(Micros) -> bool) -> Option<Micros> {
    let span = to.saturating_sub(from);
    let look = |step: Micros| from + span / LOOKS * step + span % LOOKS * step / LOOKS;
    let first = (1..=LOOKS).find(|step| !outside(look(*step)))?;
    let (mut out, mut inside) = (look(first - 1), look(first));
    while inside - out > 1 {
        let middle = out + (inside - out) / 2;
        if outside(middle) {
            out = middle;
        } else {
            inside = middle;
        }
    }
    Some(inside)
}

/// The alarm for a motion that is not begun.
fn alarm_in_planning(error: &MotionError) -> u8 {
    match error {
        MotionError::Limit { .. } => Alarm::PlanInvLimit,
        MotionError::Speed { .. } => Alarm::PlanSpeedInputParam,
        // Out of reach, and whatever else cannot be calculated.
        _ => Alarm::PlanInvCalc,
    }
}

/// The alarm for what stops a motion on its way: a move of joints runs into a limit, a path in space leaves the limits
/// or the reach (model section 15a).
fn alarm_on_the_way(request: &Move, crossing: Option<Crossing>) -> Option<u8> {
    let crossing = crossing?;
    let of_joints = matches!(
        request.target,
        Target::Joints(_) | Target::JointIncrement(_)
    ) && request.kind == MoveKind::Joint;
    Some(match crossing.cause {
        _ if of_joints => alarm_at_limit(&crossing),
        MotionError::Limit { .. } => Alarm::MoveInvLimit,
        _ => Alarm::MoveInvCalc,
    })
}

fn alarm_at_limit(crossing: &Crossing) -> u8 {
    match crossing.cause {
        MotionError::Limit { bound, .. } => alarm_of(bound),
        _ => Alarm::MoveInvCalc,
    }
}
