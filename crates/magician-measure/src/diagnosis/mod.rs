//! Diagnosis of an arm and its line, as data: the examination behind `magician doctor`. Nothing
//! moves.
//!
//! An examination is a sequence of checks, each of which adds a [`Finding`] to a [`Diagnosis`] and
//! reports it to the [`DiagnosisObserver`]. A check that rules out an arm ends the sequence with
//! [`NoArm`].

mod arm;
mod find;
mod line;

pub use line::try_queue;

use std::borrow::Cow;
use std::future::Future;

use magician::{Act, Action, Error, ErrorKind, Fence, Remedy, Setting, SettingValue, Voice};

/// Result of one check.
#[derive(Clone, Debug)]
pub struct Finding {
    /// Name of the check: `port`, `line`, `answer`, `back_to_back`, `index_law`, `left_space`,
    /// `current_index`, `window`, `identity`, `line_speed`, `turnaround`, `jitter`, `losses`,
    /// `alarms`, `homed`, `fence`, `queue`.
    pub check: &'static str,
    /// True if everything is in order; `None` if it was not checked, or cannot be judged.
    pub ok: Option<bool>,
    /// Measured value.
    pub value: Measured,
    /// Unit of the value.
    pub unit: Option<&'static str>,
    /// Result as a sentence.
    pub text: String,
    /// Advice, if something can be done.
    pub advice: Option<Advice>,
}

/// Measured value of a [`Finding`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Measured {
    /// No value.
    Nothing,
    /// Text: a path, a version.
    Text(String),
    /// Number of items.
    Count(u64),
    /// Number.
    Number(f64),
    /// Identity of the arm.
    Identity {
        /// Name of the arm.
        name: String,
        /// Serial number of the arm.
        serial_number: String,
        /// Firmware version: `3.6.14`.
        firmware: String,
        /// Time since power-up, s.
        uptime_s: u32,
    },
    /// Fence of the arm.
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

/// Advice as a sentence. It contains actions and options, for which each front end has its own
/// wording.
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

/// Part of an [`Advice`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Part {
    /// Plain words.
    Text(Cow<'static, str>),
    /// Action.
    Act(Act),
    /// Option, by its name.
    Setting(Setting),
}

impl Advice {
    /// Joins the remedies of an error into one sentence; `None` if it has none.
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

    /// Returns the parts of the sentence.
    #[must_use]
    pub fn parts(&self) -> &[Part] {
        &self.0
    }

    /// Returns the sentence in the words of a front end.
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

impl From<(Setting, SettingValue)> for Part {
    fn from(given: (Setting, SettingValue)) -> Self {
        Self::Act(given.into())
    }
}

/// Returns a command of the operating system.
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

    /// Creates a finding that is in order.
    #[must_use]
    pub fn good(check: &'static str, text: impl Into<String>) -> Self {
        Self::new(check, Some(true), text)
    }

    /// Creates a finding of a fault.
    #[must_use]
    pub fn bad(check: &'static str, text: impl Into<String>) -> Self {
        Self::new(check, Some(false), text)
    }

    /// Creates a finding that is in order if `ok`.
    fn judged(check: &'static str, ok: bool, text: impl Into<String>) -> Self {
        Self::new(check, Some(ok), text)
    }

    /// Creates a finding without a judgement: information, or a skipped check.
    #[must_use]
    pub fn note(check: &'static str, text: impl Into<String>) -> Self {
        Self::new(check, None, text)
    }

    /// Sets the measured value.
    #[must_use]
    pub fn value(mut self, value: impl Into<Measured>) -> Self {
        self.value = value.into();
        self
    }

    /// Sets the unit of the value.
    #[must_use]
    pub fn unit(mut self, unit: &'static str) -> Self {
        self.unit = Some(unit);
        self
    }

    fn advise(mut self, advice: impl Into<Advice>) -> Self {
        self.advice = Some(advice.into());
        self
    }

    /// Sets advice, unless the finding is in order.
    #[must_use]
    pub fn cure(self, advice: &'static str) -> Self {
        match self.ok {
            // Advice for a check in order would only confuse.
            Some(true) => self,
            _ => self.advise(advice),
        }
    }
}

/// Observer of an examination in progress.
pub trait DiagnosisObserver {
    /// Error that ends the examination.
    type Failure: From<Error> + From<NoArm>;

    /// Called with each finding.
    ///
    /// # Errors
    /// An error ends the examination.
    fn found(&mut self, finding: &Finding) -> Result<(), Self::Failure>;

    /// Waits for work that may take seconds; `what` describes it as a participle, for a progress
    /// display.
    fn attend<T>(
        &mut self,
        what: &'static str,
        work: impl Future<Output = T>,
    ) -> impl Future<Output = T> {
        // Without a display the work simply runs.
        let _ = what;
        work
    }

    /// Returns a function that is called with the progress of a count up to `total`.
    fn count(&mut self, what: &'static str, total: u64) -> impl FnMut(u64) {
        let _ = (what, total);
        |_| ()
    }
}

/// End of an examination without an arm. The last finding gives the reason.
#[derive(Debug)]
pub enum NoArm {
    /// A check found the reason.
    FailedCheck(ErrorKind, String),
    /// The driver's error gives the reason, with its remedies.
    Failed(Error),
}

impl From<Error> for NoArm {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}

/// All findings of an examination.
#[derive(Clone, Debug, Default)]
pub struct Diagnosis {
    /// Target of the arm, once known.
    pub port: Option<String>,
    /// Number of requests the line takes at once, as far as known.
    pub window: Option<usize>,
    /// Time from request to reply, ms.
    pub turnaround_ms: Option<f64>,
    /// Findings in order.
    pub findings: Vec<Finding>,
    /// True if the last finding is the reason for having no arm.
    pub ended: bool,
}

impl Diagnosis {
    /// Returns the number of failed checks.
    #[must_use]
    pub fn wrong(&self) -> usize {
        let wrong = self
            .findings
            .iter()
            .filter(|finding| finding.ok == Some(false));
        wrong.count()
    }

    /// Adds a finding and reports it.
    ///
    /// # Errors
    /// Errors of the observer.
    pub fn add<A: DiagnosisObserver>(
        &mut self,
        finding: Finding,
        to: &mut A,
    ) -> Result<(), A::Failure> {
        to.found(&finding)?;
        self.findings.push(finding);
        Ok(())
    }

    /// Adds a finding that ends the search for an arm, and returns the error.
    fn end<A: DiagnosisObserver>(
        &mut self,
        finding: Finding,
        kind: ErrorKind,
        to: &mut A,
    ) -> A::Failure {
        let message = finding.text.clone();
        if let Err(failure) = self.add(finding, to) {
            return failure;
        }
        self.ended = true;
        NoArm::FailedCheck(kind, message).into()
    }

    /// Ends the search for an arm with an error of the driver, and its remedies as advice.
    fn end_with<A: DiagnosisObserver>(
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
