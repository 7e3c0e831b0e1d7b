//! Identification of the device at the other end of a line, which may not be an arm.

use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::time::Duration;

use magician::{Error, RawLine, Result};
use magician_protocol::commands::DeviceVersion;
use magician_protocol::{Ctrl, Deframer, Event, FrameBuf, Layout, NoArgs, Readable};
use tokio::net::{UdpSocket, lookup_host};
use tokio::time::{Instant, timeout, timeout_at};

/// Baud rates other than the arm's, common among devices with the same adapters.
pub const OTHER_SPEEDS: [u32; 7] = [9600, 19_200, 38_400, 57_600, 230_400, 250_000, 1_000_000];

/// Bytes examined. Choice.
const MAX_EXAMINED_BYTES: usize = 512;
/// Silence after received bytes that ends listening. Choice: longer than a pause within an answer.
const PAUSE: Duration = Duration::from_millis(150);

/// Answer to the request for the version.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ProbeReply {
    /// An arm, with its firmware version: major, minor, revision.
    Arm([u8; 3]),
    /// Frames of the protocol without the answer: another program may share the line.
    Frames(usize),
    /// Text of another device.
    Text(String),
    /// Bytes that are neither: another device, or another baud rate.
    Bytes(Vec<u8>),
    /// The request itself: the far end returns all bytes (loopback).
    Echo,
    /// No bytes.
    Nothing,
    /// The host is present and reports that nothing listens at the port (UDP).
    Refused,
}

/// Requests the version twice, and listens.
///
/// # Errors
/// [`ErrorKind::Port`](magician::ErrorKind::Port) if the line is gone.
pub async fn listen(line: &mut RawLine, patience: Duration) -> Result<ProbeReply> {
    let question = question()?;
    let mut heard = Vec::new();
    // Twice: the first may be lost, or complete a half frame of an earlier program.
    for _ in 0..2 {
        line.send(question.bytes()).await?;
        let until = Instant::now() + patience / 2;
        gather(line, until, &mut heard).await?;
        if let found @ ProbeReply::Arm(_) = judge(&heard) {
            return Ok(found);
        }
    }
    Ok(judge(&heard))
}

fn question() -> Result<FrameBuf> {
    Ok(FrameBuf::get(&NoArgs, DeviceVersion::ROW)?)
}

/// Collects bytes until the arm has answered, a pause follows the last byte, there are enough, or
/// `until` is reached.
async fn gather(line: &mut RawLine, until: Instant, heard: &mut Vec<u8>) -> Result<()> {
    let mut bytes = [0; MAX_EXAMINED_BYTES];
    let mut end = until;
    while heard.len() < MAX_EXAMINED_BYTES {
        let Ok(count) = timeout_at(end.min(until), line.receive(&mut bytes)).await else {
            return Ok(());
        };
        heard.extend_from_slice(bytes.get(..count?).unwrap_or_default());
        if matches!(judge(heard), ProbeReply::Arm(_)) {
            return Ok(());
        }
        end = Instant::now() + PAUSE;
    }
    Ok(())
}

/// Classifies received bytes.
fn judge(heard: &[u8]) -> ProbeReply {
    let mut deframer = Deframer::new();
    let (mut rest, mut frames, mut echoes) = (heard, 0, 0);
    while let Some(event) = deframer.next(&mut rest) {
        let Event::Frame { frame, .. } = event else {
            continue;
        };
        frames += 1;
        if frame.id() != <DeviceVersion as Readable>::ROW.id || frame.ctrl() != Ctrl::GET {
            continue;
        }
        match DeviceVersion::decode(frame.params()) {
            Ok(found) => {
                let DeviceVersion {
                    major_version,
                    minor_version,
                    revision,
                    ..
                } = found;
                return ProbeReply::Arm([major_version, minor_version, revision]);
            }
            // Without parameters it is the request itself.
            Err(_) => echoes += usize::from(frame.params().is_empty()),
        }
    }
    let printable = |byte: &&u8| matches!(byte, b'\t' | b'\n' | b'\r' | b' '..=b'~');
    let printed = heard.iter().filter(printable).count();
    match (heard.len(), frames) {
        (0, _) => ProbeReply::Nothing,
        (_, some) if some > 0 && some == echoes => ProbeReply::Echo,
        (_, some) if some > 0 => ProbeReply::Frames(some),
        // Nine in ten printable: text with a few damaged or binary bytes is still text.
        (all, _) if all >= 4 && printed * 10 >= all * 9 => {
            ProbeReply::Text(String::from_utf8_lossy(heard).into_owned())
        }
        _ => ProbeReply::Bytes(heard.to_vec()),
    }
}

