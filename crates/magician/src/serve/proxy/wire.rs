//! Line from a proxy to its arm, which is reopened when lost.

use std::future::Future;
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use super::service::ProxyService;
use crate::proxy::Chunk;
use crate::{Error, RawLine};

/// Interval of attempts to reopen a lost line. Choice.
const PAUSE: Duration = Duration::from_millis(250);
const BUFFER: usize = 4096;

/// Line to the arm, open or being reopened.
pub(super) struct Wire {
    state: WireState,
    /// Chunk being written, and the number of its bytes already written.
    out: Option<(Chunk, usize)>,
}

enum WireState {
    Open(Box<RawLine>),
    Lost(Pin<Box<dyn Future<Output = RawLine> + Send>>),
    /// Only during a change of state.
    Changing,
}

impl Wire {
    pub(super) fn new(line: RawLine) -> Self {
        Self {
            state: WireState::Open(Box::new(line)),
            out: None,
        }
    }

    /// Reads from the arm; true if anything happened.
    pub(super) fn read(&mut self, cx: &mut Context<'_>, service: &mut ProxyService) -> bool {
        let mut bytes = [0; BUFFER];
        let came = match &mut self.state {
            WireState::Open(line) => line.poll_receive(cx, &mut bytes),
            WireState::Lost(search) => {
                let Poll::Ready(line) = search.as_mut().poll(cx) else {
                    return false;
                };
                self.state = WireState::Open(Box::new(line));
                service.find_line();
                return true;
            }
            WireState::Changing => return false,
        };
        match came {
            Poll::Pending => false,
            Poll::Ready(Ok(count)) => {
                service.receive_from_arm(bytes.get(..count).unwrap_or_default());
                true
            }
            Poll::Ready(Err(error)) => {
                self.lose(service, &error);
                true
            }
        }
    }

    /// Writes pending requests to the arm; true if any were sent.
    pub(super) fn write(&mut self, cx: &mut Context<'_>, service: &mut ProxyService) -> bool {
        let mut went = false;
        while let WireState::Open(line) = &mut self.state {
            let (chunk, sent) = match self.out.take() {
                Some(under_way) => under_way,
                None => match service.transmit_to_arm() {
                    Some(chunk) => (chunk, 0),
                    None => break,
                },
            };
            let rest = chunk.bytes().get(sent..).unwrap_or_default();
            match line.poll_send(cx, rest) {
                Poll::Ready(Ok(count)) => {
                    went = true;
                    self.out = Some((chunk, sent + count)).filter(|_| count < rest.len());
                }
                Poll::Pending => {
                    self.out = Some((chunk, sent));
                    break;
                }
                Poll::Ready(Err(error)) => {
                    self.lose(service, &error);
                    return true;
                }
            }
        }
        went
    }

    fn lose(&mut self, service: &mut ProxyService, error: &Error) {
        // The rest of a half-written frame would be garbage on the next line.
        self.out = None;
        if let WireState::Open(line) = std::mem::replace(&mut self.state, WireState::Changing) {
            self.state = WireState::Lost(Box::pin(find_again(*line)));
        }
        // After the change of state, because an observer may ask for it.
        service.lose_line(error);
    }
}

/// Reopens the line as soon as possible.
async fn find_again(mut line: RawLine) -> RawLine {
    loop {
        if line.reopen().await.is_ok() {
            return line;
        }
        tokio::time::sleep(PAUSE).await;
    }
}
