//! Trials with bare frames: does the arm take requests back to back, and does its queue count
//! correctly?

use std::time::Duration;

use magician::connection::Settings;
use magician::{Error, ErrorCode, RawLine, Result};
use magician_protocol::commands::{
    AlarmsState, Pose, QueuedCmdClear, QueuedCmdCurrentIndex, QueuedCmdLeftSpace,
    QueuedCmdStopExec, WaitCmd,
};
use magician_protocol::{
    Ctrl, Deframer, Event, FrameBuf, Layout, NoArgs, QueuedCmdIndex, Readable, Row, Writable,
};
use tokio::time::{Instant, timeout_at};

/// Result of requests sent back to back, in a single write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BackToBack {
    /// Number of requests at once.
    pub depth: usize,
    /// Number of repetitions.
    pub rounds: usize,
    /// Total number of answered requests.
    pub answered: usize,
    /// True if every answer came in the order of the requests.
    pub in_order: bool,
}

impl BackToBack {
    /// True if everything was answered, in order.
    #[must_use]
    pub fn taken(&self) -> bool {
        self.in_order && self.answered == self.depth * self.rounds
    }
}

/// Result of a trial of the queue with commands that do nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct QueueTrial {
    /// Indices in order; `None` for a command whose answer has no index.
    pub indices: Vec<Option<u64>>,
    /// Sizes of the bursts.
    pub depths: Vec<usize>,
    /// Size of the last burst before the first index that was missing or out of sequence.
    pub window: usize,
    /// Free places before the trial, with all commands in the queue, and after they were dropped.
    pub left: [u32; 3],
    /// Current index before the trial, with all commands in the queue, and after they were dropped.
    pub current: [u64; 3],
}

impl QueueTrial {
    /// True if the indices are consecutive.
    #[must_use]
    pub fn steps_by_one(&self) -> bool {
        let pairs = self.indices.windows(2);
        self.indices.iter().all(Option::is_some)
            && pairs.into_iter().all(|pair| match pair {
                [Some(one), Some(next)] => one.checked_add(1) == Some(*next),
                _ => false,
            })
    }

    /// True if every command takes a place, and dropping it frees the place.
    #[must_use]
    pub fn left_counts(&self) -> bool {
        let [before, full, after] = self.left;
        let taken = u32::try_from(self.indices.len()).unwrap_or(u32::MAX);
        before.checked_sub(taken) == Some(full) && after == before
    }

    /// True if the current index does not change while nothing runs, nor when the queue is cleared.
    #[must_use]
    pub fn current_stands(&self) -> bool {
        let [before, full, after] = self.current;
        before == full && full == after
    }
}

/// Reads in the order of sending; neighbours differ, so that swapped answers show.
const READS: [&Row; 4] = [
    <Pose as Readable>::ROW,
    QueuedCmdCurrentIndex::ROW,
    QueuedCmdLeftSpace::ROW,
    <AlarmsState as Readable>::ROW,
];
/// Sends `depth` reads in a single write, `rounds` times, and counts the answers within `patience`.
///
/// # Errors
/// [`ErrorKind::Port`](magician::ErrorKind::Port) if the line is gone.
pub async fn back_to_back(
    line: &mut RawLine,
    depth: usize,
    rounds: usize,
    patience: Duration,
) -> Result<BackToBack> {
    let mut seen = BackToBack {
        depth,
        rounds,
        answered: 0,
        in_order: true,
    };
    let reads = READS.iter().cycle().take(depth);
    let requests: std::result::Result<Vec<_>, _> =
        reads.map(|row| FrameBuf::get(&NoArgs, row)).collect();
    let requests = requests?;
    for _ in 0..rounds {
        let replies = burst(line, &requests, patience).await?;
        seen.answered += replies.len();
        let ordered = replies.len() <= requests.len()
            && replies.iter().zip(&requests).all(|(reply, request)| {
                (reply.frame().id(), reply.frame().ctrl())
                    == (request.frame().id(), request.frame().ctrl())
            });
        // A lost reply shifts all that follow, so their order says nothing; `answered` counts the
        // loss.
        seen.in_order &= ordered || replies.len() < requests.len();
    }
    Ok(seen)
}

