//! Discovery of arms on Wi-Fi: their modules answer a request on UDP 48899 with their address
//! (model section 15, errata E45).
//!
//! The request is sent to every named host, and as a broadcast to the networks of this computer. A
//! broadcast does not cross a router; name the arm's address there. On Linux the broadcast goes to
//! every network of this computer, elsewhere to the network chosen by the system.

use std::future::poll_fn;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::task::{Context, Poll};
use std::time::Duration;

use tokio::io::ReadBuf;
use tokio::net::{UdpSocket, lookup_host};
use tokio::time::{Instant, timeout_at};

use crate::{Error, ErrorCode, Result, Target};

/// Port of the modules' discovery service.
pub const PORT: u16 = 48_899;
/// Request text of the modules.
const QUESTION: &[u8] = b"Who is Dobot?";
/// Interval of repeated requests, which make up for lost datagrams. Choice.
const REQUEST_INTERVAL: Duration = Duration::from_millis(250);
/// Longest accepted answer, bytes; the modules' have about 45.
const MAX_ANSWER_SIZE: usize = 512;
/// Most arms kept: any host may answer, and memory stays bounded. Choice.
const MAX_ARMS: usize = 256;
/// Datagrams read before time is checked. Choice.
const DATAGRAMS_PER_TURN: usize = 64;

/// Arm that answered.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct DiscoveredArm {
    /// Source address of the answer, at which the arm is reached.
    pub address: IpAddr,
    /// Address that the module reports; a different one behind a router.
    pub reported: IpAddr,
    /// Hardware address of the module, twelve hexadecimal digits.
    pub mac: String,
    /// Name of the module: `USR-C322`.
    pub name: String,
    /// Firmware version of the module.
    pub version: Option<String>,
}

impl DiscoveredArm {
    /// Returns the target to connect to: port 8899 at the source address.
    #[must_use]
    pub fn target(&self) -> Target {
        Target::Udp {
            host: self.address.to_string(),
            port: magician_protocol::UDP_PORT,
        }
    }
}

/// Search for arms.
///
/// ```no_run
/// use std::time::Duration;
/// use magician::discovery::Search;
///
/// # async fn look() -> magician::Result<()> {
/// for arm in Search::networks().find(Duration::from_secs(1)).await? {
///     println!("{} {} {}", arm.target(), arm.name, arm.mac);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct Search {
    hosts: Vec<String>,
    networks: bool,
}

impl Search {
    /// Searches the networks of this computer.
    #[must_use]
    pub fn networks() -> Self {
        Self {
            hosts: Vec::new(),
            networks: true,
        }
    }

    /// Searches one host, possibly in another network: a name or an address, with `:PORT` if it is
    /// not 48899.
    #[must_use]
    pub fn host(host: impl Into<String>) -> Self {
        Self::default().and(host)
    }

    /// Adds a host.
    #[must_use]
    pub fn and(mut self, host: impl Into<String>) -> Self {
        self.hosts.push(host.into());
        self
    }

    /// Sends requests and returns the answers, sorted by address, each arm once. The list may be
    /// empty. It takes the given time, but a search of hosts alone ends when all have answered.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`](crate::ErrorKind::InvalidInput) for an invalid host,
    /// [`ErrorKind::Port`](crate::ErrorKind::Port) if a host name is unknown or this computer has
    /// no network.
    pub async fn find(&self, within: Duration) -> Result<Vec<DiscoveredArm>> {
        let now = Instant::now();
        // A day is as good as forever, and does not overflow the clock.
        let until = now
            .checked_add(within)
            .unwrap_or(now + Duration::from_secs(86_400));
        let mut asker = match timeout_at(until, self.asker()).await {
            Ok(asker) => asker?,
            Err(_) => {
                let message = "the name of the host was not resolved in time; use its address";
                return Err(Error::new(ErrorCode::NoAnswer, message));
            }
        };
        asker.ask_until(until, !self.networks).await
    }

