//! Checks of a station from outside: reachable, access granted, arms present, clock in step.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use magician::Alarm;
use magician_measure::{Diagnosis, DiagnosisObserver, Finding};
use magician_station::client::{ClientError, StationAddress, StationClient, Trust};
use serde_json::{Value, json};
use tokio::time::timeout;

use super::report::FindingPrinter;
use crate::failure::Failure;

/// Number of timed requests.
const TIMED_REQUESTS: usize = 20;
/// Longest wait for an answer. A station that takes longer counts as not answering.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(5);
/// Difference between the clocks of station and client from which it is reported, s.
const MAX_CLOCK_DIFFERENCE: f64 = 2.0;

/// Address of the station, and the credentials for it.
pub(super) struct StationAccess<'a> {
    pub(super) url: &'a str,
    pub(super) token: Option<String>,
    pub(super) trust: Trust,
}

type Outcome<T = ()> = Result<T, Failure>;

/// Runs all checks of a station.
pub(super) async fn examine(
    found: &mut Diagnosis,
    access: &StationAccess<'_>,
    to: &mut FindingPrinter<'_>,
) -> Outcome {
    let address: StationAddress = access.url.parse().map_err(Failure::invalid)?;
    found.port = Some(access.url.to_owned());
    let connecting = StationClient::connect_trusting(
        access.url,
        "magician doctor",
        access.token.as_deref(),
        &access.trust,
    );
    let station = match to.attend("connecting to the station", connecting).await {
        Ok(station) => station,
        Err(error) => return report_refusal(found, &address, error, to),
    };
    found.add(
        Finding::good("station", format!("{} answers", address.host)),
        to,
    )?;
    encryption(found, &address, to)?;
    let hello = station.hello().clone();
    versions(found, &hello, to)?;
    role(found, &hello, access.token.is_some(), to)?;
    measure_latency(found, &station, to).await?;
    let list = call(&station, "arm.list", json!({})).await?;
    let arms = list["arms"].as_array().cloned().unwrap_or_default();
    let chosen =
        |arm: &&Value| address.arm.is_none() || arm["name"].as_str() == address.arm.as_deref();
    let chosen: Vec<_> = arms.iter().filter(chosen).collect();
    if chosen.is_empty() {
        let names: Vec<_> = arms.iter().filter_map(|arm| arm["name"].as_str()).collect();
        let text = format!("no such arm: the station has {}", names.join(", "));
        found.add(Finding::bad("arm", text), to)?;
    }
    for arm in chosen {
        arm_of(found, &station, arm, to).await?;
    }
    Ok(())
}

/// Reports why no session could be opened.
fn report_refusal(
    found: &mut Diagnosis,
    address: &StationAddress,
    error: ClientError,
    to: &mut FindingPrinter<'_>,
) -> Outcome {
    let text = error.to_string();
    let finding = match &error {
        ClientError::Untrusted(_) => Finding::bad("certificate", text)
            .cure("--station-ca FILE gives the certificates to trust; the host name in the URL \
                must be one of the certificate's names"),
        ClientError::Refused { .. } => Finding::bad("token", text)
            .cure("`magician station token` on the station's computer creates one; set MAGICIAN_TOKEN to it"),
        _ => Finding::bad("station", text).cure(if address.encrypted {
            "is `magician serve` running there, with --listen and the port of the URL?"
        } else {
            "is `magician serve` running there, with --listen and the port of the URL? An encrypted one needs https://"
        }),
    };
    found.add(finding, to)?;
    found.ended = true;
    Err(error.into())
}

fn encryption(
    found: &mut Diagnosis,
    address: &StationAddress,
    to: &mut FindingPrinter<'_>,
) -> Outcome {
    let near = ["localhost:", "127.0.0.1:", "[::1]:"];
    let near = near.iter().any(|host| address.host.starts_with(host));
    let finding = match (address.encrypted, near) {
        (true, _) => Finding::good(
            "encryption",
            "the connection is encrypted, the certificate is trusted",
        ),
        (false, true) => Finding::note(
            "encryption",
            "not encrypted, but the connection stays within this computer",
        ),
        (false, false) => Finding::note(
            "encryption",
            "not encrypted: others on the network can read the token",
        )
        .cure("`magician serve --tls-cert FILE --tls-key FILE` encrypts"),
    };
    found.add(finding, to)
}

fn versions(found: &mut Diagnosis, hello: &Value, to: &mut FindingPrinter<'_>) -> Outcome {
    let (version, own) = (
        hello["version"].as_str().unwrap_or_default(),
        env!("CARGO_PKG_VERSION"),
    );
    let finding = match (hello["api"] == json!(1), version == own) {
        (true, true) => Finding::good("version", format!("{version}, same as here")),
        (true, false) => {
            Finding::note("version", format!("{version}, here {own}: both know API 1"))
        }
        (false, _) => Finding::bad(
            "version",
            format!("{version} has API {}, this program API 1", hello["api"]),
        ),
    };
    found.add(finding.value(version), to)
}

