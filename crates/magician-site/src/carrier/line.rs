//! One end of a session on the network: packets out and in, and whether the other end is there.

use std::collections::VecDeque;
use std::time::Duration;

use tokio::sync::{mpsc, watch};
use tokio::time::{Instant, sleep_until};
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::{CongestionControl, Priority};
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Session, Wait};

use super::patiently;
use crate::WINDOW;
use crate::message::{BadPacket, Flow, Packet};

/// An end that takes nothing for so long is cut off.
const STUCK: Duration = Duration::from_secs(10);
/// What was on its way when the other end left may come for so long.
const BEHIND: Duration = Duration::from_millis(200);
/// Packets that wait to be looked at: more than an end that keeps to the window sends.
const PACKETS: usize = 4 * WINDOW;

/// The keys of one end.
pub(super) struct Ends {
    /// What it publishes under.
    pub(super) to: String,
    /// What it hears.
    pub(super) from: String,
    /// Its own token.
    pub(super) own: String,
    /// That of the other end.
    pub(super) other: String,
}

/// One end. Dropping it takes its token away.
pub(super) struct Line {
    publisher: Publisher<'static>,
    packets: mpsc::Receiver<Vec<u8>>,
    gone: watch::Receiver<bool>,
    _subscriber: Subscriber<()>,
    _other: Subscriber<()>,
    _token: LivelinessToken,
}

impl Line {
    /// Listens, and is there. On the runtime of the connection.
    pub(super) async fn open(session: &Session, ends: &Ends) -> zenoh::Result<Self> {
        let (packet, packets) = mpsc::channel(PACKETS);
        let hear = move |sample: Sample| {
            // One that does not fit is missing, which ends the channel.
            let _ = packet.try_send(sample.payload().to_bytes().into_owned());
        };
        let subscriber = session
            .declare_subscriber(ends.from.clone())
            .callback(hear)
            .await?;
        let (leaves, gone) = watch::channel(false);
        let other = session
            .liveliness()
            .declare_subscriber(ends.other.clone())
            .history(true)
            .callback(move |sample: Sample| {
                if sample.kind() == SampleKind::Delete {
                    let _ = leaves.send(true);
                }
            })
            .await?;
        let publisher = session
            .declare_publisher(ends.to.clone())
            .congestion_control(CongestionControl::Block)
            .priority(Priority::InteractiveHigh)
            .express(true)
            .await?;
        let token = session.liveliness().declare_token(ends.own.clone()).await?;
        Ok(Self {
            publisher,
            packets,
            gone,
            _subscriber: subscriber,
            _other: other,
            _token: token,
        })
    }

    /// Carries messages until one of the two ends.
    pub(super) async fn carry<Out, In>(
        self,
        mut outgoing: mpsc::Receiver<Out>,
        incoming: mpsc::Sender<In>,
    ) where
        Out: Into<Packet>,
        In: TryFrom<Packet, Error = BadPacket>,
    {
        let Self {
            publisher,
            mut packets,
            mut gone,
            _subscriber,
            _other,
            _token,
        } = self;
        let put = |bytes: Vec<u8>| patiently(|| publisher.put(bytes).wait());
        let mut flow = Flow::default();
        let mut waiting = VecDeque::new();
        let mut is_last = false;
        let mut full_since: Option<Instant> = None;
        let mut gone_since: Option<Instant> = None;
        let farewell = Packet::Close(1000, String::new());
        loop {
            if is_last && waiting.is_empty() {
                return;
            }
            let may_send = flow.may_send();
            full_since = match (may_send, full_since) {
                (true, _) => None,
                (false, since) => since.or_else(|| Some(Instant::now())),
            };
            let ends = [
                full_since.map(|t| t + STUCK),
                gone_since.map(|t| t + BEHIND),
            ];
            let end = ends.into_iter().flatten().min();
            tokio::select! {
                biased;
                bytes = packets.recv(), if !is_last => {
                    let packet = bytes.and_then(|bytes| flow.unpack(&bytes).ok());
                    let closes = matches!(packet, Some(Packet::Close(..)));
                    match packet {
                        Some(Packet::Taken(_)) => {}
                        Some(packet) => match In::try_from(packet) {
                            Ok(message) => {
                                waiting.push_back(message);
                                is_last = closes;
                            }
                            Err(BadPacket) => return,
                        },
                        None => return,
                    }
                }
                place = incoming.reserve(), if !waiting.is_empty() => {
                    let (Ok(place), Some(message)) = (place, waiting.pop_front()) else {
                        let _ = put(flow.pack(&farewell));
                        return;
                    };
                    place.send(message);
                    let told = (!is_last).then(|| flow.took()).flatten();
                    if told.is_some_and(|told| put(flow.pack(&told)).is_err()) {
                        return;
                    }
                }
                message = outgoing.recv(), if may_send => {
                    let packet = message.map_or_else(|| farewell.clone(), Into::into);
                    let closes = matches!(packet, Packet::Close(..));
                    if put(flow.pack(&packet)).is_err() || closes {
                        return;
                    }
                }
                () = incoming.closed() => {
                    let _ = put(flow.pack(&farewell));
                    return;
                }
                _ = gone.wait_for(|gone| *gone), if gone_since.is_none() => {
                    gone_since = Some(Instant::now());
                }
                () = until(end) => return,
            }
        }
    }
}

async fn until(end: Option<Instant>) {
    match end {
        Some(end) => sleep_until(end).await,
        None => std::future::pending().await,
    }
}