    /// Searches as [`find`](Self::find) does, for programs without tokio.
    ///
    /// # Errors
    /// Same as [`find`](Self::find).
    ///
    /// # Panics
    /// Panics within an asynchronous task; use [`find`](Self::find) there.
    pub fn find_blocking(&self, within: Duration) -> Result<Vec<DiscoveredArm>> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build();
        let runtime = runtime.map_err(no_network)?;
        let found = runtime.block_on(self.find(within));
        // A pending name lookup must not delay the return.
        runtime.shutdown_background();
        found
    }

    async fn asker(&self) -> Result<Asker> {
        let mut to = Vec::new();
        for host in &self.hosts {
            to.push(address_of(host).await?);
        }
        if self.networks {
            let everywhere: SocketAddr = (Ipv4Addr::BROADCAST, PORT).into();
            let networks = broadcasts().into_iter().map(|ip| (ip, PORT).into());
            to.extend(networks.chain([everywhere]));
        }
        to.sort();
        to.dedup();
        let socket = |any: IpAddr, wanted: bool| {
            if wanted {
                bind(any).map(Some).map_err(no_network)
            } else {
                Ok(None)
            }
        };
        Ok(Asker {
            v4: socket(
                Ipv4Addr::UNSPECIFIED.into(),
                to.iter().any(SocketAddr::is_ipv4),
            )?,
            v6: socket(
                Ipv6Addr::UNSPECIFIED.into(),
                to.iter().any(SocketAddr::is_ipv6),
            )?,
            waiting: to.clone(),
            to,
            found: Vec::new(),
        })
    }
}

fn no_network(error: io::Error) -> Error {
    let message = format!("the network cannot be searched for arms: {error}");
    Error::port(message, error)
}

/// Parses `HOST`, `HOST:PORT`, `[V6]`, `[V6]:PORT`, or a bare IPv6 address.
async fn address_of(host: &str) -> Result<SocketAddr> {
    if let Ok(ip) = host.parse::<IpAddr>() {
        return Ok((ip, PORT).into());
    }
    let (name, port) = crate::target::split_port(host, "HOST[:PORT]")?;
    let failed = |error| {
        let message = format!("{name} cannot be asked for arms: {error}; is the name right?");
        Error::port(message, error)
    };
    let mut addresses = lookup_host((name.as_str(), port.unwrap_or(PORT)))
        .await
        .map_err(failed)?;
    addresses
        .next()
        .ok_or_else(|| failed(io::ErrorKind::NotFound.into()))
}

fn bind(any: IpAddr) -> io::Result<UdpSocket> {
    let socket = std::net::UdpSocket::bind((any, 0))?;
    socket.set_nonblocking(true)?;
    if any.is_ipv4() {
        socket.set_broadcast(true)?;
    }
    UdpSocket::from_std(socket)
}

/// Search in progress.
struct Asker {
    v4: Option<UdpSocket>,
    v6: Option<UdpSocket>,
    to: Vec<SocketAddr>,
    /// Hosts that have not answered.
    waiting: Vec<SocketAddr>,
    found: Vec<DiscoveredArm>,
}

impl Asker {
    async fn ask_until(
        &mut self,
        until: Instant,
        all_is_enough: bool,
    ) -> Result<Vec<DiscoveredArm>> {
        loop {
            self.ask().await?;
            let again = (Instant::now() + REQUEST_INTERVAL).min(until);
            let enough = async {
                while !(all_is_enough && self.waiting.is_empty()) {
                    poll_fn(|cx| self.hear(cx)).await;
                }
            };
            // Answers that have arrived by the end still count, however short the wait.
            let enough = timeout_at(again, enough).await.is_ok();
            if enough || again >= until {
                let mut found = std::mem::take(&mut self.found);
                found.sort();
                return Ok(found);
            }
        }
    }

    /// Sends the request to all addresses. An unreachable network is tried again with the next
    /// request.
    async fn ask(&self) -> Result<()> {
        let mut sent = false;
        let mut failed = None;
        for to in &self.to {
            let socket = if to.is_ipv4() { &self.v4 } else { &self.v6 };
            let Some(socket) = socket else { continue };
            match socket.send_to(QUESTION, to).await {
                Ok(_) => sent = true,
                Err(error) => failed = Some(error),
            }
        }
        match failed {
            Some(error) if !sent => Err(no_network(error)),
            // A network that fails does not matter if another was reached.
            _ => Ok(()),
        }
    }

    /// Reads answers; ready if there was a new one.
    fn hear(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        let mut new = false;
        for socket in [&self.v4, &self.v6].into_iter().flatten() {
            for turn in 0.. {
                let mut bytes = [0; MAX_ANSWER_SIZE];
                let mut buffer = ReadBuf::new(&mut bytes);
                match socket.poll_recv_from(cx, &mut buffer) {
                    Poll::Pending => break,
                    Poll::Ready(Ok(from)) => {
                        let known = &mut self.found;
                        if let Some(arm) = parse(buffer.filled(), from.ip()) {
                            self.waiting.retain(|asked| *asked != from);
                            if !known.contains(&arm) && known.len() < MAX_ARMS {
                                known.push(arm);
                            }
                            new = true;
                        }
                    }
                    // ICMP errors of a host without a listener arrive here; they end nothing.
                    Poll::Ready(Err(_)) => {}
                }
                if turn >= DATAGRAMS_PER_TURN {
                    // A flood of answers must not delay the end of the search.
                    cx.waker().wake_by_ref();
                    break;
                }
            }
        }
        if new { Poll::Ready(()) } else { Poll::Pending }
    }
}