fn role(
    found: &mut Diagnosis,
    hello: &Value,
    by_token: bool,
    to: &mut FindingPrinter<'_>,
) -> Outcome {
    let role = hello["role"].as_str().unwrap_or_default();
    let right = if by_token {
        "by the token"
    } else {
        "without a token"
    };
    let finding = match role {
        "viewer" => Finding::note(
            "role",
            format!("viewer, {right}: may watch and stop, but not move"),
        )
        .cure(
            "`magician station token --role student` creates a token that may move the arm, \
                unless the station was started with --read-only",
        ),
        role => Finding::good("role", format!("{role}, {right}")),
    };
    found.add(finding.value(role), to)
}

/// Measures the latency of requests.
async fn measure_latency(
    found: &mut Diagnosis,
    station: &StationClient,
    to: &mut FindingPrinter<'_>,
) -> Outcome {
    let mut times = Vec::new();
    for _ in 0..TIMED_REQUESTS {
        let began = Instant::now();
        call(station, "server.info", json!({})).await?;
        times.push(began.elapsed());
    }
    times.sort();
    // The median ignores single delays, such as that of the first request.
    let median = times.get(TIMED_REQUESTS / 2).copied().unwrap_or_default();
    let median = (median.as_secs_f64() * 1e5).round() / 100.0;
    let text = format!("median {median} ms from request to response");
    found.add(Finding::good("answers", text).value(median).unit("ms"), to)
}

async fn arm_of(
    found: &mut Diagnosis,
    station: &StationClient,
    arm: &Value,
    to: &mut FindingPrinter<'_>,
) -> Outcome {
    let name = arm["name"].as_str().unwrap_or_default();
    let port = arm["port"].as_str().unwrap_or_default();
    let kind = if arm["virtual"] == json!(true) {
        "a virtual arm"
    } else {
        "an arm"
    };
    let up = arm["link"] == json!("up");
    let finding = if up {
        Finding::good("arm", format!("{name}: {kind} at {port}"))
    } else {
        Finding::bad("arm", format!("{name}: the line to {port} is lost"))
            .cure("is the arm switched on and plugged in? The station keeps trying to reconnect")
    };
    found.add(finding.value(name), to)?;
    let (holder, job) = (&arm["holder"]["name"], arm["job"].as_str());
    let lease = match (holder.as_str(), job) {
        (None, None) => Finding::good("lease", format!("{name}: free")),
        (None, Some(job)) => Finding::note("lease", format!("{name}: free; running job {job}")),
        (Some(holder), None) => Finding::note("lease", format!("{name}: held by {holder}")),
        (Some(holder), Some(job)) => Finding::note(
            "lease",
            format!("{name}: held by {holder}; running job {job}"),
        ),
    };
    found.add(lease.value(holder.as_str().unwrap_or_default()), to)?;
    if !up {
        return Ok(());
    }
    let this = json!({"arm": name});
    let alarms = call(station, "arm.alarms", this.clone()).await?;
    let alarms = alarms["alarms"].as_array().cloned().unwrap_or_default();
    if alarms.is_empty() {
        found.add(Finding::good("alarms", format!("{name}: none")), to)?;
    }
    for alarm in alarms {
        let text = |field: &str| alarm[field].as_str().unwrap_or_default().to_owned();
        let said = format!("{name}: {}: {}", text("name"), text("cause"));
        let finding = if alarm["holds_queue"] == json!(true) {
            Finding::bad("alarms", format!("{said}; it holds the queue"))
        } else {
            Finding::note("alarms", said)
        };
        let code = alarm["code"].as_u64().unwrap_or_default();
        let cure = if code == u64::from(Alarm::ResetOccurred) {
            "`magician home` with this --station homes it"
        } else {
            "`magician alarms --clear` with this --station clears it"
        };
        let finding = finding.value(code).cure(cure);
        found.add(finding, to)?;
    }
    let state = call(station, "arm.state", this).await?;
    let homed = match state["homed"].as_bool() {
        Some(true) => Finding::good("homed", format!("{name}: yes, since power-up")),
        Some(false) => Finding::note("homed", format!("{name}: no, not since power-up")),
        None => Finding::note(
            "homed",
            format!("{name}: unknown: the station saw no homing"),
        ),
    };
    found.add(homed, to)?;
    clock(found, state["t"].as_f64().unwrap_or_default(), to)
}

/// Compares the clocks, once: the station's clock stamps all states and events.
fn clock(found: &mut Diagnosis, there: f64, to: &mut FindingPrinter<'_>) -> Outcome {
    if found.findings.iter().any(|known| known.check == "clock") {
        return Ok(());
    }
    let here = SystemTime::now().duration_since(UNIX_EPOCH);
    let ahead = there - here.map_or(0.0, |here| here.as_secs_f64());
    let finding = if ahead.abs() <= MAX_CLOCK_DIFFERENCE {
        Finding::good("clock", "same time as this computer")
    } else {
        let side = if ahead > 0.0 { "ahead of" } else { "behind" };
        let text = format!("{:.0} s {side} this computer", ahead.abs());
        Finding::note("clock", text)
            .cure("states and events carry the time of the station's clock: synchronise both clocks (NTP)")
    };
    found.add(finding.value((ahead * 10.0).round() / 10.0).unit("s"), to)
}

async fn call(station: &StationClient, method: &str, params: Value) -> Outcome<Value> {
    let answer = timeout(ANSWER_TIMEOUT, station.call(method, params)).await;
    Ok(answer.unwrap_or(Err(ClientError::Lost))?)
}
