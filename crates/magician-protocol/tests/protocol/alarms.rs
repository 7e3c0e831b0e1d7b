//! The alarms against `alarms.toml`, and the order of their bits.

use crate::material;
use magician_protocol::commands::AlarmsState;
use magician_protocol::{Alarm, AlarmGroup, AlarmSet};
use toml::Table;

fn documented_alarms() -> Vec<Table> {
    let table: Table = toml::from_str(include_str!("../data/alarms.toml")).unwrap();
    let alarms = table["alarm"].as_array().unwrap().iter();
    alarms
        .map(|alarm| alarm.as_table().unwrap().clone())
        .collect()
}

fn group(name: &str) -> AlarmGroup {
    match name {
        "common" => AlarmGroup::Common,
        "plan" => AlarmGroup::Plan,
        "move" => AlarmGroup::Move,
        "overspeed" => AlarmGroup::Overspeed,
        "limit" => AlarmGroup::Limit,
        "lose_step" => AlarmGroup::LostStep,
        "other" => AlarmGroup::Other,
        other => panic!("{other}"),
    }
}

#[test]
fn alarms_of_the_magician_are_those_of_alarms_toml() {
    let mut count = 0;
    for alarm in documented_alarms() {
        let code = u8::try_from(alarm["bit"].as_integer().unwrap()).unwrap();
        let family = alarm["device_family"].as_str().unwrap();
        let Some(known) = Alarm::with_code(code) else {
            assert_ne!(family, "Magician", "{code:#04x} has no name");
            continue;
        };
        assert_eq!(known.magician, family == "Magician", "{code:#04x}");
        if known.magician {
            count += 1;
            assert_eq!(known.name, alarm["name"].as_str().unwrap());
            assert_eq!(known.group, group(alarm["group"].as_str().unwrap()));
            assert_eq!(known.clears_itself, alarm["auto_clear"].as_bool().unwrap());
        }
    }
    assert_eq!(count, Alarm::TABLE.iter().filter(|a| a.magician).count());
    assert_eq!(count, 32);
}

#[test]
fn every_alarm_name_is_in_alarms_toml() {
    let written = documented_alarms();
    for alarm in Alarm::TABLE {
        let code = i64::from(alarm.code);
        let same = |w: &&Table| w["bit"].as_integer() == Some(code);
        let names: Vec<_> = written
            .iter()
            .filter(same)
            .map(|w| w["name"].as_str())
            .collect();
        assert!(
            names.contains(&Some(alarm.name)),
            "{} {names:?}",
            alarm.name
        );
    }
}

#[test]
fn alarms_are_in_order_explained_and_in_their_group() {
    assert!(Alarm::TABLE.is_sorted_by(|a, b| a.code < b.code));
    for alarm in Alarm::TABLE {
        assert!(!alarm.name.is_empty() && !alarm.cause.is_empty() && !alarm.remedy.is_empty());
        let expected = [
            AlarmGroup::Common,
            AlarmGroup::Plan,
            AlarmGroup::Move,
            AlarmGroup::Overspeed,
            AlarmGroup::Limit,
            AlarmGroup::LostStep,
            AlarmGroup::Other,
        ];
        assert_eq!(
            alarm.group,
            expected[usize::from(alarm.code / 16)],
            "{}",
            alarm.name
        );
        assert_eq!(Alarm::blocks(alarm.code), alarm.code > 7);
    }
}

#[test]
fn bit_zero_is_the_least_significant() {
    // E20; vector S089 holds 0x12 and 0x41.
    let vectors = material::vectors();
    let vector = vectors.iter().find(|vector| vector.id == "S089").unwrap();
    let set = vector.frame().read::<AlarmsState>().unwrap().alarms_state;
    assert!(set.codes().eq([0x12, 0x41]));
    assert_eq!(set.to_string(), "0x12 PlanInvLimit, 0x41 LimitAxis1Neg");
    assert!(set.blocking());
    assert_eq!(set, [0x12, 0x41].into_iter().collect());
}

#[test]
fn every_code_can_be_inserted_and_removed() {
    for code in 0..=u8::MAX {
        let mut set = AlarmSet::new();
        assert!(set.is_empty() && !set.blocking());
        set.insert(code);
        assert!(set.contains(code) && set.codes().eq([code]));
        assert_eq!(set.blocking(), Alarm::blocks(code));
        let byte = usize::from(code / 8);
        assert_eq!(set.as_bytes()[byte], 1 << (code % 8));
        assert_eq!(set.as_bytes().len(), 16.max(byte + 1));
        set.remove(code);
        assert!(set.is_empty());
    }
}

#[test]
fn empty_or_overlong_alarm_state_is_refused() {
    assert_eq!(AlarmSet::from_bytes(&[]), None);
    assert_eq!(AlarmSet::from_bytes(&[0; 33]), None);
    assert_eq!(AlarmSet::new().to_string(), "none");
}
