//! TCP connections.

use std::io;
use std::task::{Context, Poll};

use tokio::net::TcpStream;

use super::lines::{CONNECT_TIMEOUT, unreachable_host};
#[cfg(unix)]
use super::read_gap::{ReadGap, read_now};
use super::{Stream, Transport};
use crate::Result;

/// TCP connection to an arm or a bridge.
pub(super) struct Tcp {
    stream: Stream<TcpStream>,
    #[cfg(unix)]
    away: ReadGap,
}

impl Transport for Tcp {
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>> {
        let told = self.stream.poll_read(cx, bytes);
        #[cfg(unix)]
        let told = (self.away).look(told, || read_now(&self.stream.0, bytes));
        told
    }

    #[cfg(unix)]
    fn ask(&mut self) {
        self.away.ask();
    }

    fn poll_write(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        self.stream.poll_write(cx, bytes)
    }
}

/// Connects to a TCP port.
pub(super) async fn connect(host: &str, port: u16) -> Result<Tcp> {
    let connecting = tokio::time::timeout(CONNECT_TIMEOUT, TcpStream::connect((host, port))).await;
    // The system's own timeout is minutes.
    let connected = connecting.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into()));
    let stream = connected.map_err(|error| unreachable_host(host, port, error))?;
    // Nagle's algorithm would hold small frames back until the previous one is acknowledged.
    stream
        .set_nodelay(true)
        .map_err(|error| unreachable_host(host, port, error))?;
    Ok(Tcp {
        stream: Stream(stream),
        #[cfg(unix)]
        away: ReadGap::default(),
    })
}
