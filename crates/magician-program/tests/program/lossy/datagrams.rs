//! A plan over datagrams that are lost, doubled, late and out of order: the host's connection and the arm on one clock, without
//! a shell between them.

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

/// us.
const SECOND: u64 = 1_000_000;
/// A plan that takes longer than that does not end, s.
const LONGEST: u64 = 3600;
/// So often a stream that was interrupted goes on.
const MOST_TURNS: usize = 50;

/// What came of it.
#[derive(Debug)]
pub(crate) struct Came {
    pub(crate) drawing: Drawing,
    /// Why it stopped, and what the arm had taken by then; nothing if it came to its end.
    pub(crate) stopped: Option<(StreamFailure, u64)>,
    /// How often it was interrupted and went on.
    pub(crate) resumed: usize,
    /// How often commands that were doubled on the way were told of.
    pub(crate) told: u32,
    /// Frames sent.
    pub(crate) requests: u64,
    /// How long it took, us.
    pub(crate) lasted: u64,
}

/// Commands with how long they take and where they lead.
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

/// Runs a plan over such a line.
pub(crate) fn draw(plan: &Plan, faults: Faults) -> Result<Came, magician::Error> {
    let mut pair = Pair::new(Settings::DATAGRAMS, faults, faults.seed);
    pair.arm = stage(plan, &RehearseOptions::default())?;
    greet(&mut pair);
    let mut items = items(plan)?.into_iter().peekable();
    let mut stream = Stream::new(StreamSettings::default());
    let (mut resumed, mut taken, mut stopped) = (0, 0, None);
    while stopped.is_none() && !stream.is_over() && pair.now < LONGEST * SECOND {
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
        turn(&mut pair, &mut stream);
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
            && resumed < MOST_TURNS
        {
            (stopped, resumed) = (None, resumed + 1);
            let settings = StreamSettings::default();
            let interrupted = std::mem::replace(&mut stream, Stream::new(settings));
            stream = Stream::resume(interrupted.leftover(), settings);
        }
    }
    let lasted = pair.now;
    pair.set_faults(Faults::NONE);
    let later = pair.now + 60 * SECOND;
    pair.run_until(later);
    Ok(Came {
        drawing: pair.arm.drawing(),
        stopped,
        resumed,
        told: pair.unaccounted,
        requests: pair.host.stats().sent,
        lasted,
    })
}

/// Looks at the arm at rest, as every new connection does; a missing answer is tolerated.
fn greet(pair: &mut Pair) {
    let looks = [
        Request::get::<QueuedCmdLeftSpace>(&NoArgs),
        Request::get::<QueuedCmdCurrentIndex>(&NoArgs),
    ];
    for look in looks.into_iter().flatten() {
        let _ = pair.ask(look, 3 * SECOND);
    }
}

/// What happens until the next instant at which something does.
fn turn(pair: &mut Pair, stream: &mut Stream) {
    stream.advance(pair.now, &mut pair.host);
    let end = pair.now + 10 * SECOND;
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
    // A second copy may have been told of at the same instant as the first.
    for (from, to) in told {
        stream.note_duplicate(from, to);
    }
    stream.advance(pair.now, &mut pair.host);
}
