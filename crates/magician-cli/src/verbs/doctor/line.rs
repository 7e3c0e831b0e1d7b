//! The bare line: whether it opens, what is at its other end, and how many requests it takes at once.

use std::time::Duration;

use magician::measure::{Heard, OTHER_SPEEDS, QueueTrial, back_to_back, hear_datagrams, listen};
use magician::{ErrorKind, LineOptions, RawLine, Target};

use super::{Finding, Report};
use crate::failure::Failure;
use crate::output::Output;
use crate::progress::{Bar, attended};

/// How long an arm may take to answer: over Wi-Fi up to 2 s.
const PATIENCE: Duration = Duration::from_secs(2);
/// How long another device gets at each other speed.
const GLIMPSE: Duration = Duration::from_millis(400);
/// Requests at once that are tried, and how often.
const DEPTHS: [usize; 4] = [1, 2, 4, 8];
const ROUNDS: usize = 5;
/// How much of what another device says is shown.
const EXCERPT: usize = 60;

pub(super) async fn open(
    target: &Target,
    options: LineOptions,
    report: &mut Report,
    out: &mut Output,
) -> Result<RawLine, Failure> {
    match RawLine::open_with(target, options).await {
        Ok(line) => {
            let text = match target {
                Target::Serial(_) => "it opens; no other program uses it",
                Target::Tcp { .. } => "it accepts a connection",
                _ => "it opens",
            };
            report.add(Finding::good("line", text), out)?;
            Ok(line)
        }
        Err(error) => Err(report.end_with("line", error, out)),
    }
}

/// Makes sure that an arm is at the other end, or finds out what else is.
pub(super) async fn hear(
    line: &mut RawLine,
    target: &Target,
    patience: Option<Duration>,
    report: &mut Report,
    out: &mut Output,
) -> Result<(), Failure> {
    let patience = patience.unwrap_or(PATIENCE);
    let quiet = report.quiet();
    let heard = match target {
        Target::Udp { host, port } => {
            let asked = hear_datagrams(host, *port, patience);
            attended(quiet, "listening", asked).await
        }
        _ => attended(quiet, "listening", listen(line, patience)).await,
    };
    let heard = match heard {
        Ok(heard) => heard,
        Err(error) => return Err(report.end_with("answer", error, out)),
    };
    let (finding, kind) = match heard {
        Heard::Arm([major, minor, revision]) => {
            let firmware = format!("{major}.{minor}.{revision}");
            let finding = Finding::good("answer", format!("an arm, firmware {firmware}"));
            return report.add(finding.value(firmware), out);
        }
        Heard::Frames(count) => (
            Finding::bad("answer", format!("{count} frames of the arm's protocol, none of them \
                the reply"))
                .hint("another program may talk over the same line: close it; then switch the arm off and on"),
            ErrorKind::Unexpected,
        ),
        Heard::Echo => (
            Finding::bad("answer", "the bytes sent come back: a loopback, not an arm")
                .hint("check the cable and its plugs"),
            ErrorKind::Unexpected,
        ),
        Heard::Text(text) => (
            Finding::bad("answer", format!("another device; it sends: {}", excerpt(&text)))
                .value(text)
                .hint("choose the arm's port with --port; `magician ports` lists them"),
            ErrorKind::Unexpected,
        ),
        Heard::Refused => (
            Finding::bad("answer", "connection refused: nothing listens at that port")
                .hint("is it the arm's address? The router's list of devices shows it; the arm's \
                    Wi-Fi module listens at port 8899"),
            ErrorKind::Timeout,
        ),
        Heard::Nothing | Heard::Bytes(_) => {
            let elsewhere = match target {
                Target::Serial(path) => other_speeds(line, path, GLIMPSE.min(patience), quiet).await,
                _ => None,
            };
            unknown(&heard, target, elsewhere)
        }
    };
    Err(report.end(finding, kind, out))
}

/// Listens at other speeds than the arm's; what was heard, and at which speed.
async fn other_speeds(
    line: &mut RawLine,
    path: &str,
    glimpse: Duration,
    quiet: bool,
) -> Option<(u32, Heard)> {
    // The port has to be free for that.
    let (gone, _) = tokio::io::duplex(1);
    *line = RawLine::over(gone, path);
    let bar = Bar::begin(
        quiet,
        "listening at other speeds",
        OTHER_SPEEDS.len() as u64,
    );
    for (done, baud) in (1..).zip(OTHER_SPEEDS) {
        let mut other = RawLine::open_at(path, baud).await.ok()?;
        let heard = listen(&mut other, glimpse).await.ok()?;
        if matches!(heard, Heard::Arm(_) | Heard::Text(_)) {
            return Some((baud, heard));
        }
        bar.at(done);
    }
    None
}

