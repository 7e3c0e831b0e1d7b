use std::ops::Range;

use magician_host::Remedy;

use crate::{Lack, Origin, Problem};

/// What cannot be read or followed in a program, by its bytes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Flaw {
    pub(super) range: Range<usize>,
    pub(super) message: String,
    pub(super) help: Option<&'static str>,
    pub(super) remedies: Vec<Remedy>,
    pub(super) lacks: Option<Lack>,
}

impl Flaw {
    pub(super) fn new(range: Range<usize>, message: impl Into<String>) -> Self {
        Self {
            range,
            message: message.into(),
            help: None,
            remedies: Vec::new(),
            lacks: None,
        }
    }

    /// At the place that its bytes have in the file.
    pub(super) fn into_problem(self, origin: Origin) -> Problem {
        let mut problem = Problem::new(origin, self.message).lacking(self.lacks);
        problem.help = self.help.map(str::to_owned);
        problem.remedies = self.remedies;
        problem
    }
}
