//! The file of a class: who the pupils are, and by which rules they take turns.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use magician::{ArmModel, Fence};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::{ClassError, wrong};
use crate::control::TurnRules;
use crate::secret::same_secret;

/// Signs of codes that are made: none that is taken for another.
const SIGNS: &[u8] = b"23456789ABCDEFGHJKMNPQRSTUVWXYZ";
/// Pupils of a class, at most.
const PUPILS: usize = 60;

/// A pupil.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pupil {
    /// Under which results are kept.
    pub name: String,
    /// The group, if the class has groups.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// What the pupil signs in with: 4 to 6 letters and digits.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub code: String,
}

/// What holds for all pupils.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ClassRules {
    /// Length of a turn, s; 0: without end.
    pub turn_s: u32,
    /// How long an arm waits for a pupil who is not there, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grace_s: Option<u32>,
    /// Whether a job that runs at the end of a turn goes on to its end.
    pub finish_job: bool,
    /// Top speed of the tip, percent of the fastest that the arm has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// A fence, with the members of `arm.fence`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fence: Option<Map<String, Value>>,
    /// How far the clock on the wall is from UTC, such as `+01:00`, where the schedule does not say it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<String>,
    /// The arms that pupils may have; all of them unless given.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub arms: Vec<String>,
    /// The teacher's PIN, six digits: who gives it at the station's machine is a teacher.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub pin: String,
}

/// A class.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ClassFile {
    /// The rules.
    pub class: ClassRules,
    /// The arms of groups.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub groups: BTreeMap<String, Vec<String>>,
    /// The pupils.
    pub pupil: Vec<Pupil>,
}

impl ClassFile {
    /// Reads one.
    ///
    /// # Errors
    /// What is wrong with it, with its line where that is known.
    pub fn parse(text: &str) -> Result<Self, ClassError> {
        let file: Self = toml::from_str(text).map_err(|error| ClassError(error.to_string()))?;
        let mut names = BTreeSet::new();
        if file.pupil.len() > PUPILS {
            return wrong(format!("a class has {PUPILS} pupils at most"));
        }
        // JSON has no such numbers: they come as null.
        if file
            .class
            .fence
            .as_ref()
            .is_some_and(|fence| fence.values().any(has_null))
        {
            return wrong("[class] fence must have finite numbers");
        }
        for pupil in &file.pupil {
            let name = &pupil.name;
            if name == "teacher" || pupil.group.as_deref() == Some("teacher") {
                return wrong(
                    "`teacher` is whoever teaches in a schedule: no pupil or group is called so",
                );
            }
            let fine = name.trim() == name
                && (1..=40).contains(&name.chars().count())
                && !name.chars().any(char::is_control);
            if !fine {
                return wrong(format!(
                    "`{}` is no name for a pupil: 1 to 40 characters, with no blank first or last",
                    magician_protocol::visible(name)
                ));
            }
            if !names.insert(name.to_lowercase()) {
                return wrong(format!("two pupils are called {name}: add a letter to one"));
            }
            let code = pupil.code.as_bytes();
            let sign = |byte: &u8| byte.is_ascii_alphanumeric();
            if !code.is_empty() && (!(4..=6).contains(&code.len()) || !code.iter().all(sign)) {
                return wrong(format!(
                    "the code of {name} must be 4 to 6 letters or digits; leave it out to have one made"
                ));
            }
        }
        let pin = &file.class.pin;
        if !pin.is_empty() && !is_pin(pin) {
            return wrong("[class] pin must be six digits; leave it out to have one made");
        }
        if let Some(text) = &file.class.offset
            && super::offset_of(text).is_none()
        {
            return wrong("[class] offset must be like \"+01:00\"");
        }
        file.fence()?;
        Ok(file)
    }

