//! Plan over datagrams that are lost, duplicated, delayed and reordered. The host's connection and
//! the arm share a clock, with no transport between them.

use magician::commands::{QueuedCmdCurrentIndex, QueuedCmdLeftSpace};
use magician::connection::{Failure, Request, Settings};
use magician::faults::Faults;
use magician::pair::Pair;
use magician::preflight::Guards;
use magician::sim::world::Drawing;
use magician::stream::{Item, Stream, StreamEvent, StreamFailure, StreamSettings};
use magician_program::Plan;
use magician_program::rehearse::{RehearseOptions, stage, start_of};
use magician_protocol::NoArgs;

/// Microseconds in a second.
const MICROS_PER_SECOND: u64 = 1_000_000;
/// Duration from which a plan counts as endless, s.
const ENDLESS_SECONDS: u64 = 3600;
/// Largest number of times that an interrupted stream is resumed.
const MAX_RESUMES: usize = 50;

/// Result of the run.
#[derive(Debug)]
pub(crate) struct StreamOutcome {
    pub(crate) drawing: Drawing,
    /// Cause of the stop, and the number of commands taken by then; `None` at a normal end.
    pub(crate) stopped: Option<(StreamFailure, u64)>,
    /// Number of times it was interrupted and resumed.
    pub(crate) resumed: usize,
    /// Number of reported duplicate commands.
    pub(crate) told: u32,
    /// Number of frames sent.
    pub(crate) requests: u64,
    /// Duration, us.
    pub(crate) lasted: u64,
}

/// Commands with their durations and end points.
fn items(plan: &Plan) -> Result<Vec<Item>, magician::Error> {
    let arm = stage(plan, &RehearseOptions::default())?;
    let mut course = start_of(&arm).guards(Guards::NONE);
    let item = |command| {
        let step = course.check(&command)?;
        let end = step.end.map(|end| end.pose);
        Ok(Item {
            command,
            time: u64::try_from(step.time.as_micros()).unwrap_or(u64::MAX),
            end: end.map(|pose| [pose.x, pose.y, pose.z, pose.r]),
            laser: step.laser,
        })
    };
    plan.commands().map(item).collect()
}

/// Runs a plan over this line.
pub(crate) fn draw(plan: &Plan, faults: Faults) -> Result<StreamOutcome, magician::Error> {
    let mut pair = Pair::new(Settings::DATAGRAMS, faults, faults.seed);
    pair.arm = stage(plan, &RehearseOptions::default())?;
    connect(&mut pair);
    let mut items = items(plan)?.into_iter().peekable();
    let mut stream = Stream::new(StreamSettings::default());
    let (mut resumed, mut taken, mut stopped) = (0, 0, None);
    while stopped.is_none() && !stream.is_over() && pair.now < ENDLESS_SECONDS * MICROS_PER_SECOND {
        while stream.room() > 0
            && let Some(item) = items.next_if(|_| true)
        {
            if stream.offer(item).is_err() {
                break;
            }
        }
        if items.peek().is_none() {
            stream.finish();
        }
        exchange(&mut pair, &mut stream);
        while let Some(event) = stream.poll_event() {
            match event {
                StreamEvent::Sent { accepted, .. } => taken = accepted,
                StreamEvent::Failed(failure) => stopped = Some((failure, taken)),
                _ => {}
            }
        }
        if let Some((
            StreamFailure::Request(Failure::Uncertain { .. } | Failure::Timeout { .. }),
            _,
        )) = stopped
            && resumed < MAX_RESUMES
        {
            (stopped, resumed) = (None, resumed + 1);
            let settings = StreamSettings::default();
            let interrupted = std::mem::replace(&mut stream, Stream::new(settings));
            stream = Stream::resume(interrupted.leftover(), settings);
        }
    }
    let lasted = pair.now;
    pair.set_faults(Faults::NONE);
    let later = pair.now + 60 * MICROS_PER_SECOND;
    pair.run_until(later);
    Ok(StreamOutcome {
        drawing: pair.arm.drawing(),
        stopped,
        resumed,
        told: pair.unaccounted,
        requests: pair.host.stats().sent,
        lasted,
    })
}

/// Reads the state of the arm at rest, as every new connection does; a missing reply is tolerated.
fn connect(pair: &mut Pair) {
    let looks = [
        Request::get::<QueuedCmdLeftSpace>(&NoArgs),
        Request::get::<QueuedCmdCurrentIndex>(&NoArgs),
    ];
    for look in looks.into_iter().flatten() {
        let _ = pair.ask(look, 3 * MICROS_PER_SECOND);
    }
}

/// Processes everything up to the next event.
fn exchange(pair: &mut Pair, stream: &mut Stream) {
    stream.advance(pair.now, &mut pair.host);
    let end = pair.now + 10 * MICROS_PER_SECOND;
    let due = stream.poll_timeout().unwrap_or(end);
    pair.step(due.clamp(pair.now, end));
    while pair.arm.poll_event().is_some() {}
    pair.accepted.clear();
    pair.heard.clear();
    let mut told = std::mem::take(&mut pair.reports);
    told.retain(|(from, to)| !stream.note_duplicate(*from, *to));
    let mut ended: Vec<_> = pair.results.drain().collect();
    ended.sort_by_key(|(ticket, _)| *ticket);
    for (ticket, result) in ended {
        stream.answered(pair.now, ticket, &result, &mut pair.host);
    }
    // A second copy may have been reported at the same instant as the first.
    for (from, to) in told {
        stream.note_duplicate(from, to);
    }
    stream.advance(pair.now, &mut pair.host);
}
