//! A teach pendant without its buttons: what its controls are set to, and which order each of them comes to.

use std::time::Duration;

use magician_program::Grip;

use super::{
    Activity, Axis, HoldAction, HoldToRun, JogDirection, OrderDone, PendantOrder, ToolOrder,
    ToolState,
};

/// Lengths of steps, mm or degrees.
const STEPS: [f32; 5] = [0.1, 1.0, 5.0, 10.0, 50.0];
/// Shares of the set speeds, percent.
const SPEEDS: [f32; 8] = [1.0, 5.0, 10.0, 20.0, 30.0, 50.0, 75.0, 100.0];

/// What the controls for directions move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JogFrame {
    /// The tool, along x, y, z and r.
    Cartesian,
    /// Joint by joint.
    Joints,
}

/// How a control for a direction moves the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JogMode {
    /// The arm moves while the control is held.
    Hold,
    /// Each press is a checked move by the length that is set.
    Step,
}

/// The state of a pendant. It does nothing itself: its inputs come to orders, which are for a
/// [`PendantSession`](super::PendantSession), and what came of them is told to it ([`done`](Self::done)).
///
/// Times are since any beginning, the same for all calls.
///
/// ```
/// use std::time::Duration;
///
/// use magician_job::jog::{Axis, JogDirection, JogMode, PendantOrder, Pendant, ToolState};
///
/// let mut pendant = Pendant::new(50.0, ToolState::default(), false);
/// let up = JogDirection { axis: Axis::Z, forward: true };
/// // A press is a step, of 5 mm at first.
/// let now = Duration::ZERO;
/// let step = pendant.press(up, now);
/// assert!(matches!(step, Some(PendantOrder::Step { length: 5.0, .. })));
/// // Or a jog, for as long as the control is held.
/// pendant.set_mode(JogMode::Hold);
/// pendant.hold.set_reports_releases(true);
/// assert!(matches!(pendant.press(up, now), Some(PendantOrder::Jog { .. })));
/// assert_eq!(pendant.tick(now + Duration::from_millis(50)), Some(PendantOrder::Keep));
/// assert_eq!(pendant.release(Some(up)), Some(PendantOrder::EndJog));
/// ```
#[derive(Clone, Debug)]
pub struct Pendant {
    /// What directions are of. [`set_frame`](Self::set_frame) changes it while something may be held.
    pub frame: JogFrame,
    /// What a press does. [`set_mode`](Self::set_mode) changes it while something may be held.
    pub mode: JogMode,
    /// Length of a step, mm or deg.
    pub step: f32,
    /// Share of the set speeds of jogs and moves, percent.
    pub speed: f32,
    /// What the tools do, as far as is known.
    pub tools: ToolState,
    /// Whether there is a rail.
    pub rail: bool,
    /// The control that is held.
    pub hold: HoldToRun,
    /// What moves the arm: as [`PendantSession::activity`](super::PendantSession::activity) says.
    pub activity: Option<Activity>,
    /// The laser was told to burn and has not answered.
    laser_pending: bool,
    /// The step that waits for the end of a stop.
    step_pending: Option<JogDirection>,
}

impl Pendant {
    /// With steps of 5 mm along coordinates; at that share of the set speeds, percent.
    #[must_use]
    pub fn new(speed: f32, tools: ToolState, rail: bool) -> Self {
        Self {
            frame: JogFrame::Cartesian,
            mode: JogMode::Step,
            step: 5.0,
            speed,
            tools,
            rail,
            hold: HoldToRun::new(),
            activity: None,
            laser_pending: false,
            step_pending: None,
        }
    }

    /// The control for a direction is pressed. While a step is under way further ones are not kept for later; while a stop is,
    /// the last one waits for its end, unless its control is released before.
    pub fn press(&mut self, direction: JogDirection, now: Duration) -> Option<PendantOrder> {
        match self.mode {
            JogMode::Hold => self.turn(|hold| hold.press(direction, now)),
            JogMode::Step => self.step(direction),
        }
    }

    /// It is reported again, as a repeat of a press.
    pub fn repeat(&mut self, direction: JogDirection, now: Duration) -> Option<PendantOrder> {
        match self.mode {
            JogMode::Hold => self.turn(|hold| hold.repeat(direction, now)),
            JogMode::Step => self.step(direction),
        }
    }

    /// It is released; `None` for any other control.
    pub fn release(&mut self, direction: Option<JogDirection>) -> Option<PendantOrder> {
        let stepped = self.step_pending.take_if(|step| Some(*step) == direction);
        let order = self.turn(|hold| hold.release(direction));
        order.or(stepped.map(|_| PendantOrder::EndJog))
    }

    /// To be called several times a second, as long as the holder of the control is known to be present: what is held
    /// goes on, or
    /// ends when it was not reported for too long.
    pub fn tick(&mut self, now: Duration) -> Option<PendantOrder> {
        self.turn(|hold| hold.tick(now))
    }