/// Sends frames in a single write. Collects one reply for each, or the replies within
/// `patience`.
async fn burst(
    line: &mut RawLine,
    requests: &[FrameBuf],
    patience: Duration,
) -> Result<Vec<FrameBuf>> {
    let bytes: Vec<u8> = requests
        .iter()
        .flat_map(|frame| frame.bytes())
        .copied()
        .collect();
    line.send(&bytes).await?;
    let until = Instant::now() + patience;
    let mut deframer = Deframer::new();
    let mut replies = Vec::new();
    let mut bytes = [0; 512];
    while replies.len() < requests.len() {
        let Ok(count) = timeout_at(until, line.receive(&mut bytes)).await else {
            break;
        };
        let mut rest = bytes.get(..count?).unwrap_or_default();
        while let Some(event) = deframer.next(&mut rest) {
            if let Event::Frame { frame, .. } = event {
                replies.push(FrameBuf::from(frame));
            }
        }
    }
    Ok(replies)
}

async fn ask(line: &mut RawLine, request: FrameBuf, patience: Duration) -> Result<FrameBuf> {
    let key = (request.frame().id(), request.frame().ctrl());
    // Three attempts: a single lost frame must not fail the whole trial.
    for _ in 0..3 {
        let replies = burst(line, &[request], patience).await?;
        let own = |reply: &FrameBuf| (reply.frame().id(), reply.frame().ctrl()) == key;
        if let Some(reply) = replies.into_iter().find(own) {
            return Ok(reply);
        }
    }
    let message = format!("{}: no answer", line.name());
    Err(Error::new(ErrorCode::NoAnswer, message))
}

/// Reads current index and left space.
async fn look(line: &mut RawLine, patience: Duration) -> Result<(u64, u32)> {
    let current = FrameBuf::get(&NoArgs, QueuedCmdCurrentIndex::ROW)?;
    let current = ask(line, current, patience).await?;
    let current = QueuedCmdCurrentIndex::decode(current.frame().params())?;
    let left = FrameBuf::get(&NoArgs, QueuedCmdLeftSpace::ROW)?;
    let left = ask(line, left, patience).await?;
    let left = QueuedCmdLeftSpace::decode(left.frame().params())?;
    Ok((current.queued_cmd_current_index, left.left_space))
}

async fn set<T: Writable>(line: &mut RawLine, action: &T, patience: Duration) -> Result<()> {
    let request = FrameBuf::encode(T::ROW.id, Ctrl::SET, action)?;
    ask(line, request, patience).await.map(drop)
}

