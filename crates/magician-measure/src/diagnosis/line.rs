//! Diagnosis of the bare line: opening it, identifying the device at its other end, and the number
//! of requests it takes at once.

use std::time::Duration;

use magician::{Action, ErrorKind, LineOptions, RawLine, Setting, SettingValue, Target};

use super::{Advice, Diagnosis, DiagnosisObserver, Finding, Part};
use crate::{
    OTHER_SPEEDS, ProbeReply, QueueTrial, back_to_back, hear_datagrams, listen, queue_trial,
};

/// Longest time for an arm to answer: over Wi-Fi up to 2 s.
const MAX_ANSWER_TIME: Duration = Duration::from_secs(2);
/// Time to listen at each other baud rate. Choice.
const OTHER_BAUD_LISTEN_TIME: Duration = Duration::from_millis(400);
/// Numbers of requests that are tried at once. Choice.
const DEPTHS: [usize; 4] = [1, 2, 4, 8];
/// Repetitions of each depth. Choice.
const ROUNDS: usize = 5;
/// Length of the excerpt of another device's text, characters. Choice.
const EXCERPT_LENGTH: usize = 60;

impl Diagnosis {
    /// Opens the line.
    ///
    /// # Errors
    /// [`NoArm`](super::NoArm).
    pub async fn open<A: DiagnosisObserver>(
        &mut self,
        target: &Target,
        options: LineOptions,
        to: &mut A,
    ) -> Result<RawLine, A::Failure> {
        match RawLine::open_with(target, options).await {
            Ok(line) => {
                let text = match target {
                    Target::Serial(_) => "it opens; no other program uses it",
                    Target::Tcp { .. } => "it accepts a connection",
                    // A datagram line opens without a peer, so this proves nothing more.
                    _ => "it opens",
                };
                self.add(Finding::good("line", text), to)?;
                Ok(line)
            }
            Err(error) => Err(self.end_with("line", error, to)),
        }
    }

    /// Checks that an arm is at the other end; if not, identifies what is there. The reply may take
    /// up to `patience`, 2 s by default.
    ///
    /// # Errors
    /// [`NoArm`](super::NoArm).
    pub async fn hear<A: DiagnosisObserver>(
        &mut self,
        line: &mut RawLine,
        target: &Target,
        patience: Option<Duration>,
        to: &mut A,
    ) -> Result<(), A::Failure> {
        let patience = patience.unwrap_or(MAX_ANSWER_TIME);
        let heard = match target {
            Target::Udp { host, port } => {
                // A separate socket: the line hides that a host refuses datagrams.
                let asked = hear_datagrams(host, *port, patience);
                to.attend("listening", asked).await
            }
            _ => to.attend("listening", listen(line, patience)).await,
        };
        let heard = match heard {
            Ok(heard) => heard,
            Err(error) => return Err(self.end_with("answer", error, to)),
        };
        let (finding, kind) = match heard {
        ProbeReply::Arm([major, minor, revision]) => {
            let firmware = format!("{major}.{minor}.{revision}");
            let finding = Finding::good("answer", format!("an arm, firmware {firmware}"));
            return self.add(finding.value(firmware), to);
        }
        ProbeReply::Frames(count) => (
            Finding::bad("answer", format!("{count} frames of the arm's protocol, none of them \
                the reply"))
                .advise("another program may talk over the same line: close it; then switch the arm off and on"),
            ErrorKind::Unexpected,
        ),
        ProbeReply::Echo => (
            Finding::bad("answer", "the bytes sent come back: a loopback, not an arm")
                .advise("check the cable and its plugs"),
            ErrorKind::Unexpected,
        ),
        ProbeReply::Text(text) => (
            Finding::bad("answer", format!("another device; it sends: {}", excerpt(&text)))
                .value(text)
                .advise(other_port("")),
            ErrorKind::Unexpected,
        ),
        ProbeReply::Refused => (
            Finding::bad("answer", "connection refused: nothing listens at that port")
                .advise("is it the arm's address? The router's list of devices shows it; the arm's \
                    Wi-Fi module listens at port 8899"),
            ErrorKind::Timeout,
        ),
        ProbeReply::Nothing | ProbeReply::Bytes(_) => {
            // A device at another baud rate also looks like silence or random bytes.
            let elsewhere = match target {
                Target::Serial(path) => other_speeds(line, path, OTHER_BAUD_LISTEN_TIME.min(patience), to).await,
                _ => None,
            };
            unknown(&heard, target, elsewhere)
        }
    };
        Err(self.end(finding, kind, to))
    }