    /// The holder may be gone: a held jog ends, and a step that waits is dropped.
    pub fn release_all(&mut self) -> Option<PendantOrder> {
        let stepped = self.step_pending.take();
        let order = self.turn(HoldToRun::release_all);
        order.or(stepped.map(|_| PendantOrder::EndJog))
    }

    /// Everything stops, and the laser goes dark.
    pub fn stop(&mut self) -> PendantOrder {
        self.hold.release_all();
        self.step_pending = None;
        self.tools.laser = false;
        self.laser_pending = false;
        PendantOrder::Stop
    }

    /// Lets directions be of something else: what is held ends.
    pub fn set_frame(&mut self, frame: JogFrame) -> Option<PendantOrder> {
        self.frame = frame;
        self.release_all()
    }

    /// Lets a press do something else: what is held ends.
    pub fn set_mode(&mut self, mode: JogMode) -> Option<PendantOrder> {
        self.mode = mode;
        self.release_all()
    }

    /// The next longer step of 0.1, 1, 5, 10 and 50 mm or deg.
    pub fn longer_step(&mut self) {
        self.step = next(&STEPS, self.step, true);
    }

    /// The next shorter step.
    pub fn shorter_step(&mut self) {
        self.step = next(&STEPS, self.step, false);
    }

    /// The next higher speed of 1, 5, 10, 20, 30, 50, 75 and 100 %.
    #[must_use]
    pub fn faster(&self) -> PendantOrder {
        PendantOrder::Speed(next(&SPEEDS, self.speed, true))
    }

    /// The next lower speed.
    #[must_use]
    pub fn slower(&self) -> PendantOrder {
        PendantOrder::Speed(next(&SPEEDS, self.speed, false))
    }

    /// The suction cup goes on, or off if it is on.
    #[must_use]
    pub const fn toggle_suction(&self) -> PendantOrder {
        PendantOrder::Tool(ToolOrder::Suction(!self.tools.suction))
    }

    /// The gripper closes, then opens, then its pump goes off, and so on.
    #[must_use]
    pub const fn next_gripper(&self) -> PendantOrder {
        PendantOrder::Tool(ToolOrder::Gripper(match self.tools.gripper {
            Grip::Off => Grip::Close,
            Grip::Close => Grip::Open,
            Grip::Open => Grip::Off,
        }))
    }

    /// The laser burns or goes dark. The caller has made sure that it may.
    pub const fn laser(&mut self, on: bool) -> PendantOrder {
        self.laser_pending = on;
        PendantOrder::Tool(ToolOrder::Laser(on))
    }

    /// Whether the laser burns, or was told to and has not answered.
    #[must_use]
    pub const fn may_burn(&self) -> bool {
        self.tools.laser || self.laser_pending
    }

    /// Whether this axis is being moved by an order.
    #[must_use]
    pub fn moves(&self, axis: Axis) -> bool {
        matches!(self.activity, Some(Activity::Jog(direction) | Activity::Step(direction)) if direction.axis == axis)
    }

    /// Takes note of what came of an order.
    pub fn done(&mut self, done: &OrderDone) {
        match (done.activity, &done.outcome) {
            (Activity::Jog(_), Err(_)) => {
                self.hold.release_all();
            }
            // What waited for it has begun, or will not.
            (Activity::Stop, _) => self.step_pending = None,
            (Activity::Speed(percent), Ok(())) => self.speed = percent,
            (Activity::Tool(tool), outcome) => {
                if matches!(tool, ToolOrder::Laser(_)) {
                    self.laser_pending = false;
                }
                if outcome.is_ok() {
                    self.tools.apply(tool);
                }
            }
            _ => {}
        }
    }

    fn step(&mut self, direction: JogDirection) -> Option<PendantOrder> {
        let waits = self.activity == Some(Activity::Stop);
        self.step_pending = waits.then_some(direction);
        (waits || self.activity.is_none()).then_some(PendantOrder::Step {
            direction,
            length: self.step,
            burning: self.tools.laser,
        })
    }

    fn turn(&mut self, turn: impl FnOnce(&mut HoldToRun) -> HoldAction) -> Option<PendantOrder> {
        match turn(&mut self.hold) {
            HoldAction::Begin { direction, keep } => Some(PendantOrder::Jog { direction, keep }),
            HoldAction::Keep => Some(PendantOrder::Keep),
            HoldAction::End => Some(PendantOrder::EndJog),
            HoldAction::Nothing => None,
        }
    }
}

/// The next one of a list, upwards or downwards.
fn next(list: &[f32], now: f32, up: bool) -> f32 {
    let found = if up {
        list.iter().find(|one| **one > now)
    } else {
        list.iter().rev().find(|one| **one < now)
    };
    found.copied().unwrap_or(now)
}

#[cfg(test)]
mod tests;