/// Requests the version by datagrams, and distinguishes a refusing host from a silent one.
///
/// # Errors
/// [`ErrorKind::Port`](magician::ErrorKind::Port) if the host has no address or is unreachable.
pub async fn hear_datagrams(host: &str, port: u16, patience: Duration) -> Result<ProbeReply> {
    let failed = |error: io::Error| {
        let message = format!("{host} port {port} cannot be reached: {error}");
        Error::port(message, error)
    };
    let mut addresses = lookup_host((host, port)).await.map_err(failed)?;
    let peer = (addresses.next()).ok_or_else(|| failed(io::ErrorKind::NotFound.into()))?;
    let any: SocketAddr = match peer {
        SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
        SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
    };
    let socket = UdpSocket::bind(any).await.map_err(failed)?;
    socket.connect(peer).await.map_err(failed)?;
    let question = question()?;
    let (mut heard, mut refused) = (Vec::new(), false);
    let mut bytes = [0; MAX_EXAMINED_BYTES];
    // Three datagrams, because any of them may be lost.
    for _ in 0..3 {
        let asked = async {
            socket.send(question.bytes()).await?;
            socket.recv(&mut bytes).await
        };
        match timeout(patience / 3, asked).await {
            Ok(Ok(count)) => heard.extend_from_slice(bytes.get(..count).unwrap_or_default()),
            // An ICMP error; a later answer still counts.
            Ok(Err(error)) if error.kind() == io::ErrorKind::ConnectionRefused => refused = true,
            Ok(Err(error)) => return Err(failed(error)),
            Err(_) => {}
        }
        if let found @ ProbeReply::Arm(_) = judge(&heard) {
            return Ok(found);
        }
    }
    match judge(&heard) {
        ProbeReply::Nothing if refused => Ok(ProbeReply::Refused),
        heard => Ok(heard),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_told_apart() {
        let version = DeviceVersion::decode(&[3, 6, 14]).unwrap();
        let id = <DeviceVersion as Readable>::ROW.id;
        let answer = FrameBuf::encode(id, Ctrl::GET, &version).unwrap();
        let late = [b"ok\r\n", answer.bytes()].concat();
        assert_eq!(judge(&late), ProbeReply::Arm([3, 6, 14]));
        let echo = question().unwrap();
        assert_eq!(judge(echo.bytes()), ProbeReply::Echo);
        let other = FrameBuf::new(10, Ctrl::GET, &[0; 32]).unwrap();
        assert_eq!(judge(other.bytes()), ProbeReply::Frames(1));
        assert_eq!(
            judge(b"start\r\nMarlin 2.1\r\n"),
            ProbeReply::Text("start\r\nMarlin 2.1\r\n".into())
        );
        assert_eq!(
            judge(&[0xF8, 0x00, 0x78, 0x80]),
            ProbeReply::Bytes(vec![0xF8, 0x00, 0x78, 0x80])
        );
        assert_eq!(judge(&[]), ProbeReply::Nothing);
    }

    #[tokio::test(start_paused = true)]
    async fn a_line_that_says_nothing_ends_in_time() {
        let (ours, _theirs) = tokio::io::duplex(64);
        let mut line = RawLine::over(ours, "a pipe");
        let begun = Instant::now();
        let heard = listen(&mut line, Duration::from_secs(1)).await.unwrap();
        assert_eq!(heard, ProbeReply::Nothing);
        assert_eq!(begun.elapsed(), Duration::from_secs(1));
    }

    #[tokio::test(start_paused = true)]
    async fn a_virtual_arm_is_one() {
        let target = "sim".parse().unwrap();
        let mut line = RawLine::open(&target).await.unwrap();
        let heard = listen(&mut line, Duration::from_secs(1)).await.unwrap();
        assert!(matches!(heard, ProbeReply::Arm(_)), "{heard:?}");
    }

    #[tokio::test]
    async fn a_host_that_refuses_is_told_from_one_that_is_silent() {
        let silent = UdpSocket::bind("127.0.0.1:0").await.unwrap();
        let port = silent.local_addr().unwrap().port();
        let patience = Duration::from_millis(300);
        let heard = hear_datagrams("127.0.0.1", port, patience).await;
        assert_eq!(heard.unwrap(), ProbeReply::Nothing);
        drop(silent);
        let heard = hear_datagrams("127.0.0.1", port, patience).await;
        assert_eq!(heard.unwrap(), ProbeReply::Refused);
    }
}
