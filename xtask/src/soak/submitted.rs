//! Commands submitted one by one to a connection.

use std::error::Error;

use magician::connection::{Failure, Request, Settings};
use magician::faults::Faults;
use magician::pair::{Pair, index_of};
use magician_protocol::commands::{
    ClearAllAlarmsState, DeviceTime, QueuedCmdCurrentIndex, QueuedCmdLeftSpace, QueuedCmdStartExec,
    WaitCmd,
};
use magician_protocol::{FrameBuf, NoArgs};

use super::command_log::CommandLog;
use super::{Scope, SoakResult, program};
use crate::bench::figure::Figure;

const SECOND: u64 = 1_000_000;

/// Faults of the serial line in R1.
pub(super) const SERIAL_FAULTS: Faults = Faults {
    replace: 1e-3,
    drop: 1e-4,
    ..Faults::NONE
};

/// Creates a pair over a perfect line. The queue runs; the host has read its free space while it
/// was empty, and has queued a few commands.
pub(super) fn pair_with_running_queue(settings: Settings, seed: u64) -> Result<Pair, Failure> {
    let mut pair = Pair::new(settings, Faults::NONE, seed);
    let refused = |_| Failure::Refused;
    pair.ask(
        Request::set(&QueuedCmdStartExec {}).map_err(refused)?,
        SECOND,
    )?;
    pair.ask(
        Request::get::<QueuedCmdLeftSpace>(&NoArgs).map_err(refused)?,
        SECOND,
    )?;
    for _ in 0..4 {
        pair.ask(
            Request::queued(&WaitCmd { timeout: 0 }).map_err(refused)?,
            10 * SECOND,
        )?;
    }
    pair.accepted.clear();
    pair.heard.clear();
    Ok(pair)
}

/// Lets the arm work until its queue has room. The host acts only if the queue has stopped: after a
/// reset, or after the line altered a command so that the arm cannot perform it.
pub(super) fn make_room(pair: &mut Pair) {
    while pair.arm.state().queue.waiting > 16 {
        let state = pair.arm.state().queue;
        if !state.started {
            poll(pair);
        }
        if state.held
            && let Ok(clear) = Request::set(&ClearAllAlarmsState {})
        {
            run_request(pair, clear).ok();
        }
        let deadline = pair.now + SECOND;
        pair.step(deadline);
    }
}

/// Records what the arm has accepted since the last call.
pub(super) fn log_accepted(pair: &mut Pair, log: &mut CommandLog) {
    for (params, index) in pair.accepted.drain(..) {
        log.note_accepted(&params, index);
    }
    for interval in pair.reports.drain(..) {
        log.note_unreliable(interval);
    }
    pair.heard.clear();
    while pair.arm.poll_event().is_some() {}
}

/// Run of commands, each submitted after the previous one has ended.
struct Outcome {
    pair: Pair,
    log: CommandLog,
    /// Mean number of frames per command beyond the first.
    extra: f64,
    /// Virtual time, s.
    duration: f64,
}

fn one_by_one(scope: Scope, settings: Settings, faults: Faults) -> Result<Outcome, Box<dyn Error>> {
    let mut pair =
        pair_with_running_queue(settings, scope.seed).map_err(|failure| format!("{failure:?}"))?;
    let before = pair.host.stats().sent;
    let began = pair.now;
    pair.set_faults(faults);
    let may_restart = faults.reset > 0.0 || faults.unplug > 0.0;
    let mut polls = 0;
    let mut log = CommandLog::default();
    for number in 1..=scope.cases {
        if number % 8 == 0 {
            make_room(&mut pair);
        }
        let request = program::request(&program::mixed(number));
        log.send(number, request.frame().frame().params());
        let outcome = run_request(&mut pair, request);
        log.note_outcome(number, outcome.map(|reply| index_of(&reply)), pair.boots);
        log_accepted(&mut pair, &mut log);
        if may_restart && number % 64 == 0 {
            polls += poll(&mut pair);
        }
    }
    settle_line(&mut pair, &mut log);
    let sent = pair.host.stats().sent - before;
    let extra = (sent - polls - log.tally.commands) as f64 / log.tally.commands as f64;
    let duration = (pair.now - began) as f64 / 1e6;
    Ok(Outcome {
        pair,
        log,
        extra,
        duration,
    })
}