    /// A class of these pupils at these arms, all arms if there are none, with turns of this length, s, and this offset from
    /// UTC. Other rules, and what is not given, are those of the class `before`.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn of_names(
        names: &[&str],
        arms: &[&str],
        turn_s: Option<u32>,
        offset: Option<&str>,
        before: Option<&Self>,
    ) -> Result<Self, ClassError> {
        let mut class = before.map(|file| file.class.clone()).unwrap_or_default();
        class.turn_s = turn_s.unwrap_or(class.turn_s);
        class.offset = offset.map(str::to_owned).or(class.offset);
        class.arms = arms.iter().map(|arm| (*arm).to_owned()).collect();
        let pupil = |name: &&str| Pupil {
            name: name.trim().to_owned(),
            group: None,
            code: String::new(),
        };
        let file = Self {
            class,
            groups: BTreeMap::new(),
            pupil: names.iter().map(pupil).collect(),
        };
        Self::parse(&file.to_text())
    }

    /// Checks that its arms, and those of its groups, are there.
    ///
    /// # Errors
    /// One that `place` has not.
    pub fn check_arms(&self, place: &str, has: impl Fn(&str) -> bool) -> Result<(), ClassError> {
        if let Some(arm) = self.class.arms.iter().find(|arm| !has(arm)) {
            return wrong(format!("[class] has the arm {arm}, which {place} has not"));
        }
        for (group, arms) in &self.groups {
            if let Some(arm) = arms.iter().find(|arm| !has(arm)) {
                return wrong(format!(
                    "the group {group} has the arm {arm}, which {place} has not"
                ));
            }
        }
        Ok(())
    }

    /// Gives pupils the codes that they have in the class `before`, and the class its PIN, whatever this file says: an old file
    /// brings no old code back. With `uses_own` those of this file count, if it has some. The names of the pupils whose code
    /// in this file does not count.
    pub fn keep_codes(&mut self, before: &Self, uses_own: bool) -> Vec<String> {
        let is_kept = |own: &str| !uses_own || own.is_empty();
        if is_kept(&self.class.pin) && !before.class.pin.is_empty() {
            self.class.pin.clone_from(&before.class.pin);
        }
        let mut kept = Vec::new();
        for pupil in &mut self.pupil {
            let Some(known) = before.named(&pupil.name) else {
                continue;
            };
            if known.code.is_empty() || !is_kept(&pupil.code) {
                continue;
            }
            let differs = !pupil.code.eq_ignore_ascii_case(&known.code);
            if differs && !pupil.code.is_empty() {
                kept.push(pupil.name.clone());
            }
            pupil.code.clone_from(&known.code);
        }
        kept
    }

    /// Whether pupils may have an arm.
    pub(crate) fn has_arm(&self, arm: &str) -> bool {
        let arms = &self.class.arms;
        arms.is_empty() || arms.iter().any(|known| known == arm)
    }

    /// Takes the codes of these pupils, or of all.
    ///
    /// # Errors
    /// A name that is no pupil's.
    pub fn drop_codes(&mut self, names: Option<&[&str]>) -> Result<(), ClassError> {
        let unknown = { names.into_iter().flatten() }.find(|name| self.named(name).is_none());
        if let Some(name) = unknown {
            return wrong(format!("there is no pupil {name}"));
        }
        let meant = |name: &str| names.is_none_or(|names| names.contains(&name));
        for pupil in self.pupil.iter_mut().filter(|pupil| meant(&pupil.name)) {
            pupil.code.clear();
        }
        Ok(())
    }

    /// The file.
    #[must_use]
    pub fn to_text(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// Makes codes for those who have none, each of another one, and the PIN if there is none: numbers that nobody can guess
    /// come from `random`.
    pub fn make_codes(&mut self, mut random: impl FnMut() -> u64) {
        if self.class.pin.is_empty() {
            self.class.pin = format!("{:06}", random() % 1_000_000);
        }
        let mut taken: BTreeSet<_> = self.pupil.iter().map(|pupil| pupil.code.clone()).collect();
        for pupil in self.pupil.iter_mut().filter(|pupil| pupil.code.is_empty()) {
            while taken.contains(&pupil.code) {
                let mut number = random();
                pupil.code = (0..6)
                    .map(|_| {
                        let sign = SIGNS[(number % SIGNS.len() as u64) as usize];
                        number /= SIGNS.len() as u64;
                        char::from(sign)
                    })
                    .collect();
            }
            taken.insert(pupil.code.clone());
        }
    }

    /// The pupil of this name and code, whether letters are large or small. All codes are looked at, in the same time.
    pub(crate) fn signs_in(&self, name: &str, code: &str) -> Option<&Pupil> {
        let code = code.to_uppercase();
        let mut found = None;
        for pupil in &self.pupil {
            let good = same_secret(&pupil.code.to_uppercase(), &code) && !code.is_empty();
            if good & (pupil.name.to_lowercase() == name.to_lowercase()) {
                found = Some(pupil);
            }
        }
        found
    }

    pub(crate) fn named(&self, name: &str) -> Option<&Pupil> {
        self.pupil.iter().find(|pupil| pupil.name == name)
    }

    /// The pupil of this name, in any case.
    pub(crate) fn called(&self, name: &str) -> Option<&Pupil> {
        let name = name.to_lowercase();
        { self.pupil.iter() }.find(|pupil| pupil.name.to_lowercase() == name)
    }

    /// Whether a pupil has this name, which is in small letters.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.pupil
            .iter()
            .any(|pupil| pupil.name.to_lowercase() == name)
    }

    pub(crate) fn turns(&self) -> TurnRules {
        let seconds = |seconds| Duration::from_secs(u64::from(seconds));
        TurnRules {
            length: (self.class.turn_s > 0).then(|| seconds(self.class.turn_s)),
            grace: seconds(self.class.grace_s.unwrap_or(30)),
            finish_job: self.class.finish_job,
        }
    }

    /// What bounds the arms of pupils.
    pub(crate) fn fence(&self) -> Result<Option<Fence>, ClassError> {
        let change = self.class.fence.clone().map(Value::Object);
        let fence = change.map(|change| crate::fence::changed(None, &change));
        let fence = fence.transpose();
        let fence =
            fence.map_err(|error| ClassError(format!("[class] fence: {}", error.message)))?;
        let fence = fence.flatten();
        let Some(percent) = self.class.speed else {
            return Ok(fence);
        };
        if !(1.0..=100.0).contains(&percent) {
            return wrong("[class] speed must be a number from 1 to 100, percent");
        }
        let top = ArmModel::MAGICIAN.ceilings.linear_velocity * percent / 100.0;
        let bounds = Fence::default().with_top_speed(top);
        let bounds = bounds.map_err(|error| ClassError(error.to_string()))?;
        Ok(Some(crate::fence::stricter(
            fence.unwrap_or_default(),
            &bounds,
        )))
    }
}

fn has_null(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::Array(values) => values.iter().any(has_null),
        Value::Object(members) => members.values().any(has_null),
        _ => false,
    }
}

/// Whether a text has the form of a PIN, six digits, which no token has.
#[must_use]
pub fn is_pin(text: &str) -> bool {
    text.len() == 6 && text.bytes().all(|byte| byte.is_ascii_digit())
}
