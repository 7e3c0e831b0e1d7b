//! Conformance case, and the properties it has to declare.

use std::fmt;

use magician_protocol::{Deframer, Event, Row};
use magician_sim::fidelity::Assumption;
use magician_sim::scenario::Scenario;
use serde::{Deserialize, Serialize};

use crate::step::Step;

/// Conformance case: steps on an arm, the expected results, and the source of the expectation.
#[derive(Clone, Debug)]
pub struct Case {
    /// Unique name, `chapter.words-with-hyphens`.
    pub id: String,
    /// Name with `*` for the words in which it differs from the cases written with it: a pattern
    /// that matches all of them.
    pub pattern: String,
    /// Statement that the case proves, as a sentence.
    pub title: String,
    /// Source: a section of the document or of the model (`docs/reference/MODEL.md`), an erratum or a habit
    /// of hosts (both in `docs/reference/ERRATA.md`), a recorded frame (`vector`) or pose.
    pub source: String,
    /// Confidence in the source.
    pub confidence: Confidence,
    /// Assumptions about the arm: the case fails if one of them is violated.
    pub assumes: Vec<Assumption>,
    /// Alarm that the case is about, if any.
    pub alarm: Option<AlarmCase>,
    /// Initial state.
    pub begin: Begin,
    /// World of the virtual arm, if any.
    pub world: Option<Scenario>,
    /// True if the arm or something on it moves.
    pub moves: bool,
    /// True if it examines what a free-running clock blurs: a pose in motion, the order of two
    /// instants.
    pub exact: bool,
    /// Reason why it is not for a real arm: damage, or lost settings.
    pub hurts: Option<String>,
    /// Reason why only an in-process arm can run it.
    pub sim_only: Option<String>,
    /// Line of its file where its steps begin, from 1.
    pub line: usize,
    pub(crate) steps: Vec<Step>,
}

/// Alarm of a case in words, for the documentation of alarms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlarmCase {
    /// Code of the alarm.
    pub code: u8,
    /// Cause of the alarm.
    pub arises: String,
    /// Condition that clears it.
    pub goes: String,
}

/// Confidence in a fact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum Confidence {
    /// Measured on real arms.
    M,
    /// The vendor's document or code for this arm.
    V,
    /// The vendor's code for the sibling arm.
    #[serde(rename = "VL")]
    Vl,
    /// Third-party code or text.
    T,
    /// A choice, because no source says it.
    G,
}

impl fmt::Display for Confidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::M => "M",
            Self::V => "V",
            Self::Vl => "VL",
            Self::T => "T",
            Self::G => "G",
        })
    }
}

/// Initial state of a case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Begin {
    /// Queue stopped and empty, no alarms, the parameters of the reference model, and at J 0, 45,
    /// 45, 0 if the case moves.
    #[default]
    Ready,
    /// Just after power-up.
    PowerUp,
}

impl Case {
    /// Returns its chapter: the name up to the first dot.
    #[must_use]
    pub fn chapter(&self) -> &str {
        self.id.split('.').next().unwrap_or_default()
    }

    /// Returns the steps as written, one line each.
    pub fn steps(&self) -> impl Iterator<Item = &str> {
        self.steps.iter().map(|step| step.text.as_str())
    }

    /// Returns its tags for `--only` and `--skip`.
    #[must_use]
    pub fn tags(&self) -> Vec<&'static str> {
        let tags = [
            (self.moves, "moves"),
            (self.exact, "exact"),
            (self.hurts.is_some(), "hurts"),
            (self.sim_only.is_some(), "sim-only"),
            (self.world.is_some(), "world"),
            (self.begin == Begin::PowerUp, "power-up"),
        ];
        tags.into_iter()
            .filter(|(has, _)| *has)
            .map(|(_, tag)| tag)
            .collect()
    }

    /// True if a pattern matches: its chapter, a tag, its confidence, or its name, where `*` stands
    /// for anything.
    #[must_use]
    pub fn matches(&self, pattern: &str) -> bool {
        let confidence = self.confidence.to_string();
        self.chapter() == pattern
            || confidence == pattern
            || self.tags().contains(&pattern)
            || glob(pattern, &self.id)
    }

    /// True if it moves a real arm. Cases that could harm one, or are for virtual arms, are skipped
    /// there.
    #[must_use]
    pub fn moves_an_arm(&self) -> bool {
        self.moves && self.hurts.is_none() && self.sim_only.is_none()
    }

    /// Returns the commands that it sets or queues.
    fn orders(&self) -> Vec<&'static Row> {
        let mut rows = Vec::new();
        for step in &self.steps {
            let mut deframer = Deframer::new();
            // Raw bytes are decoded as well: they may contain whole frames.
            let mut bytes = step.action.bytes();
            while let Some(event) = deframer.next(&mut bytes) {
                if let Event::Frame { frame, .. } = event
                    && let Some(row) = Row::with_id(frame.id()).filter(|row| row.sets(frame.ctrl()))
                {
                    rows.push(row);
                }
            }
        }
        rows
    }

    /// True if only an in-process arm can be brought to its initial state.
    fn inside_only(&self) -> bool {
        self.sim_only.is_some() || self.world.is_some() || self.begin == Begin::PowerUp
    }

    /// Returns the first action that the case performs without declaring it.
    pub(crate) fn undeclared(&self) -> Option<String> {
        // Skipped on a real arm anyway, so a dangerous command does no harm.
        let kept = self.hurts.is_some() || self.inside_only();
        for row in self.orders() {
            if row.dangerous && !kept {
                return Some(format!("{} is dangerous: say why it 'hurts'", row.set_name));
            }
            if row.effect.moves() && !self.moves {
                return Some(format!(
                    "{} moves the arm: say 'moves = true'",
                    row.set_name
                ));
            }
        }
        None
    }
}

/// True if a name matches a pattern in which `*` stands for anything.
fn glob(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((head, tail)) => name.strip_prefix(head).is_some_and(|rest| {
            // Every split is tried: names are short, and patterns have one or two stars.
            (0..=rest.len())
                .filter_map(|at| rest.get(at..))
                .any(|rest| glob(tail, rest))
        }),
    }
}
