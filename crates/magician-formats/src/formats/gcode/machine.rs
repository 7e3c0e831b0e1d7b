//! State of the machine while a program runs, and the effect of each line.

use magician_host::{Action as Deed, Setting, SettingValue, message};

use super::Chords;
use super::GcodeOptions;
use super::Notes;
use super::SourceLine;
use super::arc::Plane;
use super::begin::ProgramStart;
use super::block::{Block, Code};
use super::cycle::Cycle;
use super::emit::Emitter;
use super::interpreter::LineOutcome;
use super::motion::MAX_RADIUS_DIFFERENCE;
use super::offsets::Offsets;
use super::pause::{self, pause_code};
use super::power::s_max;
use super::servo::Servo;
use super::survey::{Kind, Survey};
use crate::formats::span::SpanDiagnostic;
use crate::{Action, Diagnostic, DiagnosticCode, Origin, Part, Plan, Step};

/// Largest number of distinct tools. Each new tool is compared with all others, so it bounds time.
const MAX_TOOLS: usize = 1000;

/// Modal motion, which a line without a motion code repeats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    Travel,
    Line,
    /// Arc; true for clockwise.
    Arc(bool),
    /// Spline: cubic (G5) or quadratic (G5.1).
    Curve {
        cubic: bool,
    },
    /// Drilling cycle, in tenths of its G code.
    Cycle(u32),
    /// None, after G80.
    None,
}

#[derive(Debug)]
pub(super) struct Machine<'o> {
    pub(super) options: &'o GcodeOptions,
    /// Largest difference of both radii of an arc, mm.
    pub(super) tolerance: f64,
    pub(super) survey: Survey,
    pub(super) out: Emitter<'o>,
    pub(super) notes: Notes,
    pub(super) mode: Mode,
    /// Length of the current unit, mm.
    pub(super) unit: f64,
    pub(super) relative: bool,
    pub(super) absolute_centres: bool,
    pub(super) plane: Plane,
    pub(super) cycle: Cycle,
    /// End tangent (P, Q) and end of the last curve, from which the next one continues.
    pub(super) curve: Option<([f64; 2], [f64; 3])>,
    /// Feed F, mm/s.
    pub(super) feed: Option<f64>,
    /// True if M3, M4 or M106 has switched the laser on.
    on: bool,
    /// True after M4: power in proportion to speed.
    pub(super) follows_speed: bool,
    /// Current S, and the S of full power.
    power: f64,
    range: f64,
    pub(super) laser: bool,
    /// True if a servo lifts the pen; below its state, the angles that mean down, and the pen's
    /// state.
    pub(super) lifts: bool,
    servo: Servo,
    down: Vec<f64>,
    pub(super) pen_is_down: bool,
    /// Position of the tool in the arm's coordinates, as far as known.
    pub(super) at: [Option<f64>; 3],
    /// Tools (T) so far, and the current one.
    tools: Vec<u64>,
    tool: Option<u64>,
    /// True if something was drawn before the first tool.
    toolless: bool,
    pub(super) begin: ProgramStart,
    /// Origin of the program in the arm's coordinates.
    pub(super) offsets: Offsets,
}