/// Nothing was understood at the arm's speed.
fn unknown(
    heard: &Heard,
    target: &Target,
    elsewhere: Option<(u32, Heard)>,
) -> (Finding, ErrorKind) {
    let unexpected = |text: String, hint: &str| {
        let finding = Finding::bad("answer", text).hint(hint);
        (finding, ErrorKind::Unexpected)
    };
    match (elsewhere, heard) {
        (Some((baud, Heard::Arm(_))), _) => {
            let (finding, kind) = unexpected(
                format!("an arm answers at {baud} baud; its own speed is 115200"),
                "set the adapter or bridge in between, which keeps its own speed, to 115200 baud",
            );
            (finding.value(baud).unit("baud"), kind)
        }
        (Some((baud, Heard::Text(text))), _) => unexpected(
            format!(
                "another device; at {baud} baud it sends: {}",
                excerpt(&text)
            ),
            "choose the arm's port with --port; `magician ports` lists them",
        ),
        (_, Heard::Bytes(bytes)) => unexpected(
            format!("{} bytes, not from an arm: {}", bytes.len(), hex(bytes)),
            "another device, or one at another speed: choose the arm's port with --port; `magician ports` lists them",
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
            let finding = Finding::bad("answer", "no reply").hint(hint);
            (finding, ErrorKind::Timeout)
        }
    }
}

/// The first line of a text, or two, in quotes.
fn excerpt(text: &str) -> String {
    let begin: String = text.trim().chars().take(EXCERPT).collect();
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

/// How many reads at once it takes.
pub(super) async fn window(
    line: &mut RawLine,
    target: &Target,
    report: &mut Report,
    out: &mut Output,
) -> Result<(), Failure> {
    let mut taken = 0;
    for depth in DEPTHS {
        let trial = back_to_back(line, depth, ROUNDS, PATIENCE);
        let seen = attended(report.quiet(), "sending requests back to back", trial).await?;
        if !seen.taken() {
            break;
        }
        taken = depth;
    }
    report.window = Some(if ordered(target) { taken.max(1) } else { 1 });
    let finding = match taken {
        0 => Finding::bad("back_to_back", "single reads are not all answered")
            .hint("a bad cable or hub: try another, shorter one"),
        1 => Finding::note("back_to_back", "back-to-back requests are not all answered")
            .hint("leave the window at 1"),
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
    report.add(finding.value(taken).unit("requests"), out)
}

/// Whether a line keeps the order of what it carries, which a window above 1 needs.
fn ordered(target: &Target) -> bool {
    !matches!(target, Target::Udp { .. })
}

/// The queue is not tried without leave.
pub(super) fn leave_queue(report: &mut Report, out: &mut Output) -> Result<(), Failure> {
    let finding = Finding::note("index_law", "not tried, because it uses the queue").hint(
        "with --yes, 15 waits of 0 ms are put into the stopped queue and dropped again; \
            nothing moves",
    );
    report.add(finding, out)
}

/// Puts waits of no length into the queue and drops them again.
pub(super) async fn queue_trial(line: &mut RawLine) -> magician::Result<QueueTrial> {
    magician::measure::queue_trial(line, &DEPTHS, PATIENCE).await
}

/// Whether the queue counts as the driver relies on.
pub(super) fn queue(
    trial: magician::Result<QueueTrial>,
    target: &Target,
    report: &mut Report,
    out: &mut Output,
) -> Result<(), Failure> {
    let trial = match trial {
        Ok(trial) => trial,
        Err(error) if error.kind() == ErrorKind::InvalidInput => {
            let finding = Finding::note("index_law", format!("not tried: {error}"))
                .hint("let them finish, or drop them with `magician stop`");
            return report.add(finding, out);
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
        .hint("a lost reply cannot be recovered on this arm: leave the window at 1"),
    };
    report.add(law.value(given.len()).unit("indices"), out)?;
    let [before, full, after] = trial.left;
    let text = format!(
        "{before} free places, {full} with {count} commands queued, {after} after they were dropped"
    );
    let left = Finding::judged("left_space", trial.left_counts(), text);
    report.add(
        left.value(before)
            .unit("commands")
            .cure("the driver's cross-check does not work on this arm: leave the window at 1"),
        out,
    )?;
    let [before, _, after] = trial.current;
    let text = match trial.current_stands() {
        true => format!("the current index stays at {before} while nothing runs"),
        false => {
            format!("the current index went from {before} to {after} while the queue was stopped")
        }
    };
    let current = Finding::judged("current_index", trial.current_stands(), text);
    report.add(
        current
            .value(after)
            .cure("another program may use the arm: close it and try again"),
        out,
    )?;
    let sound = trial.steps_by_one() && trial.left_counts();
    let reads = report.window.unwrap_or(1);
    let window = if sound {
        trial.window.min(reads).max(1)
    } else {
        1
    };
    report.window = Some(window);
    let text = match window {
        1 if sound && !ordered(target) => {
            "one request at a time, as datagrams may overtake each other".to_owned()
        }
        1 => "one request at a time".to_owned(),
        some => format!("{some} requests at a time, queued commands too"),
    };
    let finding = Finding::good("window", text).value(window).unit("requests");
    report.add(
        match window {
            1 => finding,
            some => finding.hint(format!(
                "--window {some} or MAGICIAN_WINDOW={some} uses it, in programs Options::window({some})"
            )),
        },
        out,
    )
}
