//! Model of a teach pendant without its buttons: the settings of its controls, and the order that
//! each control gives.

use std::time::Duration;

use magician_program::Grip;

use super::{
    Activity, Axis, HoldAction, HoldToRun, JogDirection, OrderDone, PendantOrder, ToolOrder,
    ToolState,
};

/// Selectable step lengths, mm or degrees.
const STEP_LENGTHS: [f32; 5] = [0.1, 1.0, 5.0, 10.0, 50.0];
/// Selectable speed ratios, percent.
const SPEED_RATIOS: [f32; 8] = [1.0, 5.0, 10.0, 20.0, 30.0, 50.0, 75.0, 100.0];

/// Coordinates that the direction controls move along.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JogFrame {
    /// Tool coordinates x, y, z and r.
    Cartesian,
    /// Single joints.
    Joints,
}

/// Effect of a direction control.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum JogMode {
    /// Jog while the control is held.
    Hold,
    /// Checked move by the selected length at each press.
    Step,
}

/// State of a pendant. It has no side effects: inputs return orders for a
/// [`PendantSession`](super::PendantSession), whose outcomes are passed back to
/// [`done`](Self::done).
///
/// Times count from any fixed origin, the same for all calls.
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
    /// Coordinates of the direction controls. Use [`set_frame`](Self::set_frame) to change them
    /// while a control may be held.
    pub frame: JogFrame,
    /// Effect of a press. Use [`set_mode`](Self::set_mode) to change it while a control may be
    /// held.
    pub mode: JogMode,
    /// Length of a step, mm or deg.
    pub step: f32,
    /// Speed ratio of jogs and moves, percent.
    pub speed: f32,
    /// Known state of the tools.
    pub tools: ToolState,
    /// True if the arm is on a rail.
    pub rail: bool,
    /// The hold-to-run control.
    pub hold: HoldToRun,
    /// Activity that moves the arm, from
    /// [`PendantSession::activity`](super::PendantSession::activity).
    pub activity: Option<Activity>,
    /// True while an order to switch the laser on has no reply.
    laser_pending: bool,
    /// Step that waits for the end of a stop.
    step_pending: Option<JogDirection>,
}

impl Pendant {
    /// A pendant in Cartesian coordinates with steps of 5 mm, at this speed ratio in percent.
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

    /// Handles a press of a direction control.
    ///
    /// During a step further presses are ignored. A press during a stop replaces an earlier one,
    /// and waits until the stop has ended, unless its control is released first.
    pub fn press(&mut self, direction: JogDirection, now: Duration) -> Option<PendantOrder> {
        match self.mode {
            JogMode::Hold => self.apply_hold(|hold| hold.press(direction, now)),
            JogMode::Step => self.step(direction),
        }
    }

    /// Handles a press reported as a repeat.
    pub fn repeat(&mut self, direction: JogDirection, now: Duration) -> Option<PendantOrder> {
        match self.mode {
            JogMode::Hold => self.apply_hold(|hold| hold.repeat(direction, now)),
            JogMode::Step => self.step(direction),
        }
    }

    /// Handles the release of a direction control; `None` means any other control.
    pub fn release(&mut self, direction: Option<JogDirection>) -> Option<PendantOrder> {
        let dropped_step = self.step_pending.take_if(|step| Some(*step) == direction);
        let order = self.apply_hold(|hold| hold.release(direction));
        order.or(dropped_step.map(|_| PendantOrder::EndJog))
    }

    /// Handles the passage of time. Call it several times a second while the person at the control
    /// is known to be present: a held jog is kept alive, or ends if its control was not reported
    /// for too long.
    pub fn tick(&mut self, now: Duration) -> Option<PendantOrder> {
        self.apply_hold(|hold| hold.tick(now))
    }

    /// Ends a held jog and drops a waiting step: the person at the control may be gone.
    pub fn release_all(&mut self) -> Option<PendantOrder> {
        let dropped_step = self.step_pending.take();
        let order = self.apply_hold(HoldToRun::release_all);
        order.or(dropped_step.map(|_| PendantOrder::EndJog))
    }

    /// Stops everything and switches the laser off.
    pub fn stop(&mut self) -> PendantOrder {
        self.hold.release_all();
        self.step_pending = None;
        self.tools.laser = false;
        self.laser_pending = false;
        PendantOrder::Stop
    }

