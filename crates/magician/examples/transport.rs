//! A custom transport: anything that reads and writes bytes. This one counts the bytes sent.
//!
//! `cargo run -p magician --example transport -- sim` connects to a virtual arm through an
//! in-memory pipe; with `HOST:PORT` it is a TCP connection, to a bridge for example. The arm moves:
//! keep clear of it.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::task::{Context, Poll, ready};
use std::time::Instant;

use magician::sim::{ArmInstant, Controller, LinkId};
use magician::{Arm, Options};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, DuplexStream, ReadBuf};
use tokio::net::TcpStream;

/// Stream that counts the bytes sent to the arm.
struct Counting<T> {
    line: T,
    sent: Arc<AtomicUsize>,
}

impl<T: AsyncRead + Unpin> AsyncRead for Counting<T> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.line).poll_read(cx, buffer)
    }
}

impl<T: AsyncWrite + Unpin> AsyncWrite for Counting<T> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let count = ready!(Pin::new(&mut self.line).poll_write(cx, bytes))?;
        self.sent.fetch_add(count, Ordering::Relaxed);
        Poll::Ready(Ok(count))
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.line).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.line).poll_shutdown(cx)
    }
}

/// Serves the other end of the pipe: a controller that follows the wall clock.
async fn serve(mut line: DuplexStream) -> io::Result<()> {
    let (mut controller, usb, since) = (Controller::default(), LinkId(0), Instant::now());
    let mut bytes = [0; 256];
    loop {
        let count = line.read(&mut bytes).await?;
        if count == 0 {
            return Ok(());
        }
        controller.advance(ArmInstant::ZERO + since.elapsed());
        for reply in controller.exchange(usb, &bytes[..count]) {
            line.write_all(reply.bytes()).await?;
        }
    }
}

async fn drive(line: impl AsyncRead + AsyncWrite + Send + Unpin + 'static) -> magician::Result<()> {
    let sent = Arc::default();
    let line = Counting {
        line,
        sent: Arc::clone(&sent),
    };
    let arm = Arm::over(line, Options::default()).await?; // over_with can open it again when it breaks
    arm.move_to(220.0, 40.0, 30.0, 0.0).await?;
    let pose = arm.pose().await?;
    println!("x {:.1} y {:.1} z {:.1}", pose.x, pose.y, pose.z);
    println!("{} bytes were sent for it", sent.load(Ordering::Relaxed));
    Ok(())
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Box<dyn std::error::Error>> {
    let port = std::env::args().nth(1).unwrap_or_else(|| "sim".to_owned());
    if port == "sim" {
        let (ours, theirs) = tokio::io::duplex(1024);
        tokio::spawn(serve(theirs));
        drive(ours).await?;
    } else {
        drive(TcpStream::connect(port).await?).await?;
    }
    Ok(())
}