    /// Finds how many reads the line takes at once.
    ///
    /// # Errors
    /// Errors of a lost line.
    pub async fn window<A: DiagnosisObserver>(
        &mut self,
        line: &mut RawLine,
        target: &Target,
        to: &mut A,
    ) -> Result<(), A::Failure> {
        let mut answered_depth = 0;
        for depth in DEPTHS {
            let trial = back_to_back(line, depth, ROUNDS, MAX_ANSWER_TIME);
            let seen = to.attend("sending requests back to back", trial).await?;
            // Deeper bursts only lose more.
            if !seen.taken() {
                break;
            }
            answered_depth = depth;
        }
        // Datagrams may overtake each other, so a window there would need more than answered reads.
        self.window = Some(if ordered(target) {
            answered_depth.max(1)
        } else {
            1
        });
        let finding = match answered_depth {
            0 => Finding::bad("back_to_back", "single reads are not all answered")
                .advise("a bad cable or hub: try another, shorter one"),
            1 => Finding::note("back_to_back", "back-to-back requests are not all answered")
                .advise("leave the window at 1"),
            depth if !ordered(target) => Finding::good(
                "back_to_back",
                format!(
                    "{depth} reads sent at once are all answered; but datagrams may overtake each other, so the window stays at 1"
                ),
            ),
            depth => Finding::good(
                "back_to_back",
                format!("{depth} reads sent at once are all answered, in order"),
            ),
        };
        self.add(finding.value(answered_depth).unit("requests"), to)
    }

    /// Adds a note that the queue is not tried without permission.
    ///
    /// # Errors
    /// Errors of the observer.
    pub fn leave_queue<A: DiagnosisObserver>(&mut self, to: &mut A) -> Result<(), A::Failure> {
        let finding = Finding::note("index_law", "not tried, because it uses the queue").advise([
            Part::from("with "),
            (Setting::TryQueue, SettingValue::On).into(),
            ", 15 waits of 0 ms are put into the stopped queue and dropped again; nothing moves"
                .into(),
        ]);
        self.add(finding, to)
    }

    /// Judges a trial of the queue: whether indices, free places and current index follow the rules
    /// that the driver relies on.
    ///
    /// # Errors
    /// The error of the trial, unless commands were in the queue.
    pub fn queue<A: DiagnosisObserver>(
        &mut self,
        trial: magician::Result<QueueTrial>,
        target: &Target,
        to: &mut A,
    ) -> Result<(), A::Failure> {
        let trial = match trial {
            Ok(trial) => trial,
            // Commands wait in the queue, which is no fault of the arm.
            Err(error) if error.kind() == ErrorKind::InvalidInput => {
                let finding = Finding::note("index_law", format!("not tried: {error}")).advise([
                    Part::from("let them finish, or drop them with "),
                    Action::Stop.into(),
                ]);
                return self.add(finding, to);
            }
            Err(error) => return Err(error.into()),
        };
        let given: Vec<_> = trial.indices.iter().flatten().collect();
        let count = trial.indices.len();
        let law = match (trial.steps_by_one(), given.as_slice()) {
            (true, [first, .., last]) => Finding::good(
                "index_law",
                format!(
                    "{count} queued commands have the indices {first} to {last}, one after the other"
                ),
            ),
            _ => Finding::bad(
                "index_law",
                format!(
                    "{count} queued commands have the indices {:?}",
                    trial.indices
                ),
            )
            .advise("a lost reply cannot be recovered on this arm: leave the window at 1"),
        };
        self.add(law.value(given.len()).unit("indices"), to)?;
        let [before, full, after] = trial.left;
        let text = format!(
            "{before} free places, {full} with {count} commands queued, {after} after they were dropped"
        );
        let left = Finding::judged("left_space", trial.left_counts(), text);
        self.add(
            left.value(before)
                .unit("commands")
                .cure("the driver's cross-check does not work on this arm: leave the window at 1"),
            to,
        )?;
        let [before, _, after] = trial.current;
        let text = if trial.current_stands() {
            format!("the current index stays at {before} while nothing runs")
        } else {
            format!("the current index went from {before} to {after} while the queue was stopped")
        };
        let current = Finding::judged("current_index", trial.current_stands(), text);
        self.add(
            current
                .value(after)
                .cure("another program may use the arm: close it and try again"),
            to,
        )?;
        let sound = trial.steps_by_one() && trial.left_counts();
        let reads = self.window.unwrap_or(1);
        // Above 1 the driver resolves a lost reply by these counts, so they must be sound.
        let window = if sound {
            trial.window.min(reads).max(1)
        } else {
            1
        };
        self.window = Some(window);
        let text = match window {
            1 if sound && !ordered(target) => {
                "one request at a time, as datagrams may overtake each other".to_owned()
            }
            1 => "one request at a time".to_owned(),
            some => format!("{some} requests at a time, queued commands too"),
        };
        let finding = Finding::good("window", text).value(window).unit("requests");
        self.add(
            match window {
                1 => finding,
                some => finding.advise([
                    Part::from((Setting::Window, SettingValue::Number(some as f64))),
                    " uses it".into(),
                ]),
            },
            to,
        )
    }
}

