//! Schedule file (`schedule.toml`): who may use which arm when.
//!
//! A slot is either one span of time or repeats weekly in local time. Local time needs an offset
//! from UTC in the file, because the station does not know its time zone.

use std::time::{Duration, UNIX_EPOCH};

use magician::{Message, message};
use serde::Deserialize;
use serde_json::{Value, json};

use super::{ClassError, invalid};

const DAY: i64 = 86_400;
// Day 0 of Unix time was a Thursday.
const DAYS: [&str; 7] = ["thu", "fri", "sat", "sun", "mon", "tue", "wed"];

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    offset: Option<String>,
    #[serde(default)]
    slot: Vec<Row>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    arms: Vec<String>,
    who: Vec<String>,
    from: toml::Value,
    until: toml::Value,
    #[serde(default)]
    days: Vec<String>,
}

#[derive(Clone, Debug, PartialEq)]
enum SlotTime {
    /// A single span, Unix seconds.
    Once(i64, i64),
    /// Weekdays, numbered from Thursday as 0, and seconds of the local day.
    Weekly(Vec<i64>, i64, i64),
}

/// Row of the schedule.
#[derive(Clone, Debug, PartialEq)]
struct SlotRow {
    arms: Vec<String>,
    who: Vec<String>,
    when: SlotTime,
}

/// Schedule: who may use which arm when, by the station's clock.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Schedule {
    text: String,
    /// Offset of local time from UTC, s. `None` if the file has none.
    offset: Option<i64>,
    slots: Vec<SlotRow>,
}

/// Slot at a certain time, in Unix seconds.
pub(crate) struct Window<'s> {
    pub(crate) from: i64,
    pub(crate) until: i64,
    pub(crate) who: &'s [String],
}

impl Schedule {
    /// Parses a schedule file.
    ///
    /// # Errors
    /// What is wrong with the text, with the number of the slot.
    pub fn parse(text: &str) -> Result<Self, ClassError> {
        let file: File =
            toml::from_str(text).map_err(|error| ClassError(error.to_string().into()))?;
        let offset = match &file.offset {
            None => None,
            Some(text) => match offset(text) {
                None => {
                    return invalid(message!(
                        "`offset` must be like \"+01:00\", not {text}",
                        text = format!("{text:?}")
                    ));
                }
                some => some,
            },
        };
        let mut slots = Vec::new();
        for (at, row) in (1..).zip(file.slot) {
            let when = when(&row, offset.is_some());
            let when =
                when.map_err(|ClassError(why)| ClassError(message!("slot {at}: {why}", at, why)))?;
            if row.arms.is_empty() {
                return invalid(message!("slot {at}: `arms` names no arm", at));
            }
            if row.who.is_empty() {
                return invalid(message!(
                    "slot {at}: `who` names nobody; \"teacher\" keeps it for teachers",
                    at
                ));
            }
            let (arms, who) = (row.arms, row.who);
            slots.push(SlotRow { arms, who, when });
        }
        Ok(Self {
            text: text.to_owned(),
            offset,
            slots,
        })
    }

    /// Returns the text of the file.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the arms that the schedule names.
    pub fn arms(&self) -> impl Iterator<Item = &str> {
        { self.slots.iter() }.flat_map(|slot| slot.arms.iter().map(String::as_str))
    }

    /// Checks that the arms of the schedule exist.
    ///
    /// # Errors
    /// Names an arm that `place` does not have.
    pub fn check_arms(
        &self,
        place: &'static str,
        has: impl Fn(&str) -> bool,
    ) -> Result<(), ClassError> {
        let place = Message::word(place);
        for (at, slot) in (1..).zip(&self.slots) {
            if let Some(arm) = slot.arms.iter().find(|arm| !has(arm)) {
                return invalid(message!(
                    "slot {at} has the arm {arm}, which {place} has not",
                    at,
                    arm,
                    place
                ));
            }
        }
        Ok(())
    }

