//! The S word of full laser power.
//!
//! Programs rarely contain this value, so rules are tried in order: the caller's value, `$30`,
//! LightBurn's comments, a fan, the default. A guess errs towards weak burning: the larger the
//! value, the weaker an S burns.

use magician_host::{Remedy, Setting, SettingValue, message};

use super::Notes;
use super::SourceLine;
use super::block::Block;
use crate::{Diagnostic, DiagnosticCode, Origin};

/// Default S of full power, that of GRBL.
const DEFAULT_FULL_POWER: f64 = 1000.0;
/// S of full power of a fan, as in printer firmware.
const FAN_FULL_POWER: f64 = 255.0;

/// Facts about the powers in a program.
#[derive(Clone, Debug, Default)]
pub(super) struct Powers {
    /// `$30` before the laser is first switched on, with its place.
    setting: Option<(f64, Origin)>,
    /// The LightBurn cut that implies the largest full power.
    cut: Option<Cut>,
    /// Smallest percentage of the cuts still without an S, with its place.
    waiting: Option<(f64, Origin)>,
    /// Largest S.
    pub(super) greatest: Option<f64>,
    /// First S above 1000, with its place.
    beyond: Option<(f64, Origin)>,
    /// True once M3, M4 or M106 occurred.
    switched: bool,
}

#[derive(Clone, Copy, Debug)]
struct Cut {
    full: f64,
    percent: f64,
    s: f64,
    origin: Origin,
}

/// The S of full power, and the rule it comes from.
#[derive(Clone, Copy, Debug)]
pub(super) struct FullPower {
    pub(super) s: f64,
    rule: Rule,
}

#[derive(Clone, Copy, Debug)]
enum Rule {
    Given,
    Setting(Origin),
    Cut(Cut),
    Fan,
    Default,
}

impl Powers {
    /// Examines the text of a line, including comments and controller settings.
    pub(super) fn read(&mut self, line: &SourceLine<'_>) {
        let origin = || line.origin(&(0..line.text.trim_end().len()));
        // A setting after the first switch belongs to another job in the same file.
        if !self.switched
            && let Some(full) = setting(line.text, "$30").filter(|full| *full > 0.0)
        {
            self.setting = Some((full, origin()));
        }
        // Of several cuts before an S, the smallest percentage implies the largest full power, the
        // safe side.
        if let Some(percent) = cut(line.text).filter(|percent| *percent > 0.0)
            && self.waiting.is_none_or(|(least, _)| percent < least)
        {
            self.waiting = Some((percent, origin()));
        }
    }

    /// Examines the words of a line.
    pub(super) fn examine(&mut self, block: &Block, line: &SourceLine<'_>) {
        self.switched |= [3, 4, 106].iter().any(|number| block.has(b'M', *number));
        let fan = block.number(b'S').filter(|_| block.has(b'M', 106));
        let Some(s) = block.power().or(fan) else {
            return;
        };
        self.greatest = Some(self.greatest.map_or(s, |most| most.max(s)));
        if s > DEFAULT_FULL_POWER && self.beyond.is_none() {
            self.beyond = Some((s, line.origin(&block.range_of(b'S'))));
        }
        if s > 0.0
            && let Some((percent, origin)) = self.waiting.take()
        {
            let full = s * 100.0 / percent;
            if self.cut.is_none_or(|cut| full > cut.full) {
                self.cut = Some(Cut {
                    full,
                    percent,
                    s,
                    origin,
                });
            }
        }
    }

    /// Applies the first rule that fits.
    pub(super) fn full(&self, given: Option<f64>, fan: bool) -> Result<FullPower, Diagnostic> {
        let of = |s, rule| Ok(FullPower { s, rule });
        if let Some(s) = given {
            return if s.is_finite() && s > 0.0 {
                of(s, Rule::Given)
            } else {
                let message = message!("full power is S{s}, it must be above 0", s);
                Err(Diagnostic::of_file(message).with(s_max()))
            };
        }
        if let Some((s, origin)) = self.setting {
            return of(s, Rule::Setting(origin));
        }
        if let Some(cut) = self.cut {
            // Not below the default and the largest S, so that no burn exceeds 100 %.
            let greatest = self.greatest.unwrap_or(0.0);
            return of(
                cut.full.max(DEFAULT_FULL_POWER).max(greatest),
                Rule::Cut(cut),
            );
        }
        if fan {
            return of(FAN_FULL_POWER, Rule::Fan);
        }
        match self.beyond {
            None => of(DEFAULT_FULL_POWER, Rule::Default),
            Some((s, origin)) => {
                // The default would burn at more than 100 %, and no other value is safe.
                let message = message!("S{s} is above 1000, but the S of full power is unknown", s);
                let help =
                    message!("it is the S of the laser at full power, $30 of its controller");
                let pen = (Setting::Dialect, SettingValue::Word("pen"));
                Err(Diagnostic::new(origin, message)
                    .help(help)
                    .with(s_max())
                    .remedy(pen, "draws with a pen, if the file is for a mill"))
            }
        }
    }
}

