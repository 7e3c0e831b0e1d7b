//! Diagnosis of the arm itself: identity, latency, losses, alarms, homing, queue.

use std::time::Duration;

use magician::commands::{
    DeviceName, DeviceSn, DeviceTime, DeviceVersion, Pose, QueuedCmdCurrentIndex,
};
use magician::{Action, Alarm, Arm, QueueIndex};
use magician_protocol::BAUD_RATE;
use tokio::time::Instant;

use super::{Diagnosis, DiagnosisObserver, Finding, Measured, Part};
use crate::{LineSpeed, Timed, round_trips};

/// Latency on a cable above which an adapter or hub delays bytes. Choice, above the default 16 ms
/// of the latency timer of FTDI adapters.
const MAX_TURNAROUND: Duration = Duration::from_millis(20);
/// Largest acceptable jitter: 99th percentile of the latency minus its median. Choice.
const MAX_JITTER: Duration = Duration::from_millis(50);
/// Largest relative error of a measured baud rate. Choice: an arm's crystal is far better, the
/// measurement is not.
const TOLERANCE: f64 = 0.1;
/// Time within which a running queue finishes a command or moves the arm. Choice.
const QUEUE_WATCH_TIME: Duration = Duration::from_secs(2);
/// Interval of readings during [`QUEUE_WATCH_TIME`]. Choice.
const QUEUE_READ_INTERVAL: Duration = Duration::from_millis(100);

impl Diagnosis {
    /// Examines the arm itself, with `count` timed replies of each of two kinds. `serial` is true
    /// for a serial line.
    ///
    /// # Errors
    /// Errors of the driver.
    pub async fn examine<A: DiagnosisObserver>(
        &mut self,
        arm: &Arm,
        count: u64,
        serial: bool,
        to: &mut A,
    ) -> Result<(), A::Failure> {
        identity(arm, self, to).await?;
        let (pose, index) = {
            let mut at = to.count("timing answers", 2 * count);
            let pose = round_trips::<Pose>(arm, count, &mut at).await?;
            // Both kinds share a progress count.
            let more = |done| at(count + done);
            let index = round_trips::<QueuedCmdCurrentIndex>(arm, count, more).await?;
            (pose, index)
        };
        answers(&pose, &index, serial, self, to)?;
        losses(&pose, &index, count, self, to)?;
        alarms(arm, self, to).await?;
        if let Some(fence) = arm.fence() {
            let finding = Finding::good("fence", fence.to_string());
            self.add(finding.value(Measured::Fence(Box::new(fence))), to)?;
        }
        queue(arm, self, to).await
    }
}

async fn identity<A: DiagnosisObserver>(
    arm: &Arm,
    report: &mut Diagnosis,
    to: &mut A,
) -> Result<(), A::Failure> {
    let version = arm.get::<DeviceVersion>().await?;
    let firmware = [
        version.major_version,
        version.minor_version,
        version.revision,
    ];
    let firmware = firmware.map(|number| number.to_string()).join(".");
    let name = arm.get::<DeviceName>().await?.device_name;
    let number = arm.get::<DeviceSn>().await?.device_sn;
    let seconds = arm.get::<DeviceTime>().await?.g_systick / 1000;
    let text = format!("{name}, serial number {number}, firmware {firmware}, on for {seconds} s");
    let value = Measured::Identity {
        name: name.lossy().to_string(),
        serial_number: number.lossy().to_string(),
        firmware,
        uptime_s: seconds,
    };
    report.add(Finding::good("identity", text).value(value), to)
}

fn milliseconds(time: Duration) -> f64 {
    // Three decimal places, which are microseconds.
    (time.as_secs_f64() * 1e6).round() / 1e3
}

fn answers<A: DiagnosisObserver>(
    pose: &Timed,
    index: &Timed,
    serial: bool,
    report: &mut Diagnosis,
    to: &mut A,
) -> Result<(), A::Failure> {
    let Some(line) = LineSpeed::of(pose, index) else {
        return Ok(());
    };
    if serial {
        let finding = match line.baud {
            Some(baud) => {
                let right = (baud / f64::from(BAUD_RATE) - 1.0).abs() <= TOLERANCE;
                let text = format!("bytes pass as at {:.0} baud", baud);
                let finding = if right {
                    Finding::good("line_speed", text)
                } else {
                    // No fault by itself: the arm answers at this rate.
                    Finding::note("line_speed", text)
                };
                finding.value(baud.round()).unit("baud")
            }
            None => Finding::note(
                "line_speed",
                "bytes take no time: a pseudo-terminal, not a serial line",
            ),
        };
        report.add(finding, to)?;
    }
    let turnaround = milliseconds(line.turnaround);
    report.turnaround_ms = Some(turnaround);
    let what = if line.baud.is_some() {
        "without the time of the bytes"
    } else {
        "with the time of the bytes"
    };
    let text = format!("median {turnaround} ms from request to reply, {what}");
    // A network has no fixed latency, so only a cable is judged.
    let finding = Finding::judged(
        "turnaround",
        !serial || line.turnaround <= MAX_TURNAROUND,
        text,
    );
    let finding = finding.value(turnaround).unit("ms");
    report.add(
        finding.cure("an adapter or hub delays bytes: plug the arm directly into the computer"),
        to,
    )?;
    let jitter = milliseconds(line.jitter);
    let text = format!("1 % of the replies are {jitter} ms later");
    let finding = Finding::judged("jitter", !serial || line.jitter <= MAX_JITTER, text);
    let finding = finding.value(jitter).unit("ms");
    report.add(
        finding.cure("the computer or a hub is busy: close other programs, use another USB socket"),
        to,
    )
}

