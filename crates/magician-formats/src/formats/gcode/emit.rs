//! Emission of plan steps for the motions of a program.

use magician_host::{Message, build};
use magician_protocol::Set;

use super::arc::Arc;
use super::{Arcs, Chords, GcodeOptions};
use crate::{Action, Origin, Part, Pause, PauseCause, Plan, Step, Travel};

/// Rotation r of all poses. A pen or a laser is round.
const ROTATION: f32 = 0.0;

/// Parameters of a motion with the tool at work.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutSettings {
    /// Speed, mm/s; `None` keeps the speed in force on the arm.
    pub(super) feed: Option<f64>,
    /// Laser power, percent.
    pub(super) power: f64,
    /// Speed at which the power applies, mm/s, if it shall be in proportion to speed (M4).
    pub(super) follows: Option<f64>,
}

#[derive(Debug)]
pub(super) struct Emitter<'o> {
    pub(super) plan: Plan,
    options: &'o GcodeOptions,
    chords: &'o Chords,
    /// True for a laser.
    laser: bool,
    /// Start of the program, until something has moved.
    start: Option<[f64; 3]>,
    /// Settings sent by the plan so far.
    line_speed: Option<[f64; 2]>,
    path_feed: Option<f64>,
    arc_feed: Option<f64>,
    /// True if a laser path has begun and the laser was not switched off since.
    burning: bool,
    /// True if its last segment has power.
    lit: bool,
}

impl<'o> Emitter<'o> {
    pub(super) fn new(
        title: &str,
        options: &'o GcodeOptions,
        chords: &'o Chords,
        laser: bool,
    ) -> Self {
        Self {
            plan: Plan::new(title),
            options,
            chords,
            laser,
            start: options.begins_at(),
            line_speed: None,
            path_feed: None,
            arc_feed: None,
            burning: false,
            lit: false,
        }
    }

    fn set(&mut self, command: Set, origin: Origin) {
        self.plan.push(Action::from(command), origin);
    }

    /// Moves without drawing. Within a laser path this is a segment without power, so that the path
    /// is not interrupted.
    pub(super) fn travel(&mut self, to: [f64; 3], origin: Origin) {
        self.start = None;
        if self.burning {
            self.burn(to, 0.0, None, origin);
            return;
        }
        self.travel_speed(origin);
        let to = pose(to);
        let by = Travel::Line;
        self.plan.push(Action::Move { to, by }, origin);
    }

    /// Moves to the start of the program with all joints, because no straight way is known.
    ///
    /// A run on an arm approaches it from above. The laser is switched off first, because a burn
    /// before it began at an unknown position.
    pub(super) fn enter(&mut self, to: [f64; 3], origin: Origin) {
        self.switch_laser_off(origin);
        self.start = None;
        self.travel_speed(origin);
        let to = pose(to);
        let by = Travel::Joints;
        self.plan.push(Action::Move { to, by }, origin);
    }

    fn travel_speed(&mut self, origin: Origin) {
        let options = self.options;
        self.line_speed(options.travel_speed, options.travel_acceleration, origin);
    }

    fn line_speed(&mut self, speed: f64, acceleration: f64, origin: Origin) {
        let wanted = Some([speed, acceleration]);
        if self.line_speed != wanted {
            self.line_speed = wanted;
            self.set(build::line_speed(speed as f32, acceleration as f32), origin);
        }
    }

    /// Moves to the program's start before work that begins there. The tool may be elsewhere and
    /// would draw all the way.
    fn begin(&mut self, origin: Origin) {
        if let Some(start) = self.start.take() {
            self.travel(start, origin);
        }
    }

    /// Adds a line of the tool.
    pub(super) fn line(&mut self, to: [f64; 3], work: CutSettings, origin: Origin) {
        self.begin(origin);
        self.path_speed(work.feed, origin);
        self.segment(to, work, origin);
    }

    fn segment(&mut self, to: [f64; 3], work: CutSettings, origin: Origin) {
        if self.laser {
            self.burn(to, work.power, work.follows, origin);
        } else {
            let to = to.map(|number| number as f32);
            self.plan.push(Action::Path { to }, origin);
        }
    }