    /// Returns the current and future slots of an arm, up to eight days ahead. `None` if no slot
    /// names the arm.
    pub(crate) fn windows(&self, arm: &str, now: i64) -> Option<Vec<Window<'_>>> {
        let of = |slot: &&SlotRow| slot.arms.iter().any(|name| name == arm);
        let slots: Vec<_> = self.slots.iter().filter(of).collect();
        if slots.is_empty() {
            return None;
        }
        let offset = self.offset.unwrap_or_default();
        // Euclidean division is also right for times before 1970, which an unset clock may give
        // together with the offset.
        let today = (now + offset).div_euclid(DAY);
        let mut out = Vec::new();
        for slot in slots {
            let who = &slot.who[..];
            match &slot.when {
                SlotTime::Once(from, until) => out.push(Window {
                    from: *from,
                    until: *until,
                    who,
                }),
                SlotTime::Weekly(days, from, until) => {
                    // From yesterday on, because a slot may continue past midnight.
                    let on =
                        (today - 1..=today + 8).filter(|day| days.contains(&day.rem_euclid(7)));
                    out.extend(on.map(|day| {
                        let midnight = day * DAY - offset;
                        // Ends before it starts: it continues past midnight.
                        let until = if until <= from { until + DAY } else { *until };
                        Window {
                            from: midnight + from,
                            until: midnight + until,
                            who,
                        }
                    }));
                }
            }
        }
        out.retain(|window| window.until > now);
        // The first window that has not begun is the next one.
        out.sort_by_key(|window| window.from);
        Some(out)
    }

    /// Returns the offset of local time from UTC, s. `None` if the file has none.
    pub(crate) const fn offset(&self) -> Option<i64> {
        self.offset
    }

    /// Returns the slots in the form of the API.
    pub(crate) fn shown(&self) -> Vec<Value> {
        let slots = self.slots.iter().map(|slot| {
            let (days, from, until) = match &slot.when {
                SlotTime::Once(from, until) => (Value::Null, json!(from), json!(until)),
                SlotTime::Weekly(days, from, until) => {
                    let days: Vec<_> = days.iter().map(|day| DAYS[*day as usize]).collect();
                    (json!(days), json!(from), json!(until))
                }
            };
            json!({"arms": slot.arms, "who": slot.who, "days": days, "from": from, "until": until})
        });
        slots.collect()
    }
}

fn when(row: &Row, local: bool) -> Result<SlotTime, ClassError> {
    let [from, until] = [&row.from, &row.until].map(|value| match value {
        toml::Value::String(text) => text.clone(),
        value => value.to_string(),
    });
    if row.days.is_empty() {
        let [Some(begin), Some(end)] = [&from, &until].map(|text| instant(text)) else {
            return invalid(message!(
                "`from` and `until` must be like \"2026-11-25T08:00:00+01:00\"; every week: add `days` and times like \"08:00\""
            ));
        };
        // An empty slot would never be open.
        if begin >= end {
            return invalid(message!(
                "`until` {until} is not behind `from` {from}",
                until,
                from
            ));
        }
        return Ok(SlotTime::Once(begin, end));
    }
    // Without an offset "08:00" is not an instant.
    if !local {
        return invalid(message!(
            "weekly slots need the station's local time: add offset = \"+01:00\" at the top of the file"
        ));
    }
    let days = row.days.iter().map(|day| {
        let day = day.to_lowercase();
        DAYS.iter()
            .position(|known| *known == day)
            .map(|at| at as i64)
    });
    let Some(days) = days.collect::<Option<Vec<_>>>() else {
        return invalid(message!(
            "`days` must be of mon, tue, wed, thu, fri, sat and sun"
        ));
    };
    match [&from, &until].map(|text| time(text)) {
        [Some(from), Some(until)] => Ok(SlotTime::Weekly(days, from, until)),
        _ => invalid(message!(
            "`from` and `until` of a weekly slot must be like \"08:00\""
        )),
    }
}

/// Parses `HH:MM` or `HH:MM:SS`. Returns seconds of the day.
fn time(text: &str) -> Option<i64> {
    let parts: Vec<_> = text.split(':').collect();
    let two = |text: &&str| text.len() == 2 && text.bytes().all(|byte| byte.is_ascii_digit());
    if !(2..=3).contains(&parts.len()) || !parts.iter().all(two) {
        return None;
    }
    let number = |at: usize| {
        parts
            .get(at)
            .map_or(Some(0), |text| text.parse::<i64>().ok())
    };
    let (hour, minute, second) = (number(0)?, number(1)?, number(2)?);
    // 24:00 is the end of the day.
    let fine = hour < 24 && minute < 60 && second < 60 || (hour, minute, second) == (24, 0, 0);
    fine.then_some(hour * 3600 + minute * 60 + second)
}

/// Formats Unix seconds as local time, such as `2026-11-25 08:12`, with this offset from UTC, s.
/// Marked `UTC` without an offset.
pub(crate) fn local_time(time: i64, offset: Option<i64>) -> String {
    let since = Duration::from_secs((time + offset.unwrap_or_default()).max(0) as u64);
    let text = humantime::format_rfc3339_seconds(UNIX_EPOCH + since).to_string();
    let (day, clock) = (&text[..10], &text[11..16]);
    let zone = if offset.is_none() { " UTC" } else { "" };
    format!("{day} {clock}{zone}")
}