fn losses<A: DiagnosisObserver>(
    pose: &Timed,
    index: &Timed,
    count: u64,
    report: &mut Diagnosis,
    to: &mut A,
) -> Result<(), A::Failure> {
    let both = |of: fn(&Timed) -> u64| of(pose) + of(index);
    let lost = both(|timed| timed.resent);
    let late = both(|timed| timed.late);
    let damaged = both(|timed| timed.noise);
    let foreign = both(|timed| timed.unsolicited);
    let clean = pose.clean() && index.clean();
    let text = if clean {
        format!("{} requests, all answered in time and undamaged", 2 * count)
    } else {
        format!(
            "{} requests: {lost} sent again; {late} replies late, {damaged} damaged, {foreign} \
                unexpected",
            2 * count
        )
    };
    let finding = Finding::judged("losses", clean, text).value(lost + late + damaged + foreign);
    let cure = "use a shorter cable, another USB socket and no hub, away from motors; on Wi-Fi go nearer \
            to the router";
    report.add(finding.cure(cure), to)
}

async fn alarms<A: DiagnosisObserver>(
    arm: &Arm,
    report: &mut Diagnosis,
    to: &mut A,
) -> Result<(), A::Failure> {
    let alarms = arm.alarms().await?;
    if alarms.is_empty() {
        report.add(Finding::good("alarms", "none").value(0_u64), to)?;
    }
    for code in alarms.codes() {
        let known = Alarm::with_code(code);
        let name = known.map_or("unknown to this program", |alarm| alarm.name);
        let cause = known.map_or(String::new(), |alarm| format!(": {}", alarm.cause));
        let text = format!("{code:#04x} {name}{cause}");
        let finding = if Alarm::blocks(code) {
            Finding::bad("alarms", format!("{text}; it holds the queue"))
        } else {
            Finding::note("alarms", text)
        };
        let cure = known.map_or("", |alarm| alarm.remedy);
        let finding = finding.value(u64::from(code));
        let finding = match (Alarm::blocks(code), cure) {
            // Clearing it alone would hide that the positions are wrong.
            _ if code == Alarm::ResetOccurred => finding.advise([
                Part::from(Action::Home),
                " homes it, which clears the alarm".into(),
            ]),
            // The alarm can be cleared without further steps.
            (false, _) | (true, "") => {
                finding.advise([Part::from(Action::ClearAlarms), " clears it".into()])
            }
            (true, cure) => finding.advise([
                Part::from(cure),
                "; then ".into(),
                Action::ClearAlarms.into(),
            ]),
        };
        report.add(finding, to)?;
    }
    let finding = match arm.homing().is_homed().await? {
        Some(true) => return report.add(Finding::good("homed", "yes, since power-up"), to),
        Some(false) => "no, not since power-up (alarm 0x00)",
        None => {
            "unknown: this computer saw no homing since power-up, and the arm does not report it"
        }
    };
    // Only a note: an arm not homed works, but its positions are off.
    let finding = Finding::note("homed", finding).advise([
        Part::from(Action::Home),
        " corrects its positions; it moves through much of its range".into(),
    ]);
    report.add(finding, to)
}

async fn queue<A: DiagnosisObserver>(
    arm: &Arm,
    report: &mut Diagnosis,
    to: &mut A,
) -> Result<(), A::Failure> {
    let (_, capacity) = arm.stats().await?;
    let waiting = capacity.saturating_sub(arm.queue().left_space().await?);
    let current = arm.queue().current_index().await?;
    if waiting == 0 {
        let finished = match current.0 {
            0 => "nothing yet".to_owned(),
            index => format!("up to index {index}"),
        };
        let text = format!("empty, room for {capacity}, finished {finished}");
        return report.add(
            Finding::good("queue", text).value(0_u64).unit("commands"),
            to,
        );
    }
    let watched = to.attend("watching the queue", runs(arm, current));
    let commands = match waiting {
        1 => "1 command is in it".to_owned(),
        more => format!("{more} commands are in it"),
    };
    let finding = if watched.await? {
        Finding::note("queue", format!("{commands}, and it runs"))
    } else {
        Finding::bad(
            "queue",
            format!(
                "{commands}; in {} s none finished and the arm did not move: the queue is \
                stopped, or a wait runs",
                QUEUE_WATCH_TIME.as_secs()
            ),
        )
        .advise([
            Part::from(Action::Stop),
            " drops what an earlier program left, ".into(),
            Action::StartQueue.into(),
            " runs it: the arm may move".into(),
        ])
    };
    report.add(finding.value(waiting).unit("commands"), to)
}

/// True if a queued command finishes or the arm moves.
async fn runs(arm: &Arm, since: QueueIndex) -> magician::Result<bool> {
    let begun = Instant::now();
    let stood = arm.get::<Pose>().await?;
    while begun.elapsed() < QUEUE_WATCH_TIME {
        tokio::time::sleep(QUEUE_READ_INTERVAL).await;
        // Either is enough: a long motion finishes no command, and a wait moves nothing.
        if arm.queue().current_index().await? > since || arm.get::<Pose>().await? != stood {
            return Ok(true);
        }
    }
    Ok(false)
}
