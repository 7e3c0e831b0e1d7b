//! File of a class (`class.toml`): pupils, groups, and the rules of turns.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use magician::{ArmModel, Fence, Message, message};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::{ClassError, invalid};
use crate::control::TurnRules;
use crate::secret::same_secret;

/// Characters of generated codes, without lookalikes (0 and O, 1, I and L).
const CODE_ALPHABET: &[u8] = b"23456789ABCDEFGHJKMNPQRSTUVWXYZ";
/// Most pupils of a class.
const MAX_PUPILS: usize = 60;

/// Pupil.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pupil {
    /// Name, under which results are kept.
    pub name: String,
    /// Group. `None` if the pupil has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Code for signing in: 4 to 6 letters and digits. Empty until one is generated.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub code: String,
}

/// Rules for all pupils.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ClassRules {
    /// Length of a turn, s. 0 for no end.
    pub turn_s: u32,
    /// Time for which an arm is kept for an absent pupil, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grace_s: Option<u32>,
    /// True if a job that is running at the end of a turn continues to its end.
    pub finish_job: bool,
    /// Highest speed of the tip, percent of the arm's highest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// Fence, with the members of `arm.fence`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fence: Option<Map<String, Value>>,
    /// Offset of local time from UTC, such as `+01:00`, used if the schedule has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<String>,
    /// Arms for pupils. Empty for all arms.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub arms: Vec<String>,
    /// Teacher's PIN, six digits. Gives the role of a teacher on the station's machine.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub pin: String,
}

/// Class.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ClassFile {
    /// Rules.
    pub class: ClassRules,
    /// Arms of each group.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub groups: BTreeMap<String, Vec<String>>,
    /// Pupils.
    pub pupil: Vec<Pupil>,
}

impl ClassFile {
    /// Parses a class file.
    ///
    /// # Errors
    /// What is wrong with the text, with its line if known.
    pub fn parse(text: &str) -> Result<Self, ClassError> {
        let file: Self =
            toml::from_str(text).map_err(|error| ClassError(error.to_string().into()))?;
        let mut names = BTreeSet::new();
        if file.pupil.len() > MAX_PUPILS {
            return invalid(message!(
                "a class has {most} pupils at most",
                most = MAX_PUPILS
            ));
        }
        // Infinity and NaN of TOML become null in JSON, and null means "no bound".
        if file
            .class
            .fence
            .as_ref()
            .is_some_and(|fence| fence.values().any(has_null))
        {
            return invalid(message!("[class] fence must have finite numbers"));
        }
        for pupil in &file.pupil {
            let name = &pupil.name;
            // Reserved in schedules.
            if name == "teacher" || pupil.group.as_deref() == Some("teacher") {
                return invalid(message!(
                    "`teacher` is whoever teaches in a schedule: no pupil or group is called so"
                ));
            }
            let fine = name.trim() == name
                && (1..=40).contains(&name.chars().count())
                && !name.chars().any(char::is_control);
            if !fine {
                return invalid(message!(
                    "`{name}` is no name for a pupil: 1 to 40 characters, with no blank first or last",
                    name = magician_protocol::visible(name).to_string()
                ));
            }
            // Signing in ignores case, so names must differ without it.
            if !names.insert(name.to_lowercase()) {
                return invalid(message!(
                    "two pupils are called {name}: add a letter to one",
                    name
                ));
            }
            let code = pupil.code.as_bytes();
            let sign = |byte: &u8| byte.is_ascii_alphanumeric();
            if !code.is_empty() && (!(4..=6).contains(&code.len()) || !code.iter().all(sign)) {
                return invalid(message!(
                    "the code of {name} must be 4 to 6 letters or digits; leave it out to have one made",
                    name
                ));
            }
        }
        let pin = &file.class.pin;
        if !pin.is_empty() && !is_pin(pin) {
            return invalid(message!(
                "[class] pin must be six digits; leave it out to have one made"
            ));
        }
        if let Some(text) = &file.class.offset
            && super::offset_of(text).is_none()
        {
            return invalid(message!("[class] offset must be like \"+01:00\""));
        }
        file.fence()?;
        Ok(file)
    }

