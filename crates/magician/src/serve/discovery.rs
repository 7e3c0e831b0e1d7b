//! Answers to hosts that search for Wi-Fi modules of arms.

use std::fmt::{self, Write};
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::task::{Context, Poll};

use tokio::io::ReadBuf;
use tokio::net::UdpSocket;

use super::udp::{DATAGRAM, bound, refused};
use super::{Endpoint, Listener, READS_PER_POLL, Service};

/// Port on which a Wi-Fi module answers searching hosts (model section 15).
pub(super) const PORT: u16 = 48_899;
/// Request that hosts broadcast, and repeat every two seconds to check that the module is still
/// there.
const QUESTION: &[u8] = b"Who is Dobot?";
/// Name and version of the module (model section 15).
const MODULE: &str = "USR-C322,2.17.14";

/// Address at which the arm's Wi-Fi module answers searching hosts.
///
/// The answer, `ip,MAC,USR-C322,2.17.14`, has no port: hosts connect to port 8899 of that address.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Discovery {
    /// Port 48899 beside each UDP socket on port 8899. If that port is in use, perhaps by another
    /// arm, there is no discovery, and a [`Notice::Undiscoverable`](super::Notice::Undiscoverable).
    #[default]
    Auto,
    /// No discovery.
    Off,
    /// `HOST[:PORT]` (48899 by default; 0: any free port), whatever the UDP port is.
    At(String),
}

/// UDP socket that answers with the arm's address.
pub(super) struct Answerer {
    socket: UdpSocket,
    address: SocketAddr,
    mac: Mac,
    question: Box<[u8]>,
    answer: String,
}

impl Answerer {
    pub(super) fn bind(address: SocketAddr, service: &mut dyn Service) -> io::Result<Self> {
        let (socket, address) = bound(address)?;
        Ok(Self {
            socket,
            address,
            mac: Mac::of(service.device_id()),
            question: vec![0; DATAGRAM].into_boxed_slice(),
            answer: String::new(),
        })
    }

    fn answer(&mut self, cx: &mut Context<'_>, asker: SocketAddr) {
        let Ok(ip) = self.reached_by(asker) else {
            // There is no route back, so an answer would not arrive.
            return;
        };
        self.answer.clear();
        if write!(self.answer, "{ip},{},{MODULE}", self.mac).is_ok() {
            // A lost answer is requested again in two seconds.
            let _ = (self.socket).poll_send_to(cx, self.answer.as_bytes(), asker);
        }
    }

    /// Returns our address as the client sees it. For a socket bound to all addresses it is the one
    /// from which the system would send to the client, because a broadcast names none.
    fn reached_by(&self, asker: SocketAddr) -> io::Result<IpAddr> {
        if !self.address.ip().is_unspecified() {
            return Ok(self.address.ip());
        }
        let any: IpAddr = match asker {
            SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
            SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
        };
        let way = std::net::UdpSocket::bind((any, 0))?;
        way.connect(asker)?;
        Ok(way.local_addr()?.ip().to_canonical())
    }
}

impl Listener for Answerer {
    fn endpoint(&self) -> Endpoint {
        Endpoint::Discovery(self.address)
    }

    fn poll(&mut self, cx: &mut Context<'_>, service: &mut dyn Service) -> io::Result<()> {
        // The module is powered by the arm's connector.
        let plugged = service.plugged();
        for _ in 0..READS_PER_POLL {
            let mut buffer = ReadBuf::new(&mut self.question);
            match self.socket.poll_recv_from(cx, &mut buffer) {
                Poll::Pending => return Ok(()),
                Poll::Ready(Ok(asker)) if plugged && asks(buffer.filled()) => {
                    self.answer(cx, asker);
                }
                Poll::Ready(Ok(_)) => {}
                Poll::Ready(Err(error)) if refused(&error) => {}
                Poll::Ready(Err(error)) => return Err(error),
            }
        }
        // More datagrams may wait; the other endpoints get a turn first.
        cx.waker().wake_by_ref();
        Ok(())
    }

    fn unplug(&mut self, _: &mut dyn Service) {}
}

/// True if a datagram is the request, with or without a line end or terminating zero.
fn asks(datagram: &[u8]) -> bool {
    let rest = datagram.strip_prefix(QUESTION);
    rest.is_some_and(|rest| rest.iter().all(|byte| matches!(byte, 0 | b'\r' | b'\n')))
}

/// Hardware address of the module: derived from the arm's id, and marked as locally administered.
struct Mac([u8; 6]);

impl Mac {
    const LOCALLY_ADMINISTERED: u8 = 0x02;

    fn of(device_id: [u32; 3]) -> Self {
        let [[a, b, c, d], [e, ..], _] = device_id.map(u32::to_be_bytes);
        Self([Self::LOCALLY_ADMINISTERED, a, b, c, d, e])
    }
}

impl fmt::Display for Mac {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_question_is_a_question() {
        for text in ["Who is Dobot?", "Who is Dobot?\0", "Who is Dobot?\r\n"] {
            assert!(asks(text.as_bytes()), "{text:?}");
        }
        for text in ["", "Who is Dobot", "who is dobot?", "Who is Dobot? I am"] {
            assert!(!asks(text.as_bytes()), "{text:?}");
        }
    }

    #[test]
    fn a_hardware_address_is_twelve_digits_of_a_local_one() {
        let mac = Mac::of([0xD8B0_4CB3, 0x0800_0000, 7]);
        assert_eq!(mac.to_string(), "02D8B04CB308");
    }
}
