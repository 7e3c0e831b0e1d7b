//! Detection of a firmware for 3-D printing, which the arm's controller can run and which answers
//! in text.

use std::time::Duration;

use magician::{RawLine, Target};
use tokio::time::{Instant, timeout_at};

/// Bytes that the vendor's library writes to a new connection. The arm's own firmware ignores them.
const PROBE: &[u8] = b"\nM10\nM10\nM10\nM10\nM10\n";
/// Largest number of received bytes kept: more than such a firmware sends in this time.
const MAX_TEXT_SIZE: usize = 64 * 1024;

/// Firmware that answers in text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Firmware {
    pub(super) name: &'static str,
    pub(super) version: String,
}

/// Sends the probe to a port. Returns `None` if no known firmware answers within this time.
pub(super) fn probe(target: &Target, timeout: Duration) -> Option<Firmware> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .ok()?;
    let found = runtime.block_on(listen(target, timeout));
    found.unwrap_or_else(|error| {
        tracing::debug!("{error}");
        None
    })
}

async fn listen(target: &Target, timeout: Duration) -> magician::Result<Option<Firmware>> {
    let mut line = RawLine::open(target).await?;
    let deadline = Instant::now() + timeout;
    let asked = timeout_at(deadline, line.send(PROBE)).await;
    if let Ok(sent) = asked {
        sent?;
    }
    let mut received = Vec::new();
    let mut bytes = [0; 256];
    while let Ok(count) = timeout_at(deadline, line.receive(&mut bytes)).await {
        let chunk = bytes.get(..count?).unwrap_or_default();
        received.extend_from_slice(chunk);
        let firmware = recognise(&received);
        if firmware.is_some() || received.len() > MAX_TEXT_SIZE {
            return Ok(firmware);
        }
    }
    Ok(None)
}

/// Finds `GRBL: V1.2.3` or `MARLIN: V1.2.3`.
fn recognise(received: &[u8]) -> Option<Firmware> {
    let text = String::from_utf8_lossy(received);
    ["GRBL", "MARLIN"].into_iter().find_map(|name| {
        let mut at = text.match_indices(name);
        let version = at.find_map(|(at, _)| version(text.get(at + name.len()..)?))?;
        Some(Firmware { name, version })
    })
}

/// Parses `: V1.2.3` with any text after it.
fn version(text: &str) -> Option<String> {
    let text = text.strip_prefix(':')?.strip_prefix(char::is_whitespace)?;
    let text = text.strip_prefix('V')?;
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.');
    let mut numbers = text.get(..end.unwrap_or(text.len()))?.split('.');
    let mut number = || numbers.next().filter(|digits| !digits.is_empty());
    Some(format!("{}.{}.{}", number()?, number()?, number()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn firmwares_are_recognised_by_their_text() {
        let recognised = |text: &str| {
            recognise(text.as_bytes()).map(|firmware| (firmware.name, firmware.version))
        };
        assert_eq!(
            recognised("ok\r\nGRBL: V1.2.3\r\n"),
            Some(("GRBL", "1.2.3".into()))
        );
        assert_eq!(
            recognised("MARLIN: V10.0.12.4x"),
            Some(("MARLIN", "10.0.12".into()))
        );
        assert_eq!(
            recognised("GRBL GRBL:\tV0.9.1"),
            Some(("GRBL", "0.9.1".into()))
        );
        for text in [
            "",
            "GRBL",
            "GRBL: 1.2.3",
            "GRBL: V1.2",
            "GRBL: V1..2",
            "grbl: V1.2.3",
        ] {
            assert_eq!(recognised(text), None, "{text}");
        }
        assert_eq!(recognise(&[0xAA; 40]), None);
    }
}
