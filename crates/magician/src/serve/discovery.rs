use std::fmt::{self, Write};
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::task::{Context, Poll};

use tokio::io::ReadBuf;
use tokio::net::UdpSocket;

use super::udp::{DATAGRAM, bound, refused};
use super::{Endpoint, Listener, READS_PER_POLL, Service};

/// Where a Wi-Fi module listens for hosts that look for one (model section 15).
pub(super) const PORT: u16 = 48_899;
/// What they broadcast, and repeat every two seconds to see that it is still there.
const QUESTION: &[u8] = b"Who is Dobot?";
/// What the module calls itself, and its version (model section 15).
const MODULE: &str = "USR-C322,2.17.14";

/// Where the arm's Wi-Fi module answers hosts that look for it.
///
/// The answer, `ip,MAC,USR-C322,2.17.14`, names no port: hosts go on to port 8899 of that address.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Discovery {
    /// On port 48899 beside each UDP socket on port 8899. If that port is taken, perhaps by
    /// another arm, there is a [`Notice::Undiscoverable`](super::Notice::Undiscoverable) and no
    /// discovery.
    #[default]
    Auto,
    /// Nowhere.
    Off,
    /// At `HOST[:PORT]` (48899 unless given; 0: any free port), whatever the UDP port is.
    At(String),
}

/// A UDP socket that says where the arm is.
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
            // It has no way back: nothing would arrive.
            return;
        };
        self.answer.clear();
        if write!(self.answer, "{ip},{},{MODULE}", self.mac).is_ok() {
            // What is lost is asked for again in two seconds.
            let _ = (self.socket).poll_send_to(cx, self.answer.as_bytes(), asker);
        }
    }

    /// Our address as the asker sees it. Behind a socket for all of our addresses it is the one
    /// from which the system would send to the asker: a broadcast does not name any.
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
        // The module has its power from the arm's connector.
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
        cx.waker().wake_by_ref();
        Ok(())
    }

    fn unplug(&mut self, _: &mut dyn Service) {}
}

/// Whether a datagram is the question, with or without an end of line or of string.
fn asks(datagram: &[u8]) -> bool {
    let rest = datagram.strip_prefix(QUESTION);
    rest.is_some_and(|rest| rest.iter().all(|byte| matches!(byte, 0 | b'\r' | b'\n')))
}

/// The module's hardware address: drawn from the arm's id, and marked as locally administered.
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
