//! Suite of cases: reading the files, and checking that each case declares what it does.

use std::collections::BTreeMap;

use magician_sim::fidelity::Assumption;
use magician_sim::scenario::Scenario;
use serde::Deserialize;
use toml::Spanned;

use crate::case::{AlarmCase, Begin, Case, Confidence};
use crate::{step, words};

/// Error in a file of cases, with its location.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}, line {line}: {message}")]
pub struct SuiteError {
    /// File name.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Description.
    pub message: String,
}

/// Cases in order of execution.
#[derive(Clone, Debug, Default)]
pub struct Suite {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    case: Vec<CaseTable>,
}

/// Case as written; with `each` it stands for several that differ in some words.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseTable {
    id: Spanned<String>,
    title: String,
    source: String,
    confidence: Confidence,
    #[serde(default)]
    assumes: Vec<String>,
    alarm: Option<AlarmTable>,
    #[serde(default)]
    begin: Begin,
    #[serde(default)]
    moves: bool,
    #[serde(default)]
    exact: bool,
    hurts: Option<String>,
    sim_only: Option<String>,
    world: Option<Spanned<String>>,
    #[serde(default)]
    each: Vec<BTreeMap<String, toml::Value>>,
    steps: Spanned<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AlarmTable {
    code: String,
    arises: String,
    goes: String,
}

macro_rules! chapters {
    ($($name:literal)+) => {
        /// Built-in files: chapter and text.
        const FILES: &[(&str, &str)] = &[$(($name, include_str!(concat!("../cases/", $name, ".toml")))),+];
    };
}

chapters! {
    "framing" "info" "pose" "alarm" "home" "teach" "tool" "jog" "ptp" "cp" "arc" "wait" "trigger" "io"
    "calibration" "wifi" "lost_step" "queue" "rail" "offline"
}

impl Suite {
    /// Returns the built-in cases.
    ///
    /// # Errors
    /// [`SuiteError`], but never in a build whose tests pass.
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
    /// [`SuiteError`] for invalid TOML, a missing key, an invalid step, and a case that moves or
    /// could harm the arm without declaring it.
    pub fn read(&mut self, chapter: &str, text: &str) -> Result<(), SuiteError> {
        let error_at = |line, message| SuiteError {
            file: format!("{chapter}.toml"),
            line,
            message,
        };
        let line_at = |at: usize| 1 + text.bytes().take(at).filter(|byte| *byte == b'\n').count();
        let file: File = toml::from_str(text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            error_at(line_at(at), error.message().to_owned())
        })?;
        for table in file.case {
            let no_values = [BTreeMap::new()];
            let each = match table.each.as_slice() {
                // Without `each` there is one case, with no values to fill in.
                [] => &no_values,
                each => each,
            };
            for values in each {
                let line = line_at(table.id.span().start);
                // The line break after the opening quotes is not part of the text.
                let first = line_at(table.steps.span().start) + 1;
                let world = table.world.as_ref().map(|text| line_at(text.span().start));
                let case = (table.case(values, first)).map_err(|error| match (error, world) {
                    (CaseError::Step(line, message), _) => error_at(line, message),
                    (CaseError::World(message), Some(line)) => error_at(line, message),
                    (CaseError::World(message) | CaseError::Case(message), _) => {
                        error_at(line, message)
                    }
                })?;
                if let Some(reason) = self.rejection(chapter, &case) {
                    return Err(error_at(line, reason));
                }
                self.cases.push(case);
            }
        }
        Ok(())
    }

    /// Returns the reason why a case cannot be added.
    fn rejection(&self, chapter: &str, case: &Case) -> Option<String> {
        let known = self.cases.iter().any(|other| other.id == case.id);
        match case.chapter() {
            // Checked first, because all other errors name the case by its id.
            _ if known => Some(format!("two cases are called '{}'", case.id)),
            _ if case.id.contains('{') => Some(format!("a word of '{}' has no value", case.id)),
            _ if case.steps.is_empty() => Some("the case has no steps".to_owned()),
            other if other != chapter => {
                Some(format!("'{}' does not begin with '{chapter}.'", case.id))
            }
            _ => case.undeclared(),
        }
    }

    /// Returns all cases.
    #[must_use]
    pub fn cases(&self) -> &[Case] {
        &self.cases
    }

    /// Returns the first of these patterns that matches no case.
    pub fn unmatched<'p>(&self, patterns: impl IntoIterator<Item = &'p String>) -> Option<&'p str> {
        let mut patterns = patterns.into_iter();
        let pattern = patterns.find(|pattern| !self.cases.iter().any(|case| case.matches(pattern)));
        pattern.map(String::as_str)
    }

    /// Returns the cases that match a pattern in `only` (all if it is empty), except cases that
    /// match one in `skip`.
    #[must_use]
    pub fn select(&self, only: &[String], skip: &[String]) -> Vec<&Case> {
        let matches_any =
            |case: &Case, patterns: &[String]| patterns.iter().any(|pattern| case.matches(pattern));
        self.cases
            .iter()
            .filter(|case| only.is_empty() || matches_any(case, only))
            .filter(|case| !matches_any(case, skip))
            .collect()
    }
}

