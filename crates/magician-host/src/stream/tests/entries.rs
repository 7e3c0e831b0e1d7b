//! The running counts equal a full count.

use magician_protocol::Set;

use crate::build;
use crate::connection::{Connection, Request, Settings, Ticket};
use crate::pair::Dice;
use crate::stream::entries::Entries;
use crate::stream::item::{Entry, Fate, Item};

fn entry(dice: &mut Dice) -> Entry {
    let commands: [Set; 3] = [
        build::path_to(220.0, 0.0, 20.0),
        build::engrave_to(220.0, 0.0, 20.0, 50.0),
        build::laser(true),
    ];
    let times = [0, 20_000, u64::MAX];
    let item = Item {
        command: commands[dice.number() as usize % 3],
        time: times[dice.number() as usize % 3],
        end: None,
        laser: dice.number().is_multiple_of(4),
    };
    Entry::new(item, dice.number().is_multiple_of(5))
}

fn ticket() -> Ticket {
    let request = Request::set(&magician_protocol::commands::QueuedCmdStopExec {}).unwrap();
    Connection::new(Settings::ORDERED).submit(request)
}

fn fate(dice: &mut Dice, index: u64) -> Fate {
    match dice.number() % 4 {
        0 => Fate::Waiting,
        1 => Fate::InFlight(ticket()),
        2 => Fate::Doubtful,
        _ => Fate::Accepted(index),
    }
}

/// Asserts that the counts for any marks equal those computed from the list.
fn check(entries: &Entries, current: u64, confirmed: Option<u64>) {
    assert!(entries.is_counted(), "{entries:?}");
    let unfinished = || (entries.iter()).filter(|one| one.index().is_some_and(|at| at > current));
    let under_way = || unfinished().chain(entries.iter().filter(|one| one.is_in_flight()));
    let load = entries.under_way(current);
    let time = under_way().fold(0, |sum: u64, one| sum.saturating_add(one.item.time));
    assert_eq!(load.count, under_way().count());
    assert_eq!(
        (load.time(), load.burns()),
        (time, under_way().any(Entry::burns))
    );
    assert_eq!(entries.unfinished(current).count, unfinished().count());
    let waiting = entries.iter().filter(|one| one.is_waiting()).count();
    assert_eq!(
        (entries.waiting(), entries.kept()),
        (waiting, entries.len() - waiting)
    );
    assert_eq!(entries.next(), entries.iter().position(Entry::is_waiting));
    let certain = |one: &Entry| {
        one.index()
            .is_some_and(|at| confirmed.is_some_and(|all| at <= all))
    };
    let unconfirmed = (entries.iter()).filter(|one| !one.is_waiting() && !certain(one));
    assert_eq!(entries.unconfirmed(confirmed), unconfirmed.count());
}

#[test]
fn the_counts_follow_every_change() {
    for seed in 0..200 {
        let mut dice = Dice::new(seed);
        let mut entries = Entries::with_capacity(8);
        let (mut current, mut confirmed) = (0, None);
        for step in 0..200 {
            let at = dice.number() as usize % (entries.len() + 1);
            match dice.number() % 8 {
                0..=2 => entries.push(entry(&mut dice)),
                3 => drop(entries.pop()),
                4 => entries.insert(at, entry(&mut dice)),
                5 => {
                    let fate = fate(&mut dice, step);
                    entries.set_fate(at, fate);
                }
                6 => {
                    let fate = fate(&mut dice, step);
                    entries.change(at..at + 3, |one| one.fate = fate);
                }
                _ => {
                    current = dice.number() % 200;
                    confirmed = (!dice.number().is_multiple_of(3)).then(|| dice.number() % 200);
                    // A mark not set yet costs time and nothing else.
                    check(&entries, current, confirmed);
                    entries.mark(current, confirmed);
                }
            }
            check(&entries, current, confirmed);
            let sought = dice.number() % 200;
            let is = |one: &Entry| one.index() == Some(sought);
            assert_eq!(entries.find(is).is_some(), entries.iter().any(is));
        }
    }
}