    /// Creates a class of these pupils at these arms (all if empty), with this length of turns, s,
    /// and this offset from UTC. Everything else is taken over from `before`.
    ///
    /// # Errors
    /// The same as [`parse`](Self::parse).
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
        // Through text, so that the same checks apply as for a file.
        Self::parse(&file.to_text())
    }

    /// Checks that the arms of the class and of its groups exist.
    ///
    /// # Errors
    /// Names an arm that `place` does not have.
    pub fn check_arms(
        &self,
        place: &'static str,
        has: impl Fn(&str) -> bool,
    ) -> Result<(), ClassError> {
        let place = Message::word(place);
        if let Some(arm) = self.class.arms.iter().find(|arm| !has(arm)) {
            return invalid(message!(
                "[class] has the arm {arm}, which {place} has not",
                arm,
                place
            ));
        }
        for (group, arms) in &self.groups {
            if let Some(arm) = arms.iter().find(|arm| !has(arm)) {
                return invalid(message!(
                    "the group {group} has the arm {arm}, which {place} has not",
                    group,
                    arm,
                    place
                ));
            }
        }
        Ok(())
    }

    /// Takes over codes and PIN from the class `before`, so that an old file does not bring old
    /// codes back.
    ///
    /// With `uses_own` the codes in this file win. Returns the names of pupils whose code in this
    /// file does not apply.
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
            // Codes are compared without case when signing in.
            let differs = !pupil.code.eq_ignore_ascii_case(&known.code);
            if differs && !pupil.code.is_empty() {
                kept.push(pupil.name.clone());
            }
            pupil.code.clone_from(&known.code);
        }
        kept
    }

    /// True if pupils may use the arm.
    pub(crate) fn has_arm(&self, arm: &str) -> bool {
        let arms = &self.class.arms;
        arms.is_empty() || arms.iter().any(|known| known == arm)
    }

    /// Removes the codes of these pupils, or of all.
    ///
    /// # Errors
    /// A name that no pupil has.
    pub fn drop_codes(&mut self, names: Option<&[&str]>) -> Result<(), ClassError> {
        let unknown = { names.into_iter().flatten() }.find(|name| self.named(name).is_none());
        if let Some(name) = unknown {
            return invalid(message!("there is no pupil {name}", name));
        }
        let meant = |name: &str| names.is_none_or(|names| names.contains(&name));
        for pupil in self.pupil.iter_mut().filter(|pupil| meant(&pupil.name)) {
            pupil.code.clear();
        }
        Ok(())
    }

    /// Returns the text of the file.
    #[must_use]
    pub fn to_text(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// Generates codes for pupils without one, all different, and a missing PIN. `random` must
    /// return unpredictable numbers.
    pub fn make_codes(&mut self, mut random: impl FnMut() -> u64) {
        if self.class.pin.is_empty() {
            // Six digits can be typed quickly. They suffice because the PIN is valid on one machine
            // and tries are limited.
            self.class.pin = format!("{:06}", random() % 1_000_000);
        }
        let mut taken: BTreeSet<_> = self.pupil.iter().map(|pupil| pupil.code.clone()).collect();
        for pupil in self.pupil.iter_mut().filter(|pupil| pupil.code.is_empty()) {
            // Also leaves the empty code, which is in the set.
            while taken.contains(&pupil.code) {
                let mut number = random();
                pupil.code = (0..6)
                    .map(|_| {
                        let sign = CODE_ALPHABET[(number % CODE_ALPHABET.len() as u64) as usize];
                        number /= CODE_ALPHABET.len() as u64;
                        char::from(sign)
                    })
                    .collect();
            }
            taken.insert(pupil.code.clone());
        }
    }

    /// Returns the pupil with this name and code, ignoring case. Takes the same time for all
    /// inputs, so that it reveals nothing about codes.
    pub(crate) fn signs_in(&self, name: &str, code: &str) -> Option<&Pupil> {
        let code = code.to_uppercase();
        let mut found = None;
        for pupil in &self.pupil {
            let good = same_secret(&pupil.code.to_uppercase(), &code) && !code.is_empty();
            // `&` instead of `&&`, so that both sides are always computed.
            if good & (pupil.name.to_lowercase() == name.to_lowercase()) {
                found = Some(pupil);
            }
        }
        found
    }

    pub(crate) fn named(&self, name: &str) -> Option<&Pupil> {
        self.pupil.iter().find(|pupil| pupil.name == name)
    }

    /// Returns the pupil with this name, ignoring case.
    pub(crate) fn named_ignoring_case(&self, name: &str) -> Option<&Pupil> {
        let name = name.to_lowercase();
        { self.pupil.iter() }.find(|pupil| pupil.name.to_lowercase() == name)
    }

    /// True if a pupil has this name, given in lower case.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.pupil
            .iter()
            .any(|pupil| pupil.name.to_lowercase() == name)
    }

    pub(crate) fn turns(&self) -> TurnRules {
        let seconds = |seconds| Duration::from_secs(u64::from(seconds));
        TurnRules {
            length: (self.class.turn_s > 0).then(|| seconds(self.class.turn_s)),
            // Enough to reload a page, or to fetch a tablet; a choice.
            grace: seconds(self.class.grace_s.unwrap_or(30)),
            finish_job: self.class.finish_job,
        }
    }

    /// Returns the fence for pupils: that of the file, and the speed limit.
    pub(crate) fn fence(&self) -> Result<Option<Fence>, ClassError> {
        let change = self.class.fence.clone().map(Value::Object);
        let fence = change.map(|change| crate::fence::change_of(None, &change));
        let fence = fence.transpose();
        let fence = fence.map_err(|why| ClassError(message!("[class] fence: {why}", why)))?;
        let fence = fence.flatten();
        let Some(percent) = self.class.speed else {
            return Ok(fence);
        };
        if !(1.0..=100.0).contains(&percent) {
            return invalid(message!(
                "[class] speed must be a number from 1 to 100, percent"
            ));
        }
        let top = ArmModel::MAGICIAN.ceilings.linear_velocity * percent / 100.0;
        let bounds = Fence::default().with_top_speed(top);
        let bounds = bounds.map_err(|error| ClassError(error.into()))?;
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

/// True if the text has the form of a PIN: six digits. No token has it.
#[must_use]
pub fn is_pin(text: &str) -> bool {
    text.len() == 6 && text.bytes().all(|byte| byte.is_ascii_digit())
}
