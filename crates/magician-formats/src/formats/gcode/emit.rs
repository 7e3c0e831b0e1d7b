//! The steps that a program's motions become.

use magician_host::build;
use magician_protocol::Set;

use super::arc::Arc;
use super::{Arcs, Chords, GcodeOptions};
use crate::{Action, Origin, Part, Pause, PauseCause, Plan, Step, Travel};

/// The rotation of all poses: a pen or a laser has none.
const ROTATION: f32 = 0.0;

/// How a motion with the tool at work goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutSettings {
    /// Speed, mm/s; that in force on the arm if the program has none.
    pub(super) feed: Option<f64>,
    /// Power of the laser, percent.
    pub(super) power: f64,
    /// The speed at which it has that power, if it is in proportion to speed, mm/s.
    pub(super) follows: Option<f64>,
}

#[derive(Debug)]
pub(super) struct Emitter<'o> {
    pub(super) plan: Plan,
    options: &'o GcodeOptions,
    chords: &'o Chords,
    /// A laser draws.
    laser: bool,
    /// Where the program begins, until something has moved.
    start: Option<[f64; 3]>,
    /// The settings that the plan has made so far.
    line_speed: Option<[f64; 2]>,
    path_feed: Option<f64>,
    arc_feed: Option<f64>,
    /// A laser's path has begun, and the laser has not been switched off since.
    burning: bool,
    /// The last segment of it has power.
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

    /// Goes somewhere without drawing. In a laser's path that is a segment without power, so that the path goes on.
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

    /// To the beginning of the program, from a position that it does not define: with all joints, as no straight path is
    /// known. A run of the plan on an arm goes there from above. What burnt before was a figure from wherever the tool stood.
    pub(super) fn enter(&mut self, to: [f64; 3], origin: Origin) {
        self.darken(origin);
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

    /// To where the program begins, for work that begins at once: the tool may stand elsewhere, and would draw or burn all the
    /// way from there.
    fn begin(&mut self, origin: Origin) {
        if let Some(start) = self.start.take() {
            self.travel(start, origin);
        }
    }

    /// A line of the tool.
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

    /// Largest distance of a line from the curve that it stands for, mm in the file.
    pub(super) fn tolerance_of_curve(&self) -> f64 {
        self.chords.for_curve()
    }

    /// An arc of the tool.
    pub(super) fn arc(
        &mut self,
        arc: &Arc,
        work: CutSettings,
        origin: Origin,
    ) -> Result<(), String> {
        self.begin(origin);
        let tolerance = self.chords.for_curve();
        let lines = self.laser || self.options.arcs == Arcs::Lines || !arc.is_level();
        // What is as good as a line is one: the path goes on, and the arm refuses arcs that are flat.
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
        // The document has arcs obey the first, the vendor's code for the sibling arm the second (model section 9).
        self.line_speed(speed, acceleration, origin);
    }

    /// Waits, with the laser dark. Whether it was lit before.
    pub(super) fn wait(&mut self, milliseconds: u32, origin: Origin) -> bool {
        let was_lit = self.darken(origin);
        self.plan.push(Action::Wait(milliseconds), origin);
        was_lit
    }

    /// Waits for a person, with the laser dark.
    pub(super) fn pause(&mut self, text: String, origin: Origin) {
        self.laser_off(origin);
        let cause = PauseCause::Program;
        let pause = Box::new(Pause { text, cause });
        self.plan.push(Action::Pause(pause), origin);
    }

    /// Another tool is at work.
    pub(super) fn part(&mut self, part: Part, origin: Origin) {
        self.laser_off(origin);
        self.plan.push(Action::Part(Box::new(part)), origin);
    }

    /// Homes the arm, with the laser dark.
    pub(super) fn home(&mut self, origin: Origin) {
        self.laser_off(origin);
        self.plan.push(Action::Home, origin);
    }

    /// The laser goes off if the last segment has left it lit.
    pub(super) fn darken(&mut self, origin: Origin) -> bool {
        let was_lit = self.lit;
        if was_lit {
            self.plan.push(Action::Laser(false), origin);
            self.lit = false;
        }
        was_lit
    }

    /// The program switches the laser off: its path ends here.
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