impl<'o> Machine<'o> {
    pub(super) fn new(
        title: &str,
        options: &'o GcodeOptions,
        chords: &'o Chords,
        survey: Survey,
    ) -> Result<Self, Diagnostic> {
        let kind = survey.kind(options);
        let (laser, lifts) = (kind == Kind::Laser, kind == Kind::Servo);
        let mut notes = Notes::default();
        let never = survey.powers.greatest.is_none();
        let mut range = 1.0;
        if laser {
            let full = survey.powers.full(options.s_max, survey.fan_lights())?;
            full.note(&mut notes);
            range = full.s;
            if never && !survey.fan_lights() {
                let message = message!("the program has no S: it burns with full power");
                notes.add_with(DiagnosticCode::Power, Origin::NONE, message, |note| {
                    let percent = (Setting::Power, SettingValue::Any("PERCENT"));
                    note.remedy(percent, "sets the full power")
                });
            }
        }
        if let Some((sign, origin)) = survey.mill.sign().filter(|_| kind == Kind::Mill) {
            let message = message!(
                "this looks like a program for a mill ({sign}): its S is for a spindle, and \
                    nothing burns",
                sign
            );
            notes.add_with(DiagnosticCode::Power, origin, message, |note| {
                let note = note.remedy(
                    (Setting::Dialect, SettingValue::Word("laser")),
                    "burns with it",
                );
                if survey.mill.is_cooled_alone() {
                    note.remedy(Deed::Engrave, "takes the coolant for air assist")
                } else {
                    note
                }
            });
        }
        let down = if lifts {
            survey.angles.down()?
        } else {
            Vec::new()
        };
        let out = Emitter::new(title, options, chords, laser);
        Ok(Self {
            // A program without S only switches the laser, so S is full power; one without switches
            // only sets S, so the laser is always on.
            power: if never { range } else { 0.0 },
            on: !survey.switches && !survey.fan_lights(),
            options,
            tolerance: chords.drawn().min(MAX_RADIUS_DIFFERENCE),
            out,
            notes,
            mode: Mode::Travel,
            unit: 1.0,
            relative: false,
            absolute_centres: false,
            plane: Plane::default(),
            cycle: Cycle::default(),
            curve: None,
            feed: None,
            follows_speed: false,
            range,
            laser,
            lifts,
            servo: Servo::new(options.dialect == super::Dialect::Servo),
            down,
            survey,
            pen_is_down: false,
            at: options.begins_at().map_or([None; 3], |at| at.map(Some)),
            tools: Vec::new(),
            tool: None,
            toolless: false,
            begin: ProgramStart::new(options.placed),
            offsets: Offsets::default(),
        })
    }

    /// Number of steps of the plan.
    pub(super) fn steps(&self) -> usize {
        self.out.plan.steps.len()
    }

    /// Executes a line whose words are in the block.
    pub(super) fn take(
        &mut self,
        line: &SourceLine<'_>,
        stepped: LineOutcome,
        block: &Block,
    ) -> Result<(), Diagnostic> {
        match stepped {
            LineOutcome::LeftOut => {
                let range = 0..line.text.trim_end().len();
                let message = message!(
                    "lines that may be skipped (/) or set up a controller ($) are left out"
                );
                self.notes
                    .add(DiagnosticCode::LeftOut, line.origin(&range), message);
                Ok(())
            }
            LineOutcome::Words if !(block.is_empty() && block.left_out.is_empty()) => {
                for (why, range) in &block.left_out {
                    self.notes
                        .add(DiagnosticCode::LeftOut, line.origin(range), why.clone());
                }
                let done = self.follow(block, line);
                done.map_err(|error| line.diagnostic(error))
            }
            _ => Ok(()),
        }
    }

    /// Executes the words in the order of RS-274: settings, switches, pauses, motion, end.
    fn follow(&mut self, block: &Block, line: &SourceLine<'_>) -> Result<(), SpanDiagnostic> {
        let origin = line.origin(&block.range);
        for code in block.codes.iter() {
            // With further words it is the progress display of a slicer.
            let progress = code.is(b'M', 73) && block.has_any(b"PRQSCLD");
            if progress {
                let message = message!("M73, the progress of a print, is left out");
                self.notes.add(DiagnosticCode::LeftOut, origin, message);
                return Ok(());
            }
            if code.is(b'M', 72) || code.is(b'M', 73) {
                let message = message!(
                    "{code} restores earlier settings, which is not supported",
                    code = code.to_string()
                );
                let help = message!("write the settings out (G20, G91, F) where they change");
                return Err(SpanDiagnostic::new(code.range.clone(), message).help(help));
            }
        }
        // An unknown M code may give any meaning to the letters on its line.
        if block.is_foreign() {
            self.note_codes(block, origin);
            return Ok(());
        }
        self.check_bare(block)?;
        self.settings(block, origin)?;
        self.switches(block, origin)?;
        let changes = self.change_tool(block, line.text, origin);
        if block.has(b'G', 4) {
            self.pause(block, origin)?;
        }
        self.motion(block, origin)?;
        if let Some(code) = pause_code(block)
            && !changes
        {
            let told = pause::pause_message(line.text, block);
            let text = told.unwrap_or_else(|| format!("the program pauses ({code})"));
            self.out.pause(text, origin);
        }
        Ok(())
    }