/// Runs one request to its end. A plug that is pulled meanwhile is reinserted after a while.
pub(super) fn run_request(pair: &mut Pair, request: Request) -> Result<FrameBuf, Failure> {
    let deadline = pair.now + 60 * SECOND;
    let ticket = pair.host.submit(request.deadline(deadline));
    loop {
        if let Some(result) = pair.results.remove(&ticket) {
            return result;
        }
        pair.step(deadline);
        if pair.unplugged {
            pair.host.interrupt();
            let reinserted_at = pair.now + pair.dice.below(3 * SECOND);
            pair.run_until(reinserted_at);
            pair.put_cable_back();
        }
    }
}

/// Does what a driver does regularly: reads the current index and the arm's clock, and starts a
/// stopped queue. Returns the number of requests.
pub(super) fn poll(pair: &mut Pair) -> u64 {
    let reads = [
        Request::get::<QueuedCmdCurrentIndex>(&NoArgs),
        Request::get::<DeviceTime>(&NoArgs),
    ];
    for read in reads.into_iter().flatten() {
        run_request(pair, read).ok();
    }
    if !pair.arm.state().queue.started
        && let Ok(start) = Request::set(&QueuedCmdStartExec {})
    {
        run_request(pair, start).ok();
        return 3;
    }
    2
}

/// Removes the faults of the line, waits until everything in flight has arrived, and reads the
/// current index once more.
fn settle_line(pair: &mut Pair, log: &mut CommandLog) {
    pair.set_faults(Faults::NONE);
    let settled_at = pair.now + 10 * SECOND;
    pair.run_until(settled_at);
    if let Ok(index) = Request::get::<QueuedCmdCurrentIndex>(&NoArgs) {
        pair.ask(index, 10 * SECOND).ok();
    }
    log_accepted(pair, log);
    log.judge_rest();
}

/// R1, each command submitted after the previous one has ended.
pub(super) fn over_corrupted_line(scope: Scope) -> Result<SoakResult, Box<dyn Error>> {
    let run = one_by_one(scope, Settings::ORDERED, SERIAL_FAULTS)?;
    let tally = run.log.tally;
    let mut figures = tally.figures();
    // Three in a million. Short runs are allowed three as well.
    let altered = 3.0 * (tally.commands as f64 / 1e6).max(1.0);
    figures.push(Figure::new("altered", tally.altered as f64, "commands").at_most(altered));
    figures.push(Figure::new("strays", tally.strays as f64, "commands"));
    figures.push(Figure::new("extra exchanges", run.extra, "a command").at_most(0.3));
    figures.push(Figure::new("virtual time", run.duration, "s"));
    Ok(SoakResult {
        figures,
        digest: Some(run.pair.digest.0),
    })
}

/// R2: additionally the plug is pulled and the controller restarts.
pub(super) fn with_resets(scope: Scope) -> Result<SoakResult, Box<dyn Error>> {
    let faults = Faults {
        unplug: 1e-5,
        reset: 1e-5,
        ..SERIAL_FAULTS
    };
    let run = one_by_one(scope, Settings::ORDERED, faults)?;
    let tally = run.log.tally;
    let mut figures = tally.figures();
    let altered = 3.0 * (tally.commands as f64 / 1e6).max(1.0);
    figures.push(Figure::new("altered", tally.altered as f64, "commands").at_most(altered));
    let (boots, reported) = (f64::from(run.pair.boots), f64::from(run.pair.resets));
    figures.push(Figure::new("resets", boots, ""));
    figures.push(Figure::new("resets that were not told", boots - reported, "").at_most(0.0));
    figures.push(Figure::new("extra exchanges", run.extra, "a command"));
    figures.push(Figure::new("virtual time", run.duration, "s"));
    Ok(SoakResult {
        figures,
        digest: Some(run.pair.digest.0),
    })
}

/// R3: queued commands over datagrams that are lost, duplicated and reordered.
pub(super) fn datagrams(scope: Scope) -> Result<SoakResult, Box<dyn Error>> {
    let faults = Faults {
        drop_chunk: 0.05,
        duplicate_chunk: 0.01,
        swap_chunk: 0.05,
        ..Faults::NONE
    };
    let run = one_by_one(scope, Settings::DATAGRAMS, faults)?;
    let mut figures = run.log.tally.figures();
    let reports = f64::from(run.pair.unaccounted);
    figures.push(Figure::new("reports of surplus commands", reports, ""));
    figures.push(Figure::new("extra exchanges", run.extra, "a command"));
    figures.push(Figure::new("virtual time", run.duration, "s"));
    Ok(SoakResult {
        figures,
        digest: Some(run.pair.digest.0),
    })
}