    /// Changes the coordinates of the direction controls. Ends a held jog.
    pub fn set_frame(&mut self, frame: JogFrame) -> Option<PendantOrder> {
        self.frame = frame;
        self.release_all()
    }

    /// Changes the effect of a press. Ends a held jog.
    pub fn set_mode(&mut self, mode: JogMode) -> Option<PendantOrder> {
        self.mode = mode;
        self.release_all()
    }

    /// Selects the next longer step of 0.1, 1, 5, 10 and 50 mm or deg.
    pub fn longer_step(&mut self) {
        self.step = next_entry(&STEP_LENGTHS, self.step, true);
    }

    /// Selects the next shorter step.
    pub fn shorter_step(&mut self) {
        self.step = next_entry(&STEP_LENGTHS, self.step, false);
    }

    /// Order for the next higher speed ratio of 1, 5, 10, 20, 30, 50, 75 and 100 %.
    #[must_use]
    pub fn faster(&self) -> PendantOrder {
        PendantOrder::Speed(next_entry(&SPEED_RATIOS, self.speed, true))
    }

    /// Order for the next lower speed ratio.
    #[must_use]
    pub fn slower(&self) -> PendantOrder {
        PendantOrder::Speed(next_entry(&SPEED_RATIOS, self.speed, false))
    }

    /// Order that toggles the suction cup.
    #[must_use]
    pub const fn toggle_suction(&self) -> PendantOrder {
        PendantOrder::Tool(ToolOrder::Suction(!self.tools.suction))
    }

    /// Order for the next state of the gripper: closed, open, pump off.
    #[must_use]
    pub const fn next_gripper(&self) -> PendantOrder {
        PendantOrder::Tool(ToolOrder::Gripper(match self.tools.gripper {
            Grip::Off => Grip::Close,
            Grip::Close => Grip::Open,
            Grip::Open => Grip::Off,
        }))
    }

    /// Order that switches the laser. The caller has verified that it may burn.
    pub const fn laser(&mut self, on: bool) -> PendantOrder {
        self.laser_pending = on;
        PendantOrder::Tool(ToolOrder::Laser(on))
    }

    /// True if the laser burns, or if an order to switch it on has no reply yet.
    #[must_use]
    pub const fn may_burn(&self) -> bool {
        self.tools.laser || self.laser_pending
    }

    /// True if a jog or step in progress moves this axis.
    #[must_use]
    pub fn moves(&self, axis: Axis) -> bool {
        matches!(self.activity, Some(Activity::Jog(direction) | Activity::Step(direction)) if direction.axis == axis)
    }

    /// Applies the outcome of an order.
    pub fn done(&mut self, done: &OrderDone) {
        match (done.activity, &done.outcome) {
            (Activity::Jog(_), Err(_)) => {
                self.hold.release_all();
            }
            // The step that waited for the stop has begun by now, or was dropped.
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
            // Other outcomes change nothing that the pendant shows.
            _ => {}
        }
    }

    fn step(&mut self, direction: JogDirection) -> Option<PendantOrder> {
        let waits_for_stop = self.activity == Some(Activity::Stop);
        self.step_pending = waits_for_stop.then_some(direction);
        (waits_for_stop || self.activity.is_none()).then_some(PendantOrder::Step {
            direction,
            length: self.step,
            burning: self.tools.laser,
        })
    }

    fn apply_hold(
        &mut self,
        report: impl FnOnce(&mut HoldToRun) -> HoldAction,
    ) -> Option<PendantOrder> {
        match report(&mut self.hold) {
            HoldAction::Begin { direction, keep } => Some(PendantOrder::Jog { direction, keep }),
            HoldAction::Keep => Some(PendantOrder::Keep),
            HoldAction::End => Some(PendantOrder::EndJog),
            HoldAction::Nothing => None,
        }
    }
}

/// Next entry of an ascending list, upwards or downwards; `now` at its end.
fn next_entry(list: &[f32], now: f32, up: bool) -> f32 {
    let found = if up {
        list.iter().find(|entry| **entry > now)
    } else {
        list.iter().rev().find(|entry| **entry < now)
    };
    found.copied().unwrap_or(now)
}

#[cfg(test)]
mod tests;