    /// Handles a tool change (M6 or another T): the program pauses until it is mounted. Returns
    /// true if it pauses.
    fn change_tool(&mut self, block: &Block, line: &str, origin: Origin) -> bool {
        let named = block.number(b'T').filter(|tool| (0.0..1e6).contains(tool));
        let named = named.map(|tool| tool as u64);
        if named.is_some() && self.tool.is_none() {
            let steps = &self.out.plan.steps;
            self.toolless |= steps.iter().any(|step| step.action.marks());
        }
        // The first tool counts as mounted, unless something was drawn before it.
        let changes =
            named.is_some() && named != self.tool && (self.tool.is_some() || self.toolless);
        let pauses = changes || block.has(b'M', 6);
        let tool = named.or(self.tool);
        if pauses {
            let told = pause::pause_message(line, block).map(|told| format!(": {told}"));
            let told = told.unwrap_or_default();
            let text = match tool {
                Some(tool) => format!("mount tool {tool}{told}"),
                None => format!("change the tool{told}"),
            };
            self.out.pause(text, origin);
        }
        if let Some(tool) = named.filter(|_| named != self.tool) {
            if !self.tools.contains(&tool) && self.tools.len() < MAX_TOOLS {
                self.tools.push(tool);
            }
            let nth = self.tools.iter().position(|known| *known == tool);
            let part = Part {
                n: nth.unwrap_or(self.tools.len()) as u64 + 1,
                name: Some(format!("tool {tool}")),
                ..Part::default()
            };
            self.out.part(part, origin);
        }
        self.tool = tool;
        pauses
    }

    /// Makes an unnamed part of everything drawn before the first tool.
    fn begin_without_tool(&mut self) {
        let steps = &mut self.out.plan.steps;
        for step in steps.iter_mut() {
            if let Action::Part(part) = &mut step.action {
                part.n += 1;
            }
        }
        let part = Part {
            n: 1,
            ..Part::default()
        };
        let action = Action::Part(Box::new(part));
        let origin = steps.first().map_or(Origin::NONE, |step| step.origin);
        steps.insert(0, Step::new(action, origin));
    }

    fn note_codes(&mut self, block: &Block, origin: Origin) {
        for code in block.codes.iter().filter(|code| code.letter == b'M') {
            let message = message!("{name} is left out", name = code.to_string());
            self.notes.add(DiagnosticCode::LeftOut, origin, message);
        }
    }

    /// Refuses a letter without a number, except an axis to home.
    fn check_bare(&self, block: &Block) -> Result<(), SpanDiagnostic> {
        match &block.bare {
            Some((letter, range)) if !block.has(b'G', 28) => Err(SpanDiagnostic::new(
                range.clone(),
                message!("{letter} has no number", letter),
            )),
            _ => Ok(()),
        }
    }

    fn switches(&mut self, block: &Block, origin: Origin) -> Result<(), SpanDiagnostic> {
        let fan = block.has(b'M', 106) && self.survey.fan_lights();
        let power = block.power().or(block.number(b'S').filter(|_| fan));
        if let Some(power) = power.or(fan.then_some(self.range)) {
            if self.laser {
                self.check_power(power, block)?;
            }
            self.power = power;
        }
        let angle = if self.lifts {
            self.servo.follow(block)
        } else {
            None
        };
        for code in block.codes.iter().filter(|code| code.letter == b'M') {
            match code.tenths / 10 {
                0 | 1 | 2 | 6 | 30 => {}
                3 | 4 if self.laser => self.switch_laser_on(code),
                106 if self.laser && self.survey.fan_lights() => self.switch_laser_on(code),
                5 if self.laser => self.switch_laser_off(origin),
                107 if self.laser && self.survey.fan_lights() => self.switch_laser_off(origin),
                3..=5 | 280 | 300 if angle.is_some() => {}
                300 => {
                    let message =
                        message!("M300 (a tone, a servo that is switched off) is left out");
                    self.notes.add(DiagnosticCode::LeftOut, origin, message);
                }
                _ => {
                    let message = message!("{name} is left out", name = code.to_string());
                    self.notes.add(DiagnosticCode::LeftOut, origin, message);
                }
            }
        }
        match angle {
            Some(angle) => self.turn_servo(angle, block, origin),
            None => Ok(()),
        }
    }

