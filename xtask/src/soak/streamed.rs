//! Program of numbered commands over a stream.

use std::collections::VecDeque;
use std::error::Error;

use magician::commands::ClearAllAlarmsState;
use magician::connection::{Failure, Request, Settings};
use magician::faults::Faults;
use magician::pair::Pair;
use magician::stream::{Stream, StreamEvent, StreamFailure, StreamSettings};

use super::submitted::{SERIAL_FAULTS, pair_with_running_queue};
use super::{Scope, SoakResult, program};
use crate::bench::figure::Figure;

const SECOND: u64 = 1_000_000;
/// Number of recent commands whose parameters are remembered.
const REMEMBERED_COMMANDS: usize = 256;

/// Number of commands by outcome.
#[derive(Default)]
struct Tally {
    taken: u64,
    twice: u64,
    disordered: u64,
    altered: u64,
    /// Given up with a reported reason: they were in the arm or in flight when it was reset.
    abandoned: u64,
    /// Given up, but accepted by the arm.
    abandoned_taken: u64,
    resumed: u64,
    refused: u64,
    doubts: u64,
    unplugged: u64,
}

/// Stream with its arm, and the test's knowledge of both.
struct Rig {
    pair: Pair,
    stream: Stream,
    /// Number of the next command to offer, and the last number.
    next: u64,
    cases: u64,
    /// Offered commands that have not reached the arm: number and parameters.
    awaited: VecDeque<(u64, Vec<u8>)>,
    /// Parameters of the last commands accepted.
    seen: VecDeque<Vec<u8>>,
    /// Largest number of the given-up commands.
    given_up: u64,
    resets: u32,
    /// Time before which alarms are not cleared again.
    alarmed: Option<u64>,
    tally: Tally,
    failure: Option<StreamFailure>,
}

impl Rig {
    fn new(scope: Scope, faults: Faults) -> Result<Self, Box<dyn Error>> {
        let mut pair = pair_with_running_queue(Settings::ORDERED, scope.seed)
            .map_err(|failure| format!("{failure:?}"))?;
        pair.set_faults(faults);
        Ok(Self {
            pair,
            stream: Stream::new(StreamSettings::default()),
            next: 1,
            cases: scope.cases,
            awaited: VecDeque::new(),
            seen: VecDeque::new(),
            given_up: 0,
            resets: 0,
            alarmed: None,
            tally: Tally::default(),
            failure: None,
        })
    }

    fn advance(&mut self) -> Result<(), Box<dyn Error>> {
        while self.stream.room() > 0 && self.next <= self.cases {
            let item = program::item(self.next);
            self.stream.offer(item)?;
            let params = program::frame(&item.command).frame().params().to_vec();
            self.awaited.push_back((self.next, params));
            self.next += 1;
        }
        if self.next > self.cases {
            self.stream.finish();
        }
        self.stream.advance(self.pair.now, &mut self.pair.host);
        while let Some(event) = self.stream.poll_event() {
            if let StreamEvent::Failed(failure) = event {
                self.failure = Some(failure);
            }
        }
        Ok(())
    }

    fn deliver(&mut self) {
        let mut ended: Vec<_> = self.pair.results.drain().collect();
        ended.sort_by_key(|(ticket, _)| *ticket);
        for (ticket, result) in ended {
            (self.stream).answered(self.pair.now, ticket, &result, &mut self.pair.host);
        }
    }

    fn note(&mut self) {
        for (params, _) in std::mem::take(&mut self.pair.accepted) {
            self.take(params);
        }
        self.pair.heard.clear();
        self.pair.reports.clear();
        while self.pair.arm.poll_event().is_some() {}
    }

    fn take(&mut self, params: Vec<u8>) {
        let tally = &mut self.tally;
        if self.seen.contains(&params) {
            tally.twice += 1;
            return;
        }
        match self
            .awaited
            .iter()
            .position(|(_, awaited)| *awaited == params)
        {
            Some(at) => {
                // Only given-up commands may be skipped.
                for (number, _) in self.awaited.drain(..at) {
                    tally.disordered += u64::from(number > self.given_up);
                }
                let number = self.awaited.pop_front().map_or(0, |(number, _)| number);
                if number <= self.given_up {
                    tally.abandoned_taken += 1;
                } else {
                    tally.taken += 1;
                }
            }
            None => {
                // The expected command, altered in a way that the checksum does not detect.
                tally.altered += 1;
                self.awaited.pop_front();
            }
        }
        self.seen.push_back(params);
        if self.seen.len() > REMEMBERED_COMMANDS {
            self.seen.pop_front();
        }
    }

