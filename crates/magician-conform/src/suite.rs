//! The cases: read from their files, and checked for what a case may not do unsaid.

use std::fmt;

use magician_protocol::{Deframer, Event, Row};
use magician_sim::scenario::Scenario;
use serde::{Deserialize, Serialize};
use toml::Spanned;

use crate::step::{self, Step};

/// A case: what is done to an arm, what it must do, and who says so.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its name, `chapter.words-with-hyphens`; unique.
    pub id: String,
    /// What it shows, in a sentence.
    pub title: String,
    /// Who says that an arm does so: a section of the document or of the model (`docs/MODEL.md`), an erratum or a habit
    /// of hosts (both in `docs/ERRATA.md`), a recorded frame (`vector`) or pose.
    pub source: String,
    /// How sure that is.
    pub confidence: Confidence,
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
    /// A choice, because nobody says.
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
    fn flaw(&self) -> Option<String> {
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

/// A file of cases that cannot be used: what is wrong and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}, line {line}: {message}")]
pub struct SuiteError {
    /// The file.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// What is wrong.
    pub message: String,
}

/// Cases in the order in which they are done.
#[derive(Clone, Debug, Default)]
pub struct Suite {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    case: Vec<Written>,
}

/// A case as its file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    id: Spanned<String>,
    title: String,
    source: String,
    confidence: Confidence,
    #[serde(default)]
    begin: Begin,
    #[serde(default)]
    moves: bool,
    #[serde(default)]
    exact: bool,
    hurts: Option<String>,
    sim_only: Option<String>,
    world: Option<Spanned<String>>,
    steps: Spanned<String>,
}

macro_rules! chapters {
    ($($name:literal)+) => {
        /// The built-in files: chapter and text.
        const FILES: &[(&str, &str)] = &[$(($name, include_str!(concat!("../cases/", $name, ".toml")))),+];
    };
}

chapters! {
    "framing" "info" "pose" "alarm" "home" "teach" "tool" "jog" "ptp" "cp" "arc" "wait" "trigger" "io"
    "calibration" "wifi" "lost_step" "queue" "rail" "offline"
}

impl Suite {
    /// The cases of this program.
    ///
    /// # Errors
    /// [`SuiteError`] never in a build whose tests pass.
    pub fn built_in() -> Result<Self, SuiteError> {
        let mut suite = Self::default();
        for (chapter, text) in FILES {
            suite.read(chapter, text)?;
        }
        Ok(suite)
    }

    /// Adds the cases of a chapter from the text of its file.
    ///
    /// # Errors
    /// [`SuiteError`] for text that is no TOML, a case without what it must have, a step that makes no sense, and a
    /// case that moves the arm or could harm it and does not say so.
    pub fn read(&mut self, chapter: &str, text: &str) -> Result<(), SuiteError> {
        let wrong = |line, message| SuiteError {
            file: format!("{chapter}.toml"),
            line,
            message,
        };
        let line_at = |at: usize| 1 + text.bytes().take(at).filter(|byte| *byte == b'\n').count();
        let file: File = toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            wrong(line_at(at), error.message().to_owned())
        })?;
        for written in file.case {
            let line = line_at(written.id.span().start);
            // The line break behind the opening quotes is not part of the text.
            let first = line_at(written.steps.span().start) + 1;
            let steps = step::read_all(written.steps.get_ref(), first)
                .map_err(|(line, message)| wrong(line, message))?;
            let world = match &written.world {
                None => None,
                Some(text) => Some(Scenario::from_toml(text.get_ref()).map_err(|error| {
                    let line = line_at(text.span().start);
                    wrong(
                        line,
                        format!("the world of '{}': {error}", written.id.get_ref()),
                    )
                })?),
            };
            let case = written.case(first, steps, world);
            let known = self.cases.iter().any(|other| other.id == case.id);
            let flaw = match case.chapter() {
                _ if known => Some(format!("there are two cases '{}'", case.id)),
                _ if case.steps.is_empty() => Some("the case has no steps".to_owned()),
                other if other != chapter => {
                    Some(format!("'{}' does not begin with '{chapter}.'", case.id))
                }
                _ => case.flaw(),
            };
            if let Some(flaw) = flaw {
                return Err(wrong(line, flaw));
            }
            self.cases.push(case);
        }
        Ok(())
    }

    /// The cases.
    #[must_use]
    pub fn cases(&self) -> &[Case] {
        &self.cases
    }

    /// The cases that one of the patterns in `only` means, or all if there are none, without those that one in `skip`
    /// means.
    #[must_use]
    pub fn select(&self, only: &[String], skip: &[String]) -> Vec<&Case> {
        let means =
            |case: &Case, patterns: &[String]| patterns.iter().any(|pattern| case.matches(pattern));
        self.cases
            .iter()
            .filter(|case| only.is_empty() || means(case, only))
            .filter(|case| !means(case, skip))
            .collect()
    }
}