    fn check_power(&self, power: f64, block: &Block) -> Result<(), SpanDiagnostic> {
        let range = block.range_of(b'S');
        if power < 0.0 {
            let message = message!("the power is S{power}, it must be 0 or more", power);
            return Err(SpanDiagnostic::new(range, message));
        }
        if power > self.range {
            let message = message!(
                "S{power} is above full power, which is S{full}",
                power,
                full = self.range
            );
            return Err(SpanDiagnostic::new(range, message).with(s_max()));
        }
        Ok(())
    }

    fn switch_laser_on(&mut self, code: &Code) {
        self.on = true;
        self.follows_speed = code.is(b'M', 4);
    }

    fn switch_laser_off(&mut self, origin: Origin) {
        self.on = false;
        self.out.laser_off(origin);
    }

    /// Moves the pen by its servo.
    fn turn_servo(
        &mut self,
        angle: f64,
        block: &Block,
        origin: Origin,
    ) -> Result<(), SpanDiagnostic> {
        if self.options.surface.is_none() {
            let message = message!("a servo moves the pen, but the surface height is unknown");
            return Err(SpanDiagnostic::new(block.range.clone(), message).remedy(
                (Setting::Surface, SettingValue::Any("Z")),
                "gives it, as z of the arm",
            ));
        }
        self.pen_is_down = self.down.contains(&angle);
        self.move_pen(origin);
        Ok(())
    }

    fn pause(&mut self, block: &Block, origin: Origin) -> Result<(), SpanDiagnostic> {
        let in_seconds = self.survey.pauses_in_seconds();
        let milliseconds = match (block.number(b'P'), block.number(b'S')) {
            (Some(seconds), _) if in_seconds => seconds * 1000.0,
            (Some(milliseconds), _) => milliseconds,
            (None, Some(seconds)) => seconds * 1000.0,
            (None, None) => {
                let message = message!("G4 without P or S is left out: it does not say how long");
                self.notes.add(DiagnosticCode::LeftOut, origin, message);
                return Ok(());
            }
        };
        if !(0.0..=f64::from(u32::MAX)).contains(&milliseconds) {
            let message = message!(
                "the pause is {milliseconds} ms, which is out of range",
                milliseconds
            );
            return Err(SpanDiagnostic::new(block.range.clone(), message));
        }
        if block.number(b'P').is_some() && in_seconds {
            let message = message!(
                "P of a pause (G4) counts seconds here, as in GRBL and LinuxCNC: the program has \
                fractions of it, or settings of such a controller ($)"
            );
            self.notes.add(DiagnosticCode::Assumed, origin, message);
        }
        if self.out.wait(milliseconds.round() as u32, origin) {
            let message = message!("the laser is off during pauses (G4): it would burn a hole");
            self.notes.add(DiagnosticCode::Power, origin, message);
        }
        Ok(())
    }

    /// Laser power of a line or arc, percent.
    pub(super) fn percent(&self) -> f64 {
        if self.on && self.laser {
            (self.power / self.range * 100.0).min(100.0)
        } else {
            0.0
        }
    }

    /// Finishes the plan at the end of the program or file.
    pub(super) fn finish(mut self) -> Result<(Plan, Vec<Diagnostic>), Diagnostic> {
        if let Some(origin) = self.begin.waiting {
            let message = message!("the program moves, but never gives X and Y");
            return Err(Diagnostic::new(origin, message).without_start());
        }
        // The last move may have left the tool held above its commanded height.
        self.lower();
        self.out.laser_off(Origin::NONE);
        if self.toolless {
            self.begin_without_tool();
        }
        Ok((self.out.plan, self.notes.into_diagnostics()))
    }
}