    /// Runs to the next instant at which something happens.
    fn turn(&mut self) -> Result<(), Box<dyn Error>> {
        self.advance()?;
        let end = self.pair.now + 10 * SECOND;
        let due = self.stream.poll_timeout().unwrap_or(end);
        self.pair.step(due.clamp(self.pair.now, end));
        if self.pair.unplugged {
            self.tally.unplugged += 1;
            self.stream.interrupt(Failure::Lost);
            self.pair.host.interrupt();
            let back = self.pair.now + self.pair.dice.below(3 * SECOND);
            self.pair.run_until(back);
            self.pair.put_cable_back();
        }
        if self.pair.arm.state().queue.held && self.alarmed.is_none_or(|at| at < self.pair.now) {
            // The line altered a command so that the arm cannot perform it.
            self.alarmed = Some(self.pair.now + SECOND);
            let clear = Request::set(&ClearAllAlarmsState {})?;
            let patience = self.pair.now + SECOND;
            self.pair.host.submit(clear.deadline(patience));
        }
        self.note();
        self.deliver();
        if self.pair.resets > self.resets {
            self.resets = self.pair.resets;
            self.stream.reset();
        }
        self.advance()
    }

    /// Handles a failed stream: resumes its remainder, or after a reset continues with commands
    /// never offered.
    fn resume_or_restart(&mut self, failure: StreamFailure) {
        let settings = StreamSettings::default();
        let stream = std::mem::replace(&mut self.stream, Stream::new(settings));
        let doubt = StreamFailure::Request(Failure::Lost);
        let uncertain = matches!(failure, StreamFailure::Request(Failure::Uncertain { .. }));
        self.tally.doubts += u64::from(uncertain);
        if failure == doubt || uncertain {
            self.tally.resumed += 1;
            self.stream = Stream::resume(stream.leftover(), settings);
            return;
        }
        self.tally.refused += u64::from(!matches!(failure, StreamFailure::Reset { .. }));
        self.tally.abandoned += stream.leftover().len() as u64;
        self.given_up = self.next - 1;
    }

    fn run(&mut self) -> Result<(), Box<dyn Error>> {
        while !(self.stream.is_over() && self.failure.is_none()) {
            self.turn()?;
            if let Some(failure) = self.failure.take() {
                self.resume_or_restart(failure);
            }
        }
        self.pair.set_faults(Faults::NONE);
        let later = self.pair.now + 10 * SECOND;
        self.pair.run_until(later);
        self.note();
        Ok(())
    }
}

fn soak(scope: Scope, faults: Faults) -> Result<(Rig, Vec<Figure>), Box<dyn Error>> {
    let mut rig = Rig::new(scope, faults)?;
    let (before, began) = (rig.pair.host.stats(), rig.pair.now);
    rig.run()?;
    let stats = rig.pair.host.stats();
    let given_up = rig.given_up;
    let lost = rig.awaited.iter().filter(|(number, _)| *number > given_up);
    let lost = lost.count() as u64;
    let tally = &rig.tally;
    let count = |name: &str, value: u64| Figure::new(name, value as f64, "");
    let exchanges = (stats.sent - before.sent) as f64 / scope.cases as f64;
    let resent = (stats.resent - before.resent) as f64 / scope.cases as f64;
    let altered = 3.0 * (scope.cases as f64 / 1e6).max(1.0);
    let figures = vec![
        count("commands", scope.cases),
        count("taken once and in order", tally.taken),
        count("given up, and said so", tally.abandoned)
            .with("of which the arm took", tally.abandoned_taken as f64),
        count("lost", lost).at_most(0.0),
        count("taken twice", tally.twice).at_most(0.0),
        count("left out or out of order", tally.disordered).at_most(0.0),
        count("altered", tally.altered).at_most(altered),
        count("resumed", tally.resumed)
            .with("after a doubt", tally.doubts as f64)
            .with("after a pulled plug", tally.unplugged as f64),
        count("not resumed", tally.refused),
        Figure::new(
            "exchanges, the stream's reads among them",
            exchanges,
            "a command",
        ),
        Figure::new("sent again", resent, "a command"),
        Figure::new("virtual time", (rig.pair.now - began) as f64 / 1e6, "s"),
    ];
    Ok((rig, figures))
}

/// R1.
pub(super) fn over_corrupted_line(scope: Scope) -> Result<SoakResult, Box<dyn Error>> {
    let (rig, figures) = soak(scope, SERIAL_FAULTS)?;
    Ok(SoakResult {
        figures,
        digest: Some(rig.pair.digest.0),
    })
}

/// R2.
pub(super) fn with_resets(scope: Scope) -> Result<SoakResult, Box<dyn Error>> {
    let faults = Faults {
        unplug: 1e-5,
        reset: 1e-5,
        ..SERIAL_FAULTS
    };
    let (rig, mut figures) = soak(scope, faults)?;
    figures.push(
        Figure::new("resets", f64::from(rig.pair.boots), "")
            .with("told", f64::from(rig.pair.resets)),
    );
    Ok(SoakResult {
        figures,
        digest: Some(rig.pair.digest.0),
    })
}
