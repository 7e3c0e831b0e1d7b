//! Search for a serial port by the device behind it.

use std::future::poll_fn;
use std::time::Duration;

use magician_protocol::commands::DeviceSn;
use magician_protocol::{Deframer, Event, FrameBuf, NoArgs, Readable, visible};
use tokio::time::timeout;

use super::Transport;
use super::serial::{self, Serial};
use crate::ports::{Port, list};
use crate::{Action, Error, ErrorCode, Message, Result, Target, message};

/// Longest time for an arm to return its serial number; real ones take 12 ms (model section 15).
const ANSWER_TIMEOUT: Duration = Duration::from_millis(300);
/// Attempts per port.
const TIMES: usize = 2;

/// Returns the path of the one adapter that `usb:VENDOR:PRODUCT[:SERIAL]` names.
pub(super) fn adapter(target: &Target, present: &[Port]) -> Result<String> {
    let Target::Usb {
        vendor,
        product,
        serial,
    } = target
    else {
        return Ok(target.to_string());
    };
    let is_it = |port: &&Port| {
        let Some(usb) = &port.usb else { return false };
        let same = (usb.vendor, usb.product) == (*vendor, *product);
        same && (serial.is_none() || usb.serial == *serial)
    };
    let found: Vec<&Port> = present.iter().filter(is_it).collect();
    let message = match found.as_slice() {
        [port] => return Ok(port.path.clone()),
        [] => {
            let message = message!(
                "{target} is not plugged in ({found}); plug it in",
                target = target.to_string(),
                found = list(present)
            );
            return Err(Error::new(ErrorCode::NoPort, message)
                .remedy(Action::ListPorts, "shows the ids of connected devices"));
        }
        several => message!(
            "{target} is plugged in more than once ({found}); add the serial number of the \
                adapter, usb:VENDOR:PRODUCT:SERIAL, or name the port",
            target = target.to_string(),
            found = list(several.iter().copied())
        ),
    };
    Err(Error::new(ErrorCode::SeveralArms, message))
}

/// Opens the port with the arm of this serial number. Other ports are queried and closed again;
/// ports in use are left alone.
pub(super) async fn arm(wanted: &str, candidates: &[Port]) -> Result<(String, Serial)> {
    let mut seen = Vec::new();
    let mut station = None;
    for Port { path, .. } in candidates {
        let mut port = match serial::open(path) {
            Ok(port) => port,
            // The message names the port, and the program that holds it.
            Err(error) => {
                seen.push(error.in_words());
                station = station.or_else(|| station_at(path));
                continue;
            }
        };
        match serial_number(&mut port).await {
            Some(serial) if serial.eq_ignore_ascii_case(wanted) => return Ok((path.clone(), port)),
            Some(serial) => seen.push(message!(
                "{path} has the arm {serial}",
                path,
                serial = visible(&serial).to_string()
            )),
            None => seen.push(message!("{path} does not answer", path)),
        }
    }
    Err(not_found(wanted, &seen, station))
}

/// Returns the address at which another program serves this port.
fn station_at(path: &str) -> Option<String> {
    #[cfg(feature = "stations")]
    return crate::stations::url_of(path);
    #[cfg(not(feature = "stations"))]
    let _ = path;
    #[cfg(not(feature = "stations"))]
    None
}

/// Returns the error of a search, with the results per port, and the station of a port that could
/// not be queried.
fn not_found(wanted: &str, seen: &[Message], station: Option<String>) -> Error {
    let message = match Message::joined(seen.iter().cloned()) {
        None => message!(
            "the arm {wanted} was not found: no adapter of an arm is plugged in; is it switched \
                on and plugged in?",
            wanted
        ),
        Some(seen) => message!(
            "the arm {wanted} was not found: {seen}; is it switched on and plugged in?",
            wanted,
            seen
        ),
    };
    let error = Error::new(ErrorCode::NoArm, message);
    match station {
        Some(url) => error.at_station(url, "has a port that could not be asked: it may be the arm"),
        None => error,
    }
}

/// Queries the serial number of the device at the end of a line, with a short timeout.
async fn serial_number(line: &mut dyn Transport) -> Option<String> {
    let request = FrameBuf::get(&NoArgs, DeviceSn::ROW).ok()?;
    let mut deframer = Deframer::new();
    for _ in 0..TIMES {
        if let Ok(answer) = timeout(ANSWER_TIMEOUT, exchange(line, &request, &mut deframer)).await {
            // `None` from a broken line is final: another attempt cannot succeed.
            return answer;
        }
    }
    None
}

