//! Host and arm on one virtual clock: guarantees of the connection over good and bad lines.

mod datagrams;
mod doubts;
mod exhaustive;
mod faults;
mod full_line;
mod interruption;
mod law;
mod pairs;
mod planted_bugs;
mod replies;
mod stops;
mod toy;
mod window;

use magician_protocol::NoArgs;
use magician_protocol::commands::{GetIoDi, IoDi, QueuedCmdLeftSpace, QueuedCmdStartExec, WaitCmd};

use crate::connection::{IndexLaw, Request, Settings};
use crate::pair::{Faults, Pair};

const SECOND: u64 = 1_000_000;

fn wait(ms: u32) -> Request {
    Request::queued(&WaitCmd { timeout: ms }).unwrap()
}

fn get_di(address: u8) -> Request {
    Request::get::<IoDi>(&GetIoDi {
        address: Some(address),
    })
    .unwrap()
}

/// A pair with a perfect line, whose queue runs and was seen empty.
fn ready(settings: Settings, seed: u64) -> Pair {
    let mut pair = Pair::new(settings, Faults::default(), seed);
    pair.count_from(1);
    pair.ask(Request::set(&QueuedCmdStartExec {}).unwrap(), SECOND)
        .unwrap();
    pair.ask(Request::get::<QueuedCmdLeftSpace>(&NoArgs).unwrap(), SECOND)
        .unwrap();
    pair
}

/// A command that may share a window.
fn shared(ms: u32) -> Request {
    wait(ms).repeatable()
}

/// A pair with this window that has seen the arm follow the law: four commands were accepted.
fn lawful(window: usize, seed: u64) -> Pair {
    let settings = Settings {
        window,
        ..Settings::ORDERED
    };
    let mut pair = ready(settings, seed);
    for _ in 0..4 {
        pair.ask(wait(0), SECOND).unwrap();
    }
    assert_eq!(pair.host.law(), IndexLaw::Followed);
    pair
}
