//! Survey of a whole program: facts that must be known before its first line is converted.

use super::SourceLine;
use super::block::Block;
use super::interpreter::{Interpreter, LineOutcome};
use super::mill::Mill;
use super::modes::Modes;
use super::power::Powers;
use super::servo::Angles;
use super::{Dialect, GcodeOptions};

/// G codes whose axis words are not positions in program coordinates.
const NOT_POSITIONS: [u32; 6] = [10, 28, 30, 52, 53, 92];

/// Tool that a program is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Pen,
    Laser,
    /// A servo-lifted pen.
    Servo,
    /// A mill, whose program is drawn like a pen's.
    Mill,
}

/// Facts about the whole program.
#[derive(Clone, Debug)]
pub(super) struct Survey {
    /// True if M3, M4 or M5 occurs.
    pub(super) switches: bool,
    lights: bool,
    fan: bool,
    pub(super) powers: Powers,
    pub(super) mill: Mill,
    pub(super) angles: Angles,
    /// True if the program has E words: it is for a printer, so M106 is a fan and not a laser.
    extrudes: bool,
    /// True if M300 or M280 moves a servo.
    m300: bool,
    m280: bool,
    /// True if P of a pause (G4) counts seconds: it has a fraction, or the program belongs to such
    /// a controller.
    seconds: bool,
    /// Largest Z, mm.
    pub(super) highest_z: Option<f64>,
}

impl Survey {
    /// Runs through all lines in execution order. Errors are ignored here and reported by the
    /// second run.
    pub(super) fn of(mut interpreter: Interpreter<'_, '_>, options: &GcodeOptions) -> Self {
        let mut survey = Self {
            switches: false,
            lights: false,
            fan: false,
            powers: Powers::default(),
            mill: Mill::new(options.burns),
            angles: Angles::new(options.dialect == Dialect::Servo),
            extrudes: false,
            m300: false,
            m280: false,
            seconds: false,
            highest_z: None,
        };
        let mut block = Block::default();
        while let Ok(Some((line, stepped))) = interpreter.step(&mut block) {
            survey.powers.read(&line);
            survey.mill.read(line.text);
            let setting = line.text.trim_start().starts_with('$');
            survey.seconds |= setting || line.text.contains("LightBurn");
            if stepped == LineOutcome::Words {
                survey.examine(&block, &line, interpreter.modes());
            }
        }
        survey
    }

    /// Examines a line; `modes` is the state after it.
    fn examine(&mut self, block: &Block, line: &SourceLine<'_>, modes: &Modes) {
        if block.is_foreign() || block.is_empty() {
            return;
        }
        self.lights |= block.has(b'M', 3) || block.has(b'M', 4);
        self.switches |= self.lights || block.has(b'M', 5);
        self.fan |= block.has(b'M', 106);
        self.extrudes |= block.number(b'E').is_some();
        let pause = block.number(b'P').filter(|_| block.has(b'G', 4));
        self.seconds |= pause.is_some_and(|pause| pause.fract() != 0.0);
        self.powers.examine(block, line);
        let places = NOT_POSITIONS.iter().any(|code| block.has(b'G', *code));
        let marks = modes.feeds() && !places && block.has_any(b"XYIJ");
        self.mill.examine(block, line, modes, (places, marks));
        self.angles.examine(block, marks, line);
        self.m300 |= block.has(b'M', 300) && block.number(b'S').is_some_and(|s| s < 100.0);
        self.m280 |= block.has(b'M', 280) && block.number(b'S').is_some();
        let moves = block.number(b'Z').is_some() && !(modes.relative || places);
        // A drilling cycle retracts to R.
        let lifted = block
            .number(b'R')
            .map(|r| r * modes.unit + modes.offsets.zero()[2]);
        let z = if modes.drills() { lifted } else { modes.at[2] };
        if let Some(z) = z.filter(|_| moves) {
            self.highest_z = Some(self.highest_z.map_or(z, |highest| highest.max(z)));
        }
    }

    /// True if P of a pause counts seconds, as in GRBL and LinuxCNC, and not milliseconds.
    pub(super) fn pauses_in_seconds(&self) -> bool {
        self.seconds
    }

    /// Determines the tool.
    pub(super) fn kind(&self, options: &GcodeOptions) -> Kind {
        // M280 also moves the bed probe of a printer, and M300 is also a beep of a laser.
        let m280 = self.m280 && self.highest_z.is_none() && !self.extrudes;
        let servo = (self.m300 || m280) && !self.mill.has_laser();
        match options.dialect {
            Dialect::Laser => Kind::Laser,
            Dialect::Servo => Kind::Servo,
            _ if servo => Kind::Servo,
            Dialect::Pen => Kind::Pen,
            Dialect::Detect => {
                let power = self.powers.greatest.is_some() && !self.extrudes;
                if !(self.lights || self.fan_lights() || power) {
                    Kind::Pen
                } else if self.mill.sign().is_some() {
                    Kind::Mill
                } else {
                    Kind::Laser
                }
            }
        }
    }

    /// True if M106 is the laser. Next to M3 or M4 it is the air assist.
    pub(super) fn fan_lights(&self) -> bool {
        self.fan && !self.extrudes && !self.lights
    }
}