/// Sends a request and returns the serial number; `None` if the line broke.
async fn exchange(
    line: &mut dyn Transport,
    request: &FrameBuf,
    deframer: &mut Deframer,
) -> Option<String> {
    let mut rest = request.bytes();
    while !rest.is_empty() {
        let count = poll_fn(|cx| line.poll_write(cx, rest)).await.ok()?;
        rest = rest.get(count..).filter(|_| count > 0)?;
    }
    loop {
        // Larger than the answer; longer bursts are read in pieces.
        let mut bytes = [0; 256];
        let count = poll_fn(|cx| line.poll_read(cx, &mut bytes)).await.ok()?;
        let mut input = bytes.get(..count).filter(|bytes| !bytes.is_empty())?;
        while let Some(event) = deframer.next(&mut input) {
            if let Event::Frame { frame, .. } = event
                && frame.id() == DeviceSn::ROW.id
                && let Ok(answer) = frame.read::<DeviceSn>()
            {
                return Some(answer.device_sn.lossy().to_string());
            }
        }
    }
}

#[cfg(all(test, unix, feature = "serve"))]
mod tests {
    use std::path::Path;

    use crate::serve::Server;
    use magician_sim::{Controller, Profile, Speed};

    use super::*;
    use crate::ports::Usb;

    fn port(path: &str, serial: Option<&str>) -> Port {
        let usb = Usb {
            vendor: 0x10C4,
            product: 0xEA60,
            serial: serial.map(Into::into),
            ..Usb::default()
        };
        Port {
            path: path.into(),
            usb: Some(usb),
        }
    }

    /// Serves a virtual arm on a pseudo-terminal; ready at the first poll of the server.
    fn served(path: &Path, serial: &str) -> Server {
        let mut profile = Profile::default();
        profile.identity.serial = serial.into();
        Server::new(Controller::new(profile))
            .speed(Speed::Max)
            .pty(path)
    }

    #[tokio::test]
    async fn an_arm_is_found_by_its_serial_number_among_others() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let paths = ["one", "two", "three"].map(at);
        let (ready, is_ready) = tokio::sync::oneshot::channel();
        let one = served(&paths[0], "DT-ONE");
        let two = served(&paths[1], "DT-TWO").on_ready(move |_| ready.send(()).unwrap());
        let candidates: Vec<Port> = (paths.iter())
            .map(|path| port(path.to_str().unwrap(), None))
            .collect();
        let search = async {
            is_ready.await.unwrap();
            let (path, port) = arm("dt-two", &candidates).await.unwrap();
            assert_eq!(path, candidates[1].path);
            // The port found first is in use, the missing one is named, and the other one was
            // closed again.
            let error = arm("DT-THREE", &candidates).await.err().unwrap();
            assert_eq!(error.kind(), crate::ErrorKind::Port);
            let message = error.to_string();
            for part in ["has the arm DT-ONE", "in use by", "does not exist", "three"] {
                assert!(message.contains(part), "{message}");
            }
            drop(port);
            assert!(arm("DT-ONE", &candidates).await.is_ok());
        };
        let all = crate::serve::serve_all([one, two], std::future::pending());
        tokio::select! {
            ended = all => panic!("{ended:?}"),
            () = search => {}
        }
    }

    #[tokio::test(start_paused = true)]
    async fn what_does_not_answer_is_named() {
        let (_controller, user) = rustix_pty();
        let candidates = [port(&user, None)];
        let message = arm("DT", &candidates).await.err().unwrap().to_string();
        assert!(message.contains("does not answer"), "{message}");
        let message = arm("DT", &[]).await.err().unwrap().to_string();
        assert!(message.contains("no adapter of an arm"), "{message}");
    }

    /// Creates a pseudo-terminal without a listener.
    fn rustix_pty() -> (std::os::fd::OwnedFd, String) {
        use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

        let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&controller).unwrap();
        unlockpt(&controller).unwrap();
        let name = ptsname(&controller, Vec::new()).unwrap();
        (controller, name.into_string().unwrap())
    }

    #[test]
    fn port_of_a_station_that_cannot_be_asked_is_named_with_it() {
        let seen = [Message::from("/dev/ttyUSB0 is in use by magician")];
        let url = "http://127.0.0.1:8910/left";
        let error = not_found("DT", &seen, Some(url.to_owned()));
        assert_eq!(
            (error.code(), error.station()),
            (ErrorCode::NoArm, Some(url))
        );
        assert_eq!(error.remedies().len(), 1);
        assert_eq!(not_found("DT", &seen, None).station(), None);
    }

    #[test]
    fn an_adapter_is_found_by_its_ids() {
        let named = |text: &str, present: &[Port]| adapter(&text.parse().unwrap(), present);
        let one = port("/dev/ttyUSB4", Some("A7"));
        let two = port("/dev/ttyUSB5", Some("B8"));
        let both = [one.clone(), two];
        let path = named("usb:10c4:ea60", &[one]).unwrap();
        assert_eq!(path, "/dev/ttyUSB4");
        assert_eq!(named("usb:10c4:ea60:B8", &both).unwrap(), "/dev/ttyUSB5");
        for (text, hint) in [
            ("usb:10c4:ea60", "more than once"),
            ("usb:10c4:ea60:C9", "is not plugged in"),
            ("usb:1a86:7523", "/dev/ttyUSB4"),
        ] {
            let message = named(text, &both).unwrap_err().to_string();
            assert!(message.contains(hint), "{message}");
        }
    }
}
