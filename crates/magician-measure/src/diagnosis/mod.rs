//! What is wrong with an arm and its line, as data: the examination behind `magician doctor`. It moves nothing.

mod arm;
mod find;
mod line;

pub use line::try_queue;

use std::borrow::Cow;
use std::future::Future;

use magician::{Act, Action, Error, ErrorKind, Fence, Given, Remedy, Setting, Voice};

/// One thing that was looked at.
#[derive(Clone, Debug)]
pub struct Finding {
    /// What: `port`, `line`, `answer`, `back_to_back`, `index_law`, `left_space`, `current_index`, `window`, `identity`,
    /// `line_speed`, `turnaround`, `jitter`, `losses`, `alarms`, `homed`, `fence`, `queue`.
    pub check: &'static str,
    /// Whether it is as it should be; `None`: not looked at, or nothing to judge.
    pub ok: Option<bool>,
    /// The figure.
    pub value: Measured,
    /// Its unit.
    pub unit: Option<&'static str>,
    /// What was found, as a sentence.
    pub text: String,
    /// What to do, if there is something to do.
    pub advice: Option<Advice>,
}

/// The figure of a [`Finding`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Measured {
    /// None.
    Nothing,
    /// A text: a path, a version.
    Text(String),
    /// A number of things.
    Count(u64),
    /// A number.
    Number(f64),
    /// The arm's identity.
    Identity {
        /// Its name.
        name: String,
        /// Its serial number.
        serial_number: String,
        /// Version of its firmware: `3.6.14`.
        firmware: String,
        /// How long it has been on, s.
        uptime_s: u32,
    },
    /// The bounds of the tool's tip.
    Fence(Box<Fence>),
}

impl From<&str> for Measured {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Measured {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<u64> for Measured {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<u32> for Measured {
    fn from(count: u32) -> Self {
        Self::Count(count.into())
    }
}

impl From<usize> for Measured {
    fn from(count: usize) -> Self {
        Self::Count(count as u64)
    }
}

impl From<f64> for Measured {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

/// What to do, as a sentence in which a door says acts and options in its own words.
///
/// ```
/// use magician_measure::{Advice, Part};
/// use magician::{Action, Setting};
///
/// let advice = Advice::from([Part::from("choose one of "), Action::ListPorts.into(), " as ".into(), Setting::Port.into()]);
/// assert_eq!(advice.parts().len(), 4);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Advice(Vec<Part>);

/// A part of an [`Advice`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Part {
    /// Words.
    Text(Cow<'static, str>),
    /// Something to do.
    Act(Act),
    /// An option by its name.
    Setting(Setting),
}

impl Advice {
    /// The remedies of an error in one sentence. `None` if it has none.
    fn of(remedies: &[Remedy]) -> Option<Self> {
        let mut parts = Vec::new();
        for Remedy { act, effect } in remedies {
            if !parts.is_empty() {
                parts.push(Part::from("; "));
            }
            parts.push(Part::Act(act.clone()));
            if !effect.is_empty() {
                parts.push(format!(" {effect}").into());
            }
        }
        (!parts.is_empty()).then_some(Self(parts))
    }

    /// Its parts.
    #[must_use]
    pub fn parts(&self) -> &[Part] {
        &self.0
    }

    /// The sentence, in the words of a door.
    #[must_use]
    pub fn said(&self, voice: &dyn Voice) -> String {
        let said = |part: &Part| match part {
            Part::Text(text) => text.clone().into_owned(),
            Part::Act(act) => voice.act(act),
            Part::Setting(setting) => voice.setting(*setting),
        };
        self.0.iter().map(said).collect()
    }
}

impl<const N: usize> From<[Part; N]> for Advice {
    fn from(parts: [Part; N]) -> Self {
        Self(parts.into())
    }
}

impl From<&'static str> for Advice {
    fn from(text: &'static str) -> Self {
        Self::from([text.into()])
    }
}

impl From<&'static str> for Part {
    fn from(text: &'static str) -> Self {
        Self::Text(text.into())
    }
}

impl From<String> for Part {
    fn from(text: String) -> Self {
        Self::Text(text.into())
    }
}

impl From<Action> for Part {
    fn from(action: Action) -> Self {
        Self::Act(action.into())
    }
}

impl From<Setting> for Part {
    fn from(setting: Setting) -> Self {
        Self::Setting(setting)
    }
}

impl From<(Setting, Given)> for Part {
    fn from(given: (Setting, Given)) -> Self {
        Self::Act(given.into())
    }
}

/// A command of the operating system.
fn system(line: impl Into<Cow<'static, str>>) -> Part {
    Part::Act(Act::System(line.into()))
}

impl Finding {
    fn new(check: &'static str, ok: Option<bool>, text: impl Into<String>) -> Self {
        Self {
            check,
            ok,
            value: Measured::Nothing,
            unit: None,
            text: text.into(),
            advice: None,
        }
    }