/// Parses `Z`, `+HH:MM` or `-HH:MM`. Returns the offset from UTC, s.
pub(crate) fn offset(text: &str) -> Option<i64> {
    if text.eq_ignore_ascii_case("z") {
        return Some(0);
    }
    let (sign, rest) = match text.split_at_checked(1)? {
        ("+", rest) => (1, rest),
        ("-", rest) => (-1, rest),
        _ => return None,
    };
    (rest.len() == 5)
        .then(|| time(rest))
        .flatten()
        .map(|seconds| sign * seconds)
}

/// Parses a time of RFC 3339 without fractions of a second. Returns Unix seconds.
fn instant(text: &str) -> Option<i64> {
    let (date, rest) = text.split_once(['T', 't', ' '])?;
    let at = rest.find(['Z', 'z', '+', '-'])?;
    let (clock, zone) = rest.split_at(at);
    let digits: Vec<_> = date.split('-').collect();
    let [year, month, day] = digits.as_slice() else {
        return None;
    };
    let number = |text: &str, length: usize| {
        let fine = text.len() == length && text.bytes().all(|byte| byte.is_ascii_digit());
        fine.then(|| text.parse::<i64>().ok()).flatten()
    };
    let (year, month, day) = (number(year, 4)?, number(month, 2)?, number(day, 2)?);
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let length = match month {
        2 if leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => return None,
    };
    if !(1..=length).contains(&day) {
        return None;
    }
    // Days since 1970 in a calendar whose years begin in March: Howard Hinnant, "chrono-compatible
    // low-level date algorithms".
    let year = if month <= 2 { year - 1 } else { year };
    let (era, of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let days = era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468;
    Some(days * DAY + time(clock)? - offset(zone)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = r#"
offset = "+01:00"
[[slot]]
arms = ["left"]
who = ["red"]
from = 2026-11-25T08:00:00+01:00
until = "2026-11-25T09:30:00+01:00"
[[slot]]
arms = ["left", "right"]
who = ["teacher"]
days = ["mon", "wed"]
from = "22:00"
until = "01:00"
"#;

    #[test]
    fn displayed_time_is_local() {
        for (offset, text) in [
            (Some(5400), "2026-11-25 09:42"),
            (Some(-5400), "2026-11-25 06:42"),
            (None, "2026-11-25 08:12 UTC"),
        ] {
            assert_eq!(local_time(1_795_594_320, offset), text);
        }
    }

    #[test]
    fn times_match_the_calendar() {
        for (text, seconds) in [
            ("1970-01-01T00:00:00Z", Some(0)),
            ("2000-02-29T12:00:00+01:00", Some(951_822_000)),
            ("2026-11-25T08:00:00+01:00", Some(1_795_590_000)),
            ("2026-02-29T08:00:00Z", None),
            ("2026-11-25T08:00:00", None),
            ("2026-11-25T25:00:00Z", None),
            ("", None),
        ] {
            assert_eq!(instant(text), seconds, "{text}");
        }
    }

    #[test]
    fn weekly_slots_use_local_days_and_may_cross_midnight() {
        let schedule = Schedule::parse(FILE).unwrap();
        // Wednesday, 23:30 local time.
        let now = instant("2026-11-25T23:30:00+01:00").unwrap();
        let right = schedule.windows("right", now).unwrap();
        let first = &right[0];
        assert_eq!(Some(first.from), instant("2026-11-25T21:00:00Z"));
        assert_eq!(Some(first.until), instant("2026-11-26T00:00:00Z"));
        assert_eq!(right[1].from - first.from, 5 * DAY);
        assert!(schedule.windows("other", now).is_none());
        let morning = instant("2026-11-25T08:15:00+01:00").unwrap();
        assert_eq!(schedule.windows("left", morning).unwrap()[0].who, ["red"]);
    }

    #[test]
    fn schedule_error_names_its_slot_and_the_expected_form() {
        let weekly = FILE.replace("offset = \"+01:00\"\n", "");
        for (text, part) in [
            (weekly.as_str(), "slot 2: weekly slots need"),
            (&FILE.replace("\"mon\"", "\"monday\""), "slot 2: `days`"),
            (&FILE.replace("09:30:00", "07:30:00"), "slot 1: `until`"),
            (&FILE.replace("+01:00\"\n[[", "1\"\n[["), "`offset` must be"),
            ("[[slot]]\nx = 1", "unknown field"),
        ] {
            let error = Schedule::parse(text).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    }
}