impl Written {
    fn case(self, line: usize, steps: Vec<Step>, world: Option<Scenario>) -> Case {
        Case {
            id: self.id.into_inner(),
            title: self.title,
            source: self.source,
            confidence: self.confidence,
            begin: self.begin,
            world,
            moves: self.moves,
            exact: self.exact,
            hurts: self.hurts,
            sim_only: self.sim_only,
            line,
            steps,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> (usize, String) {
        let error = Suite::default().read("x", text).unwrap_err();
        (error.line, error.message)
    }

    fn case(more: &str, steps: &str) -> String {
        format!(
            "[[case]]\nid = \"x.a\"\ntitle = \"t\"\nsource = \"s\"\nconfidence = \"G\"\n{more}\nsteps = '''\n{steps}\n'''\n"
        )
    }

    #[test]
    fn a_wrong_step_is_told_with_its_line() {
        let (line, message) = error(&case("", "get Pose\n\n# remark\nget Pos"));
        assert_eq!(line, 11);
        assert!(message.contains("no command 'Pos'"), "{message}");
    }

    #[test]
    fn a_case_says_what_it_does() {
        let (line, message) = error(&case("", "queue PTPCmd ptp_mode=1 x=200 y=0 z=0 r=0"));
        assert_eq!(line, 2);
        assert!(message.contains("moves = true"), "{message}");
        // The same in bytes, behind another frame.
        let bytes = "send AA AA 02 0A 00 F6 AA AA 06 1F 01 00 00 00 00 E0";
        assert!(error(&case("", bytes)).1.contains("moves = true"));
        let (_, message) = error(&case("", "set WIFISSID ssid=home"));
        assert!(message.contains("hurts"), "{message}");
        let mut suite = Suite::default();
        let right = case(
            "hurts = \"it forgets its network\"",
            "set WIFISSID ssid=home",
        );
        suite.read("x", &right).unwrap();
        assert!(
            suite
                .read("x", &right)
                .unwrap_err()
                .message
                .contains("two cases")
        );
    }

    #[test]
    fn wrong_toml_is_told_with_its_line() {
        assert_eq!(error("[[case]]\nid = \"x.a\"\ntitel = \"t\"\n").0, 3);
        assert!(error(&case("", "")).1.contains("no steps"));
        let other = case("", "silence").replace("x.a", "y.a");
        assert!(error(&other).1.contains("does not begin"));
    }

    #[test]
    fn patterns_mean_names_chapters_and_tags() {
        let mut suite = Suite::default();
        suite.read("x", &case("moves = true", "silence")).unwrap();
        for pattern in ["x", "x.a", "x.*", "*a", "*", "moves", "G"] {
            assert_eq!(
                suite.select(&[pattern.to_owned()], &[]).len(),
                1,
                "{pattern}"
            );
            assert_eq!(
                suite.select(&[], &[pattern.to_owned()]).len(),
                0,
                "{pattern}"
            );
        }
        for pattern in ["y", "x.b", "y*", "exact", "x.a.*", ""] {
            assert_eq!(
                suite.select(&[pattern.to_owned()], &[]).len(),
                0,
                "{pattern}"
            );
        }
    }
}
