use magician_protocol::{Direction, Field, FieldValue, FrameBuf, describe};

use magician_sim::HostInstant;

/// What a replay came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Requests that were sent again: whole frames.
    pub requests: u64,
    /// Answers that were compared with the recorded ones.
    pub answers: u64,
    /// Fields that were compared.
    pub fields: u64,
    /// Fields that were left out as told.
    pub ignored: u64,
    /// Requests that neither arm answered, or that the trace ends too early for.
    pub unanswered: u64,
    /// Packets whose direction the trace does not tell: left out.
    pub undirected: u64,
    /// Poses of the period beside that were asked for within 5 ms of its end: when a request came to the recorded arm is not known
    /// better. The pose of another period at any other time is a difference ([`What::Period`]).
    pub late: u64,
    /// How far the recorded poses are from those of the virtual arm.
    pub residue: Residue,
    /// How many differences there are in all.
    pub found: u64,
    /// The differences in the order of time, the first [`Report::MOST`] of them.
    pub differences: Vec<Difference>,
}

impl Report {
    /// Most differences that are kept.
    pub const MOST: usize = 10_000;

    pub(super) fn add(&mut self, difference: Difference) {
        self.found += 1;
        if self.differences.len() < Self::MOST {
            self.differences.push(difference);
        }
    }
}

/// How far recorded poses are from those of the virtual arm, whatever the tolerances: at the instant within 5 ms of the request at
/// which they are nearest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residue {
    /// Poses that were compared.
    pub poses: u64,
    /// Those that are another place than the recorded one before.
    pub moved: u64,
    /// Farthest that x, y or z was off, mm.
    pub mm: f64,
    /// Farthest that r or a joint was off, deg.
    pub deg: f64,
    /// When the first pose was asked for that was off by more than the tolerance of what is measured.
    pub first_off: Option<HostInstant>,
}

impl Residue {
    /// Takes in a pose that was off by so much.
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

/// In what an answer of the virtual arm is not the recorded one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum What {
    /// A field has another value, or is there in one of the two only.
    Value(&'static Field),
    /// The pose is the one that the virtual arm had a period earlier or later.
    Period,
    /// The form is another: Ctrl (the error bit, say), or parameters that fit no layout.
    Form,
    /// There is a recorded answer, and none now.
    Silent,
    /// There is an answer now, and no recorded one.
    Answered,
    /// The recorded answer belongs to no request.
    Unasked,
}

impl What {
    /// What it is called in JSON.
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

/// One difference.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// When the request was sent (the answer came, if it belongs to none): by the host's clock, which showed 0 when the trace began.
    pub time: HostInstant,
    /// Name of the link.
    pub link: String,
    /// Id of the command.
    pub id: u8,
    /// Name of the command, as the vendor writes it; empty for an unknown id.
    pub command: &'static str,
    /// In what.
    pub what: What,
    /// The recorded answer.
    pub recorded: Option<FrameBuf>,
    /// The virtual arm's answer.
    pub replayed: Option<FrameBuf>,
}

impl Difference {
    /// How far apart two measured values are, in their unit; the farthest of an array. `None` for what is no float.
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

    /// The field's value in the recorded answer; in the virtual arm's with `replayed`. `None` if it is not a field that
    /// differs, or not there.
    #[must_use]
    pub fn value(&self, replayed: bool) -> Option<FieldValue<'_>> {
        let What::Value(field) = self.what else {
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

    /// What differs in the recorded answer; in the virtual arm's with `replayed`: the field's value, or the bytes of the whole
    /// frame where it is about that. `None` if it is not there.
    #[must_use]
    pub fn shown(&self, replayed: bool) -> Option<FieldValue<'_>> {
        let frame = if replayed {
            &self.replayed
        } else {
            &self.recorded
        };
        match self.what {
            What::Value(_) => self.value(replayed),
            _ => frame.as_ref().map(|frame| FieldValue::Bytes(frame.bytes())),
        }
    }
}

/// How far apart two floats are.
fn apart(before: &FieldValue<'_>, now: &FieldValue<'_>) -> Option<f32> {
    match (before, now) {
        (FieldValue::Float(before), FieldValue::Float(now)) => Some((before - now).abs()),
        _ => None,
    }
}

impl std::fmt::Display for Difference {
    /// `GetPose x: recorded 200, now 199.4`.
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
            What::Value(field) => {
                let (name, recorded, now) = (field.name, value(false), value(true));
                write!(f, " {name}: recorded {recorded}, now {now}")
            }
            What::Form => {
                let bytes = |frame: &Option<FrameBuf>| match frame {
                    Some(frame) => format!("{:?}", frame.frame()),
                    None => "nothing".to_owned(),
                };
                let (recorded, now) = (bytes(&self.recorded), bytes(&self.replayed));
                write!(f, ": another form: recorded {recorded}, now {now}")
            }
            What::Period => f.write_str(": recorded a period of the arm earlier or later"),
            What::Silent => f.write_str(": answered in the recording, not now"),
            What::Answered => f.write_str(": not answered in the recording, but now"),
            What::Unasked => f.write_str(": the recorded reply belongs to no request in the trace"),
        }
    }
}