/// Parses `ip,MAC,name[,version]`.
fn parse(answer: &[u8], from: IpAddr) -> Option<DiscoveredArm> {
    let text = std::str::from_utf8(answer).ok()?;
    let text = text.trim_end_matches(['\0', '\r', '\n']);
    // Text of a stranger may be shown on a terminal.
    if text.chars().any(char::is_control) {
        return None;
    }
    let mut parts = text.split(',').map(str::trim);
    let reported = parts.next()?.parse().ok()?;
    let mac = parts.next()?;
    if mac.len() != 12 || !mac.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return None;
    }
    let name = parts.next()?;
    let version = parts.next().filter(|version| !version.is_empty());
    Some(DiscoveredArm {
        address: from.to_canonical(),
        reported,
        mac: mac.to_ascii_uppercase(),
        name: name.to_owned(),
        version: version.map(str::to_owned),
    })
}

/// Returns the broadcast addresses of this computer's networks.
#[cfg(target_os = "linux")]
fn broadcasts() -> Vec<IpAddr> {
    // The kernel's routing table lists broadcast addresses without a privilege or a crate.
    let routes = std::fs::read_to_string("/proc/net/fib_trie").unwrap_or_default();
    in_trie(&routes)
}

#[cfg(not(target_os = "linux"))]
fn broadcasts() -> Vec<IpAddr> {
    Vec::new()
}

/// Finds `|-- 192.168.1.255` lines that are followed by a `/32 link BROADCAST` line.
#[cfg(any(target_os = "linux", test))]
fn in_trie(routes: &str) -> Vec<IpAddr> {
    let mut last = None;
    let mut found = Vec::new();
    for line in routes.lines().map(str::trim) {
        if let Some(address) = line.strip_prefix("|-- ") {
            last = address.parse::<Ipv4Addr>().ok();
        } else if line.starts_with("/32 link BROADCAST")
            && let Some(address) = last.filter(|address| !address.is_loopback())
            && !found.contains(&address.into())
        {
            found.push(address.into());
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorKind;

    const FROM: IpAddr = IpAddr::V4(Ipv4Addr::new(10, 0, 0, 9));

    #[test]
    fn reads_what_modules_say() {
        let arm = parse(b"192.168.1.5,d8b04cB30800,USR-C322,2.17.14\r\n", FROM).unwrap();
        assert_eq!(arm.target().to_string(), "udp:10.0.0.9:8899");
        assert_eq!(arm.reported.to_string(), "192.168.1.5");
        assert_eq!(
            (arm.mac.as_str(), arm.name.as_str()),
            ("D8B04CB30800", "USR-C322")
        );
        assert_eq!(arm.version.as_deref(), Some("2.17.14"));
        let short = parse(b"192.168.1.5,D8B04CB30800,USR-C322", FROM).unwrap();
        assert_eq!(short.version, None);
    }

    #[test]
    fn other_datagrams_are_no_arm() {
        for text in [
            "",
            "Who is Dobot?",
            "192.168.1.5",
            "192.168.1.5,D8B04CB30800",
            "192.168.1.5,D8B04CB3080,USR",
            "192.168.1.5,D8B04CB3080\u{20ac},USR",
            "300.168.1.5,D8B04CB30800,USR",
            "192.168.1.5,D8B04CB30800,\x1b[2J",
        ] {
            assert_eq!(parse(text.as_bytes(), FROM), None, "{text:?}");
        }
        assert_eq!(parse(&[0xFF; 40], FROM), None);
    }

    #[test]
    fn finds_the_networks_in_the_table_of_routes() {
        let table = "Main:\n  +-- 0.0.0.0/0 3 0 5\n     |-- 0.0.0.0\n        /0 universe UNICAST\nLocal:\n     \
                     |-- 127.255.255.255\n        /32 link BROADCAST\n     |-- 192.168.1.5\n        \
                     /32 host LOCAL\n     |-- 192.168.1.255\n        /32 link BROADCAST\n";
        assert_eq!(in_trie(table), ["192.168.1.255".parse::<IpAddr>().unwrap()]);
    }

    #[test]
    fn what_is_no_host_is_said_to_be_none() {
        let search = Search::host("arm:x");
        let error = search.find_blocking(Duration::from_secs(20)).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidInput);
        assert!(error.to_string().contains("HOST[:PORT]"), "{error}");
    }
}
