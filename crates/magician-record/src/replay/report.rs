//! Results of a replay.

use magician_protocol::{Direction, Field, FieldValue, FrameBuf, describe};

use magician_sim::HostInstant;

/// Result of a replay.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Number of replayed requests: complete frames.
    pub requests: u64,
    /// Number of answers compared with the recorded ones.
    pub answers: u64,
    /// Number of fields compared.
    pub fields: u64,
    /// Number of fields excluded from the comparison.
    pub ignored: u64,
    /// Number of requests that neither arm answered, or whose answer the trace ends too early for.
    pub unanswered: u64,
    /// Number of packets of unknown direction, which are left out.
    pub undirected: u64,
    /// Number of poses of a neighbouring period that were read within 5 ms of its boundary, the
    /// uncertainty of the times. At any other time such a pose is a difference
    /// ([`DifferenceKind::Period`]).
    pub late: u64,
    /// Distance of the recorded poses from those of the virtual arm.
    pub residue: Residue,
    /// Number of all differences.
    pub found: u64,
    /// Differences in order of time, the first [`Report::MOST`] of them.
    pub differences: Vec<Difference>,
}

impl Report {
    /// Most differences that are stored. It bounds memory when everything differs.
    pub const MOST: usize = 10_000;

    pub(super) fn add(&mut self, difference: Difference) {
        self.found += 1;
        if self.differences.len() < Self::MOST {
            self.differences.push(difference);
        }
    }
}

/// Distance of recorded poses from those of the virtual arm, whatever the tolerances. The closest
/// instant within 5 ms of the request counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residue {
    /// Number of poses compared.
    pub poses: u64,
    /// Number of poses that differ from the recorded one before.
    pub moved: u64,
    /// Largest deviation of x, y or z, mm.
    pub mm: f64,
    /// Largest deviation of r or a joint, deg.
    pub deg: f64,
    /// Time of the first pose that deviates by more than the tolerance of measurements.
    pub first_off: Option<HostInstant>,
}

impl Residue {
    /// Adds a pose with this deviation.
    pub(super) fn add(
        &mut self,
        [mm, deg]: [f64; 2],
        moved: bool,
        tolerance: f32,
        time: HostInstant,
    ) {
        if mm.max(deg) > f64::from(tolerance) {
            self.first_off.get_or_insert(time);
        }
        self.poses += 1;
        self.moved += u64::from(moved);
        self.mm = self.mm.max(mm);
        self.deg = self.deg.max(deg);
    }
}

/// Kind of a difference between two answers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum DifferenceKind {
    /// A field has another value, or is present in one answer only.
    Value(&'static Field),
    /// The pose is that of the virtual arm one period earlier or later.
    Period,
    /// The form differs: Ctrl (such as the error bit), or parameters that fit no layout.
    Form,
    /// A recorded answer, but none now.
    Silent,
    /// An answer now, but no recorded one.
    Answered,
    /// A recorded answer without a request.
    Unasked,
}

impl DifferenceKind {
    /// Name in JSON.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Value(_) => "value",
            Self::Period => "period",
            Self::Form => "form",
            Self::Silent => "silent",
            Self::Answered => "answered",
            Self::Unasked => "unasked",
        }
    }
}

/// A difference between two answers.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Time of the request (of the answer, if it belongs to none) on the host's clock, which showed
    /// 0 when the trace began.
    pub time: HostInstant,
    /// Name of the link.
    pub link: String,
    /// Id of the command.
    pub id: u8,
    /// Name of the command in the vendor's spelling; empty for an unknown id.
    pub command: &'static str,
    /// Kind of the difference.
    pub what: DifferenceKind,
    /// The recorded answer.
    pub recorded: Option<FrameBuf>,
    /// The virtual arm's answer.
    pub replayed: Option<FrameBuf>,
}

impl Difference {
    /// Largest difference of two measured values, in their unit; `None` if they are not floats.
    pub(super) fn distance(&self) -> Option<f32> {
        match (self.value(false)?, self.value(true)?) {
            (before @ FieldValue::Array(..), now @ FieldValue::Array(..)) => {
                let mut farthest: Option<f32> = None;
                for (before, now) in before.items().zip(now.items()) {
                    let apart = apart(&before, &now)?;
                    farthest = Some(farthest.map_or(apart, |far| far.max(apart)));
                }
                farthest
            }
            (before, now) => apart(&before, &now),
        }
    }

    /// Value of the field in the recorded answer, or in that of the virtual arm if `replayed`.
    /// `None` if the difference is not about a field, or the field is missing.
    #[must_use]
    pub fn value(&self, replayed: bool) -> Option<FieldValue<'_>> {
        let DifferenceKind::Value(field) = self.what else {
            return None;
        };
        let frame = if replayed {
            &self.replayed
        } else {
            &self.recorded
        };
        let description = describe(&frame.as_ref()?.frame(), Direction::Reply).ok()?;
        let mut values = description.values().ok()?;
        values.find_map(|(own, value)| (own.name == field.name).then_some(value))
    }

    /// Differing value in the recorded answer, or in that of the virtual arm if `replayed`: the
    /// field, or the whole frame if the difference is about that. `None` if it is missing.
    #[must_use]
    pub fn shown(&self, replayed: bool) -> Option<FieldValue<'_>> {
        let frame = if replayed {
            &self.replayed
        } else {
            &self.recorded
        };
        match self.what {
            DifferenceKind::Value(_) => self.value(replayed),
            _ => frame.as_ref().map(|frame| FieldValue::Bytes(frame.bytes())),
        }
    }
}

/// Absolute difference of two floats.
fn apart(before: &FieldValue<'_>, now: &FieldValue<'_>) -> Option<f32> {
    match (before, now) {
        (FieldValue::Float(before), FieldValue::Float(now)) => Some((before - now).abs()),
        _ => None,
    }
}

impl std::fmt::Display for Difference {
    /// Example: `GetPose x: recorded 200, now 199.4`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let value = |replayed| match self.value(replayed) {
            Some(value) => value.to_string(),
            None => "nothing".to_owned(),
        };
        match self.command {
            "" => write!(f, "unknown command {}", self.id)?,
            name => f.write_str(name)?,
        }
        match self.what {
            DifferenceKind::Value(field) => {
                let (name, recorded, now) = (field.name, value(false), value(true));
                write!(f, " {name}: recorded {recorded}, now {now}")
            }
            DifferenceKind::Form => {
                let bytes = |frame: &Option<FrameBuf>| match frame {
                    Some(frame) => format!("{:?}", frame.frame()),
                    None => "nothing".to_owned(),
                };
                let (recorded, now) = (bytes(&self.recorded), bytes(&self.replayed));
                write!(f, ": another form: recorded {recorded}, now {now}")
            }
            DifferenceKind::Period => {
                f.write_str(": recorded a period of the arm earlier or later")
            }
            DifferenceKind::Silent => f.write_str(": answered in the recording, not now"),
            DifferenceKind::Answered => f.write_str(": not answered in the recording, but now"),
            DifferenceKind::Unasked => {
                f.write_str(": the recorded reply belongs to no request in the trace")
            }
        }
    }
}
