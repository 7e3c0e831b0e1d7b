//! Modal settings of a line: motion, units, distance mode, feed.

use magician_host::{SettingValue, message};
use magician_motion::ArmModel;

use super::arc::Plane;
use super::block::{Block, Code};
use super::machine::{Machine, Mode};
use super::modes::MM_PER_INCH;
use super::offsets::{Offsets, Setting};
use crate::formats::span::SpanDiagnostic;
use crate::{DiagnosticCode, Origin};

/// Fastest speed of the arm along a line, mm/s (model section 6).
pub(super) const MAX_SPEED: f64 = ArmModel::MAGICIAN.ceilings.linear_velocity;

impl Machine<'_> {
    pub(super) fn settings(&mut self, block: &Block, origin: Origin) -> Result<(), SpanDiagnostic> {
        let mut motions = 0;
        for code in block.codes.iter().filter(|code| code.letter == b'G') {
            let mode = match code.tenths {
                0 => Mode::Travel,
                10 => Mode::Line,
                20 => Mode::Arc(true),
                30 => Mode::Arc(false),
                50 => Mode::Curve { cubic: true },
                51 => Mode::Curve { cubic: false },
                800 => Mode::None,
                cycle @ (730 | 810..=830 | 850 | 860 | 890) if cycle % 10 == 0 => {
                    if self.mode != Mode::Cycle(cycle) {
                        self.cycle.begin();
                    }
                    Mode::Cycle(cycle)
                }
                _ => {
                    self.setting(code, block, origin)?;
                    continue;
                }
            };
            // Headers put G80 next to the motion that follows the cycle.
            motions += u32::from(mode != Mode::None);
            if motions > 1 {
                return Err(SpanDiagnostic::new(
                    code.range.clone(),
                    message!("two motions on one line"),
                ));
            }
            if mode != Mode::None || motions == 0 {
                self.mode = mode;
            }
        }
        if block.number(b'E').is_some() {
            let message = message!("E words are left out: nothing is extruded");
            self.notes.add(DiagnosticCode::LeftOut, origin, message);
        }
        if block.number(b'O').is_some() {
            let message = message!("program numbers (O) are left out");
            self.notes.add(DiagnosticCode::LeftOut, origin, message);
        }
        if let Some(feed) = block.number(b'F').filter(|_| !block.has(b'G', 28)) {
            self.set_feed(feed, block, origin)?;
        }
        Ok(())
    }

    fn setting(
        &mut self,
        code: &Code,
        block: &Block,
        origin: Origin,
    ) -> Result<(), SpanDiagnostic> {
        match code.tenths {
            170 => self.plane = Plane::Xy,
            180 => self.plane = Plane::Zx,
            190 => self.plane = Plane::Yz,
            200 => self.unit = MM_PER_INCH,
            210 => self.unit = 1.0,
            900 => self.relative = false,
            910 => self.relative = true,
            901 => self.absolute_centres = true,
            911 => self.absolute_centres = false,
            // Executed with the motion.
            40 | 280 | 282 | 300 | 520 | 530 | 920..=923 => {}
            540 | 550 | 560 | 570 | 580 | 590..=593 => self.select(code, origin),
            100 if Setting::of(block).is_some() => {}
            281 | 301 => {
                let message = message!(
                    "{code} is left out: positions stored in a controller are not used",
                    code = code.to_string()
                );
                self.notes.add(DiagnosticCode::LeftOut, origin, message);
            }
            // These codes select modes that are always in force here: no polar coordinates,
            // compensation, scaling, rotation or cycle; exact or continuous paths; feed per minute.
            150 | 400 | 490 | 500 | 610 | 611 | 640 | 690 | 940 | 970 => {}
            980 => self.cycle.retracts_to_start = true,
            990 => self.cycle.retracts_to_start = false,
            430 => {
                let message =
                    message!("the length of a tool (G43) is left out: coordinates are the arm's");
                self.notes.add(DiagnosticCode::LeftOut, origin, message);
            }
            960 => {
                let message = message!("G96 is left out: it is for a spindle");
                self.notes.add(DiagnosticCode::LeftOut, origin, message);
            }
            930 | 950 => {
                let message = message!(
                    "{code} is not supported: F must be a speed in mm or inches a minute (G94)",
                    code = code.to_string()
                );
                return Err(SpanDiagnostic::new(code.range.clone(), message));
            }
            _ => return self.other(code, block, origin),
        }
        Ok(())
    }

    /// Handles G54 to G59.3.
    fn select(&mut self, code: &Code, origin: Origin) {
        let system = Offsets::system_of(code.tenths).unwrap_or_default();
        if self.offsets.select(system) {
            let message = message!(
                "the zero of {code} is stored in a controller and unknown here: the machine's \
                    zero is used",
                code = code.to_string()
            );
            let help = message!("set it with G10 L2 in the file, or run the parts one by one");
            self.notes
                .add_with(DiagnosticCode::Assumed, origin, message, |note| {
                    note.help(help)
                });
        }
    }

    /// Handles an unknown G code. It is refused if it might move or change coordinates.
    fn other(&mut self, code: &Code, block: &Block, origin: Origin) -> Result<(), SpanDiagnostic> {
        let places = matches!(code.tenths, 160 | 410..=429 | 431 | 510 | 594..=599 | 680 | 100);
        let moves = matches!(
            code.tenths,
            50..=79 | 120 | 260 | 283..=389 | 730 | 740 | 760 | 810..=899
        );
        let harmless = matches!(code.tenths, 100 | 110) && !block.has_any(b"XYZLP");
        if (places || moves || block.has_any(b"XYZIJR")) && !harmless {
            let name = code.to_string();
            let message = if places {
                message!(
                    "{name} changes the coordinate system, which is not supported",
                    name
                )
            } else {
                message!("{name} may move the arm, which is not supported", name)
            };
            let help = message!("export the file with lines and arcs (G0 to G3)");
            return Err(SpanDiagnostic::new(code.range.clone(), message).help(help));
        }
        let message = message!("{name} is left out", name = code.to_string());
        self.notes.add(DiagnosticCode::LeftOut, origin, message);
        Ok(())
    }

    fn set_feed(&mut self, feed: f64, block: &Block, origin: Origin) -> Result<(), SpanDiagnostic> {
        if feed <= 0.0 {
            let message = message!("the speed is F{feed}, it must be above 0", feed);
            return Err(SpanDiagnostic::new(block.range_of(b'F'), message));
        }
        let speed = feed * self.unit / 60.0;
        if speed > MAX_SPEED {
            let message = message!(
                "speeds above 300 mm/s (F18000) are reduced to 300 mm/s: the arm is not faster"
            );
            self.notes.add(DiagnosticCode::Speed, origin, message);
        }
        self.feed = Some(speed);
        Ok(())
    }

    /// Returns the current feed. A laser always has one, because its speed determines how dark it
    /// burns.
    pub(super) fn feed_of_work(&mut self, origin: Origin) -> Option<f64> {
        if self.laser && self.feed.is_none() {
            let speed = self.options.laser_speed;
            let message = message!(
                "the program burns before it gives F: it begins at {speed} mm/s",
                speed
            );
            self.notes
                .add_with(DiagnosticCode::Speed, origin, message, |note| {
                    note.remedy(
                        (magician_host::Setting::Speed, SettingValue::Any("MM/S")),
                        "sets another speed",
                    )
                });
            self.feed = Some(speed);
        }
        self.feed
    }
}