    fn burn(&mut self, to: [f64; 3], power: f64, follows: Option<f64>, origin: Origin) {
        let to = to.map(|number| number as f32);
        let power = power as f32;
        self.burning = true;
        self.lit = power > 0.0;
        let mut step = Step::new(Action::Burn { to, power }, origin);
        step.feed = follows.map(|feed| feed as f32);
        self.plan.steps.push(step);
    }

    /// Largest distance of a chord from its curve, mm in the file.
    pub(super) fn tolerance_of_curve(&self) -> f64 {
        self.chords.for_curve()
    }

    /// Adds an arc of the tool.
    pub(super) fn arc(
        &mut self,
        arc: &Arc,
        work: CutSettings,
        origin: Origin,
    ) -> Result<(), Message> {
        self.begin(origin);
        let tolerance = self.chords.for_curve();
        let lines = self.laser || self.options.arcs == Arcs::Lines || !arc.is_level();
        // An arc that is flat within the tolerance becomes a line: the path continues, and the arm
        // refuses flat arcs anyway.
        if lines || arc.height() <= tolerance {
            self.path_speed(work.feed, origin);
            for corner in arc.corners(tolerance)? {
                self.segment(corner, work, origin);
            }
            return Ok(());
        }
        self.arc_speed(work.feed, origin);
        for [via, to] in arc.parts() {
            let (via, to) = (pose(via), pose(to));
            self.plan.push(Action::Arc { via, to }, origin);
        }
        Ok(())
    }

    fn path_speed(&mut self, feed: Option<f64>, origin: Origin) {
        if let Some(speed) = feed.filter(|_| feed != self.path_feed) {
            self.path_feed = feed;
            let acceleration = self.options.acceleration as f32;
            self.set(build::path_speed(speed as f32, acceleration), origin);
        }
    }

    fn arc_speed(&mut self, feed: Option<f64>, origin: Origin) {
        let Some(speed) = feed else { return };
        let acceleration = self.options.acceleration;
        if feed != self.arc_feed {
            self.arc_feed = feed;
            self.set(build::arc_speed(speed as f32, acceleration as f32), origin);
        }
        // By the document arcs obey the first setting; by the vendor's code for the sibling arm the
        // second (model section 9). So set both.
        self.line_speed(speed, acceleration, origin);
    }

    /// Waits with the laser off. Returns true if it was on.
    pub(super) fn wait(&mut self, milliseconds: u32, origin: Origin) -> bool {
        let was_lit = self.switch_laser_off(origin);
        self.plan.push(Action::Wait(milliseconds), origin);
        was_lit
    }

    /// Pauses for a person with the laser off.
    pub(super) fn pause(&mut self, text: String, origin: Origin) {
        self.laser_off(origin);
        let cause = PauseCause::Program;
        let pause = Box::new(Pause { text, cause });
        self.plan.push(Action::Pause(pause), origin);
    }

    /// Starts a part for another tool.
    pub(super) fn part(&mut self, part: Part, origin: Origin) {
        self.laser_off(origin);
        self.plan.push(Action::Part(Box::new(part)), origin);
    }

    /// Homes the arm with the laser off.
    pub(super) fn home(&mut self, origin: Origin) {
        self.laser_off(origin);
        self.plan.push(Action::Home, origin);
    }

    /// Switches the laser off if the last segment had power. Returns true if it had.
    pub(super) fn switch_laser_off(&mut self, origin: Origin) -> bool {
        let was_lit = self.lit;
        if was_lit {
            self.plan.push(Action::Laser(false), origin);
            self.lit = false;
        }
        was_lit
    }

    /// Switches the laser off at the end of a path.
    pub(super) fn laser_off(&mut self, origin: Origin) {
        if self.burning {
            self.plan.push(Action::Laser(false), origin);
            (self.burning, self.lit) = (false, false);
        }
    }
}

fn pose([x, y, z]: [f64; 3]) -> [f32; 4] {
    [x as f32, y as f32, z as f32, ROTATION]
}