/// Stops the queue, fills it with bursts of waits of zero length, reads its counters, and clears
/// it. Nothing moves; the queue is left stopped and empty.
///
/// # Errors
/// [`ErrorKind::InvalidInput`](magician::ErrorKind::InvalidInput) if commands wait in the queue, or
/// arrive meanwhile: they are not dropped; [`ErrorKind::Timeout`](magician::ErrorKind::Timeout),
/// [`ErrorKind::Port`](magician::ErrorKind::Port).
pub async fn queue_trial(
    line: &mut RawLine,
    depths: &[usize],
    patience: Duration,
) -> Result<QueueTrial> {
    let before = look(line, patience).await?;
    let waiting = Settings::ORDERED.capacity.saturating_sub(before.1);
    if waiting > 0 {
        let message = format!("commands of an earlier program wait in the queue: {waiting}");
        return Err(Error::new(ErrorCode::ForeignCommands, message));
    }
    // Stopped first, so that the waits stay in the queue and can be counted.
    set(line, &QueuedCmdStopExec {}, patience).await?;
    let wait = FrameBuf::encode(WaitCmd::ROW.id, Ctrl::QUEUED, &WaitCmd { timeout: 0 })?;
    let mut trial = QueueTrial {
        depths: depths.to_vec(),
        ..QueueTrial::default()
    };
    for depth in depths {
        let replies = burst(line, &vec![wait; *depth], patience).await?;
        let given = |at: usize| {
            let reply = replies.get(at)?;
            let own = reply.frame().id() == WaitCmd::ROW.id && reply.frame().ctrl() == Ctrl::QUEUED;
            let index = QueuedCmdIndex::decode(reply.frame().params()).ok()?;
            own.then_some(index.0)
        };
        trial.indices.extend((0..*depth).map(given));
        // A larger burst could only confuse the indices further.
        if !trial.steps_by_one() {
            break;
        }
        trial.window = *depth;
    }
    let full = look(line, patience).await?;
    let waiting = Settings::ORDERED.capacity.saturating_sub(full.1);
    // Clearing now would drop the other program's commands too.
    if usize::try_from(waiting).is_ok_and(|waiting| waiting > trial.indices.len()) {
        let message = "another program queued commands meanwhile, so nothing was dropped: the \
            waits of 0 ms are still among them, and the queue is stopped";
        return Err(Error::invalid(message));
    }
    set(line, &QueuedCmdClear {}, patience).await?;
    let after = look(line, patience).await?;
    trial.left = [before.1, full.1, after.1];
    trial.current = [before.0, full.0, after.0];
    Ok(trial)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATIENCE: Duration = Duration::from_secs(1);

    async fn line() -> RawLine {
        RawLine::open(&"sim:1".parse().unwrap()).await.unwrap()
    }

    #[tokio::test(start_paused = true)]
    async fn a_virtual_arm_takes_requests_back_to_back() {
        let mut line = line().await;
        for depth in [1, 2, 4, 8] {
            let seen = back_to_back(&mut line, depth, 3, PATIENCE).await.unwrap();
            assert!(seen.taken(), "{seen:?}");
        }
    }

    #[tokio::test(start_paused = true)]
    async fn a_virtual_arm_counts_and_is_left_empty() {
        let mut line = line().await;
        let trial = queue_trial(&mut line, &[1, 2, 4, 8], PATIENCE)
            .await
            .unwrap();
        assert_eq!(trial.indices.len(), 15);
        assert!(trial.steps_by_one() && trial.left_counts() && trial.current_stands());
        assert_eq!((trial.window, trial.left), (8, [32, 17, 32]));
        let again = queue_trial(&mut line, &[1], PATIENCE).await.unwrap();
        assert_eq!(again.indices, [Some(17)]);
    }

    #[tokio::test(start_paused = true)]
    async fn commands_of_another_program_are_left_alone() {
        let mut line = line().await;
        let wait = FrameBuf::encode(WaitCmd::ROW.id, Ctrl::QUEUED, &WaitCmd { timeout: 9 });
        burst(&mut line, &[wait.unwrap(); 1], PATIENCE)
            .await
            .unwrap();
        let refused = queue_trial(&mut line, &[1], PATIENCE).await.unwrap_err();
        assert_eq!(refused.kind(), magician::ErrorKind::InvalidInput);
        assert_eq!(look(&mut line, PATIENCE).await.unwrap(), (0, 31));
    }

    /// Simulates an arm whose queue receives twenty commands of another program during the trial.
    async fn shared(mut far: tokio::io::DuplexStream) {
        use tokio::io::{AsyncReadExt, AsyncWriteExt};
        let mut arm = magician_sim::Controller::default();
        let theirs =
            FrameBuf::encode(WaitCmd::ROW.id, Ctrl::QUEUED, &WaitCmd { timeout: 9 }).unwrap();
        let mut bytes = [0; 512];
        let mut stopped = false;
        while let Ok(count @ 1..) = far.read(&mut bytes).await {
            let came = &bytes[..count];
            arm.receive(magician_sim::LinkId(0), came);
            if !stopped && came.get(3) == Some(&QueuedCmdStopExec::ROW.id) {
                stopped = true;
                (0..20).for_each(|_| arm.receive(magician_sim::LinkId(1), theirs.bytes()));
            }
            assert_ne!(
                came.get(3),
                Some(&QueuedCmdClear::ROW.id),
                "their commands are dropped"
            );
            while let Some(reply) = arm.poll_transmit(magician_sim::LinkId(0)) {
                far.write_all(reply.bytes()).await.unwrap();
            }
        }
    }

    #[tokio::test(start_paused = true)]
    async fn commands_that_come_meanwhile_are_not_dropped() {
        let (near, far) = tokio::io::duplex(1 << 12);
        let arm = tokio::spawn(shared(far));
        let mut line = RawLine::over(near, "shared");
        let refused = queue_trial(&mut line, &[1, 2], PATIENCE).await.unwrap_err();
        assert_eq!(refused.kind(), magician::ErrorKind::InvalidInput);
        drop(line);
        arm.await.unwrap();
    }

    #[test]
    fn wrong_indices_free_places_and_current_index_are_detected() {
        let trial = |indices: &[Option<u64>], left, current| QueueTrial {
            indices: indices.to_vec(),
            left,
            current,
            ..QueueTrial::default()
        };
        let right = trial(&[Some(4), Some(5)], [32, 30, 32], [3, 3, 3]);
        assert!(right.steps_by_one() && right.left_counts() && right.current_stands());
        let wrong = trial(&[Some(4), None, Some(6)], [32, 30, 31], [3, 4, 4]);
        assert!(!wrong.steps_by_one() && !wrong.left_counts() && !wrong.current_stands());
        assert!(!trial(&[Some(4), Some(6)], [0; 3], [0; 3]).steps_by_one());
        assert!(!trial(&[Some(u64::MAX), Some(0)], [0; 3], [0; 3]).steps_by_one());
    }
}