/// Puts waits of zero length into the queue and drops them again, for [`Diagnosis::queue`]. Nothing
/// moves.
///
/// # Errors
/// [`InvalidInput`](ErrorKind::InvalidInput) if commands wait in the queue; nothing is added then.
pub async fn try_queue(line: &mut RawLine) -> magician::Result<QueueTrial> {
    queue_trial(line, &DEPTHS, MAX_ANSWER_TIME).await
}

/// Listens at other baud rates than the arm's; returns the first rate with a device.
async fn other_speeds<A: DiagnosisObserver>(
    line: &mut RawLine,
    path: &str,
    listen_time: Duration,
    to: &mut A,
) -> Option<(u32, ProbeReply)> {
    // Closes the port, which has to be opened anew at each rate.
    let (closed_end, _) = tokio::io::duplex(1);
    *line = RawLine::over(closed_end, path);
    let mut at = to.count("listening at other speeds", OTHER_SPEEDS.len() as u64);
    for (done, baud) in (1..).zip(OTHER_SPEEDS) {
        // An adapter that refuses a rate ends the search, which only serves to give a hint.
        let mut other = RawLine::open_at(path, baud).await.ok()?;
        let heard = listen(&mut other, listen_time).await.ok()?;
        // Bytes at a wrong rate look random, so only these two results are conclusive.
        if matches!(heard, ProbeReply::Arm(_) | ProbeReply::Text(_)) {
            return Some((baud, heard));
        }
        at(done);
    }
    None
}

/// Returns the finding for a line without intelligible bytes at the arm's baud rate.
fn unknown(
    heard: &ProbeReply,
    target: &Target,
    elsewhere: Option<(u32, ProbeReply)>,
) -> (Finding, ErrorKind) {
    let unexpected = |text: String, advice: Advice| {
        let finding = Finding::bad("answer", text).advise(advice);
        (finding, ErrorKind::Unexpected)
    };
    match (elsewhere, heard) {
        (Some((baud, ProbeReply::Arm(_))), _) => {
            let (finding, kind) = unexpected(
                format!("an arm answers at {baud} baud; its own speed is 115200"),
                "set the adapter or bridge in between, which keeps its own speed, to 115200 baud"
                    .into(),
            );
            (finding.value(baud).unit("baud"), kind)
        }
        (Some((baud, ProbeReply::Text(text))), _) => unexpected(
            format!(
                "another device; at {baud} baud it sends: {}",
                excerpt(&text)
            ),
            other_port(""),
        ),
        (_, ProbeReply::Bytes(bytes)) => unexpected(
            format!("{} bytes, not from an arm: {}", bytes.len(), hex(bytes)),
            other_port("another device, or one at another speed: "),
        ),
        _ => {
            let hint = match target {
                Target::Udp { .. } => {
                    "is the arm on, and its Wi-Fi module plugged in and its light steady? Is this computer in the same \
                     network, and is the address right? Firewalls and guest networks keep devices apart"
                }
                Target::Tcp { .. } => {
                    "the connection is accepted, but there is no arm behind it, or it is switched \
                        off"
                }
                _ => {
                    "is the arm switched on (its light green, some seconds after the switch)? Is this its port? A \
                     Bluetooth or Wi-Fi module in its socket may occupy the line: pull it out. \
                     Then switch the arm off and on"
                }
            };
            let finding = Finding::bad("answer", "no reply").advise(hint);
            (finding, ErrorKind::Timeout)
        }
    }
}

/// Returns the advice to choose another port, preceded by these words.
fn other_port(before: &'static str) -> Advice {
    Advice::from([
        Part::from(before),
        "choose the arm's port with ".into(),
        Setting::Port.into(),
        "; ".into(),
        Action::ListPorts.into(),
        " lists them".into(),
    ])
}

/// Quotes the beginning of a text.
fn excerpt(text: &str) -> String {
    let begin: String = text.trim().chars().take(EXCERPT_LENGTH).collect();
    format!("{begin:?}")
}

fn hex(bytes: &[u8]) -> String {
    let begin = bytes.iter().take(16).map(|byte| format!("{byte:02x}"));
    let begin: Vec<_> = begin.collect();
    let more = if bytes.len() > begin.len() {
        " ..."
    } else {
        ""
    };
    format!("{}{more}", begin.join(" "))
}

/// True if a line keeps the order of frames, which a window above 1 requires.
fn ordered(target: &Target) -> bool {
    !matches!(target, Target::Udp { .. })
}
