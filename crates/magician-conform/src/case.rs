//! A case, and what it may not do unsaid.

use std::fmt;

use magician_protocol::{Deframer, Event, Row};
use magician_sim::fidelity::Assumption;
use magician_sim::scenario::Scenario;
use serde::{Deserialize, Serialize};

use crate::step::Step;

/// A case: what is done to an arm, what it must do, and the source of that.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its name, `chapter.words-with-hyphens`; unique.
    pub id: String,
    /// Its name with `*` for the words in which it differs from those written with it, a pattern that means all of them.
    pub pattern: String,
    /// What it shows, in a sentence.
    pub title: String,
    /// The source: a section of the document or of the model (`docs/reference/MODEL.md`), an erratum or a habit
    /// of hosts (both in `docs/reference/ERRATA.md`), a recorded frame (`vector`) or pose.
    pub source: String,
    /// How sure that is.
    pub confidence: Confidence,
    /// What it assumes of the arm: it fails on an arm of which one of these is not true.
    pub assumes: Vec<Assumption>,
    /// The alarm that it is about, if it is about one.
    pub alarm: Option<AlarmCase>,
    /// What state it begins from.
    pub begin: Begin,
    /// What lies around the virtual arm, if anything does.
    pub world: Option<Scenario>,
    /// Whether the arm or something on it moves.
    pub moves: bool,
    /// Whether it looks at what a clock that runs by itself blurs: a pose under way, an order between two instants.
    pub exact: bool,
    /// Why it is not for a real arm: what it could damage or unlearn.
    pub hurts: Option<String>,
    /// Why only an arm inside this program can show it.
    pub sim_only: Option<String>,
    /// Line of its file where its steps begin, from 1.
    pub line: usize,
    pub(crate) steps: Vec<Step>,
}

/// An alarm, as the case that shows it says in words: the page of alarms is made of these.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlarmCase {
    /// Its code.
    pub code: u8,
    /// How it arises.
    pub arises: String,
    /// How it goes.
    pub goes: String,
}

/// How sure a fact is.
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
    /// A choice, because no source says.
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

/// What state a case begins from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Begin {
    /// Queue stopped and empty, no alarms, the parameters of the reference model, and at J 0, 45, 45, 0 if the case
    /// moves.
    #[default]
    Ready,
    /// Switched on a moment ago.
    PowerUp,
}

impl Case {
    /// The chapter it belongs to: its name up to the first dot.
    #[must_use]
    pub fn chapter(&self) -> &str {
        self.id.split('.').next().unwrap_or_default()
    }

    /// The steps as they are written, a line each.
    pub fn steps(&self) -> impl Iterator<Item = &str> {
        self.steps.iter().map(|step| step.text.as_str())
    }

    /// What `--only` and `--skip` know it by besides its name.
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

    /// Whether a pattern means it: its chapter, a tag, or a pattern of its name in which `*` stands for anything.
    #[must_use]
    pub fn matches(&self, pattern: &str) -> bool {
        let confidence = self.confidence.to_string();
        self.chapter() == pattern
            || confidence == pattern
            || self.tags().contains(&pattern)
            || glob(pattern, &self.id)
    }

    /// Whether it moves an arm that is not virtual: one that could harm it, or is for virtual arms, is left out there.
    #[must_use]
    pub fn moves_an_arm(&self) -> bool {
        self.moves && self.hurts.is_none() && self.sim_only.is_none()
    }

    /// The commands that it sets or queues.
    fn orders(&self) -> Vec<&'static Row> {
        let mut rows = Vec::new();
        for step in &self.steps {
            let mut deframer = Deframer::new();
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

    /// Whether only an arm inside this program can be brought to where the case begins.
    fn inside_only(&self) -> bool {
        self.sim_only.is_some() || self.world.is_some() || self.begin == Begin::PowerUp
    }

    /// What the case does without saying so.
    pub(crate) fn undeclared(&self) -> Option<String> {
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

/// Whether a name fits a pattern in which `*` stands for anything.
fn glob(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((head, tail)) => name.strip_prefix(head).is_some_and(|rest| {
            (0..=rest.len())
                .filter_map(|at| rest.get(at..))
                .any(|rest| glob(tail, rest))
        }),
    }
}