impl FullPower {
    /// Adds a note about the rule.
    pub(super) fn note(&self, notes: &mut Notes) {
        let Self { s, rule } = *self;
        let says = |note: Diagnostic| note.with(s_max());
        match rule {
            Rule::Given => notes.add(
                DiagnosticCode::Power,
                Origin::NONE,
                message!("full power is S{s}, as given", s),
            ),
            Rule::Setting(origin) => {
                notes.add(
                    DiagnosticCode::Power,
                    origin,
                    message!("full power is S{s}, as $30 says", s),
                );
            }
            Rule::Cut(cut) => {
                let Cut {
                    percent,
                    s: at,
                    origin,
                    ..
                } = cut;
                let message = message!(
                    "full power is S{s}, by LightBurn's comments: {percent} % is S{at}",
                    s,
                    percent,
                    at
                );
                notes.add_with(DiagnosticCode::Power, origin, message, says);
            }
            Rule::Fan => {
                let message = message!(
                    "full power is S{s}, that of a fan: M106 switches the laser",
                    s
                );
                notes.add_with(DiagnosticCode::Power, Origin::NONE, message, says);
            }
            Rule::Default => {
                let message = message!(
                    "full power is assumed to be S{s}: the file does not give it, and no S is higher",
                    s
                );
                notes.add_with(DiagnosticCode::Power, Origin::NONE, message, says);
            }
        }
    }
}

/// Remedy for an unknown or wrong S of full power.
pub(super) fn s_max() -> Remedy {
    let given = (Setting::SMax, SettingValue::Any("N"));
    Remedy::new(given, "sets the S of full power")
}

/// Returns the value of a controller setting anywhere in a line.
pub(super) fn setting(text: &str, name: &str) -> Option<f64> {
    let found = text.match_indices(name).filter_map(|(at, _)| {
        let rest = text.get(at + name.len()..)?.trim_start();
        number(rest.strip_prefix('=')?.trim_start())
    });
    // The last assignment counts, as on the controller.
    found.last()
}

/// Returns the percentage in a comment of LightBurn: `; Cut @ 600 mm/min, 20% power`.
fn cut(text: &str) -> Option<f64> {
    let comment = text.get(text.find([';', '('])?..)?.to_ascii_lowercase();
    let (_, rest) = comment.split_once('@')?;
    let (speed, rest) = rest.split_once("mm/")?;
    number(speed.trim())?;
    let (_, rest) = rest.split_once(',')?;
    let (percent, rest) = rest.split_once('%')?;
    let is_power = rest.trim_start().starts_with("power");
    number(percent.trim()).filter(|_| is_power)
}

/// Parses the number at the start of a text.
fn number(text: &str) -> Option<f64> {
    let end = text.find(|sign: char| !(sign.is_ascii_digit() || sign == '.'));
    text.get(..end.unwrap_or(text.len()))?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_and_cuts_are_found_in_comments() {
        for (text, full) in [
            ("$30=1000", Some(1000.0)),
            ("; grbl: $30 = 255.0, $32=1", Some(255.0)),
            ("(max spindle: $30=12000)", Some(12000.0)),
            ("; $30 is not given", None),
            ("; $30=255 $30=1000", Some(1000.0)),
            ("; $300=7", None),
        ] {
            assert_eq!(setting(text, "$30"), full, "{text}");
        }
        for (text, percent) in [
            ("; Cut @ 600 mm/min, 20% power", Some(20.0)),
            ("; Scan @ 100 mm/sec, 7.5 % Power", Some(7.5)),
            ("(Cut @ 600 mm/min, 20% power)", Some(20.0)),
            ("; Cut @ 600 mm/min", None),
            ("; Cut @ fast mm/min, 20% power", None),
            ("; mail@home mm/min, 20% power", None),
            ("G1 X20 F600", None),
            ("; @ü mm/, % power", None),
        ] {
            assert_eq!(cut(text), percent, "{text}");
        }
    }
}
