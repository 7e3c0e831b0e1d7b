use std::ops::Range;

use crate::{Lack, Origin, Problem};

/// What cannot be read or followed in a program, by its bytes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Flaw {
    pub(super) range: Range<usize>,
    pub(super) message: String,
    pub(super) help: Option<&'static str>,
    pub(super) lacks: Option<Lack>,
}

impl Flaw {
    pub(super) fn new(range: Range<usize>, message: impl Into<String>) -> Self {
        Self {
            range,
            message: message.into(),
            help: None,
            lacks: None,
        }
    }

    /// At the place that its bytes have in the file.
    pub(super) fn into_problem(self, origin: Origin) -> Problem {
        let problem = Problem::new(origin, self.message).lacking(self.lacks);
        match self.help {
            Some(help) => problem.help(help),
            None => problem,
        }
    }
}