    /// As it should be.
    #[must_use]
    pub fn good(check: &'static str, text: impl Into<String>) -> Self {
        Self::new(check, Some(true), text)
    }

    /// Not as it should be.
    #[must_use]
    pub fn bad(check: &'static str, text: impl Into<String>) -> Self {
        Self::new(check, Some(false), text)
    }

    /// Good or bad.
    fn judged(check: &'static str, ok: bool, text: impl Into<String>) -> Self {
        Self::new(check, Some(ok), text)
    }

    /// Worth knowing, or not looked at.
    #[must_use]
    pub fn note(check: &'static str, text: impl Into<String>) -> Self {
        Self::new(check, None, text)
    }

    /// With its figure.
    #[must_use]
    pub fn value(mut self, value: impl Into<Measured>) -> Self {
        self.value = value.into();
        self
    }

    /// With the unit of that.
    #[must_use]
    pub fn unit(mut self, unit: &'static str) -> Self {
        self.unit = Some(unit);
        self
    }

    fn advise(mut self, advice: impl Into<Advice>) -> Self {
        self.advice = Some(advice.into());
        self
    }

    /// Adds what to do, if it is not as it should be.
    #[must_use]
    pub fn cure(self, advice: &'static str) -> Self {
        match self.ok {
            Some(true) => self,
            _ => self.advise(advice),
        }
    }
}

/// Who hears of an examination while it goes on.
pub trait Attendant {
    /// Why it does not go on.
    type Failure: From<Error> + From<NoArm>;

    /// A finding, as it comes.
    ///
    /// # Errors
    /// The examination ends with it.
    fn found(&mut self, finding: &Finding) -> Result<(), Self::Failure>;

    /// Waits for something that may take seconds; `what` says for what, as a participle.
    fn attend<T>(
        &mut self,
        what: &'static str,
        work: impl Future<Output = T>,
    ) -> impl Future<Output = T> {
        let _ = what;
        work
    }

    /// Something is counted up to `total`: what hears how far it is.
    fn count(&mut self, what: &'static str, total: u64) -> impl FnMut(u64) {
        let _ = (what, total);
        |_| ()
    }
}

/// The examination ends, because there is no arm. The last finding says why.
#[derive(Debug)]
pub enum NoArm {
    /// It was found out why.
    Found(ErrorKind, String),
    /// An error of the driver says it, and what to do.
    Failed(Error),
}

impl From<Error> for NoArm {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}

/// All that was found.
#[derive(Clone, Debug, Default)]
pub struct Diagnosis {
    /// Where the arm is, once that is known.
    pub port: Option<String>,
    /// How many requests at once the line takes, as far as it is known.
    pub window: Option<usize>,
    /// The time from request to reply, ms.
    pub turnaround_ms: Option<f64>,
    /// The findings, in the order in which they came.
    pub findings: Vec<Finding>,
    /// Whether the last finding says why there is no arm.
    pub ended: bool,
}

impl Diagnosis {
    /// How many checks failed.
    #[must_use]
    pub fn wrong(&self) -> usize {
        let wrong = self
            .findings
            .iter()
            .filter(|finding| finding.ok == Some(false));
        wrong.count()
    }

    /// Notes a finding and tells it.
    ///
    /// # Errors
    /// Those of who is told.
    pub fn add<A: Attendant>(&mut self, finding: Finding, to: &mut A) -> Result<(), A::Failure> {
        to.found(&finding)?;
        self.findings.push(finding);
        Ok(())
    }

    /// A finding with which the search for an arm ends.
    fn end<A: Attendant>(&mut self, finding: Finding, kind: ErrorKind, to: &mut A) -> A::Failure {
        let message = finding.text.clone();
        if let Err(failure) = self.add(finding, to) {
            return failure;
        }
        self.ended = true;
        NoArm::Found(kind, message).into()
    }

    /// The same for an error of the driver, with what it says is to be done.
    fn end_with<A: Attendant>(
        &mut self,
        check: &'static str,
        error: Error,
        to: &mut A,
    ) -> A::Failure {
        let mut finding = Finding::bad(check, error.to_string());
        finding.advice = Advice::of(error.remedies());
        if let Err(failure) = self.add(finding, to) {
            return failure;
        }
        self.ended = true;
        NoArm::Failed(error).into()
    }
}