/// Error in a case, with its location if known.
enum CaseError {
    Case(String),
    World(String),
    Step(usize, String),
}

impl CaseTable {
    /// Returns the case with these values for the words in braces; `first` is the line of its first
    /// step.
    fn case(
        &self,
        values: &BTreeMap<String, toml::Value>,
        first: usize,
    ) -> Result<Case, CaseError> {
        let fill = |text: &String| fill(text, values);
        let steps = step::read_all(&fill(self.steps.get_ref()), first)
            .map_err(|(line, message)| CaseError::Step(line, message))?;
        let id = fill(self.id.get_ref());
        let world = (self.world.as_ref())
            .map(|text| Scenario::from_toml(&fill(text.get_ref())))
            .transpose()
            .map_err(|error| CaseError::World(format!("the world of '{id}': {error}")))?;
        let named = |name: &String| {
            let name = fill(name);
            let found = Assumption::ALL.iter().find(|known| known.name() == name);
            found
                .copied()
                .ok_or_else(|| CaseError::Case(format!("no assumption '{name}'")))
        };
        let assumes = self.assumes.iter().map(named).collect::<Result<_, _>>()?;
        let alarm = |alarm: &AlarmTable| {
            Ok::<_, CaseError>(AlarmCase {
                code: words::code(&fill(&alarm.code)).map_err(CaseError::Case)?,
                arises: fill(&alarm.arises),
                goes: fill(&alarm.goes),
            })
        };
        // The name with `*` for each value matches all cases of the table.
        let wildcards = values.keys().map(|key| (key.clone(), "*".into())).collect();
        Ok(Case {
            pattern: self::fill(self.id.get_ref(), &wildcards),
            id,
            title: fill(&self.title),
            source: fill(&self.source),
            confidence: self.confidence,
            assumes,
            alarm: self.alarm.as_ref().map(alarm).transpose()?,
            begin: self.begin,
            world,
            moves: self.moves,
            exact: self.exact,
            hurts: self.hurts.clone(),
            sim_only: self.sim_only.clone(),
            line: first,
            steps,
        })
    }
}

/// Replaces the words in braces by values.
fn fill(text: &str, values: &BTreeMap<String, toml::Value>) -> String {
    let mut text = text.to_owned();
    for (key, value) in values {
        let value = value
            .as_str()
            .map_or_else(|| value.to_string(), str::to_owned);
        text = text.replace(&format!("{{{key}}}"), &value);
    }
    text
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
    fn wrong_step_is_reported_with_its_line() {
        let (line, message) = error(&case("", "get Pose\n\n# remark\nget Pos"));
        assert_eq!(line, 11);
        assert!(message.contains("no command 'Pos'"), "{message}");
    }

    #[test]
    fn undeclared_motion_or_harm_is_an_error() {
        let (line, message) = error(&case("", "queue PTPCmd ptp_mode=1 x=200 y=0 z=0 r=0"));
        assert_eq!(line, 2);
        assert!(message.contains("moves = true"), "{message}");
        // The same command as raw bytes, after another frame.
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
    fn wrong_toml_is_reported_with_its_line() {
        assert_eq!(error("[[case]]\nid = \"x.a\"\ntitel = \"t\"\n").0, 3);
        assert!(error(&case("", "")).1.contains("no steps"));
        let other = case("", "silence").replace("x.a", "y.a");
        assert!(error(&other).1.contains("does not begin"));
    }

    #[test]
    fn patterns_match_names_chapters_and_tags() {
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
