//! Open line to a Bluetooth device: writes are cut into packets, notifications become a byte
//! stream.

use std::collections::VecDeque;
use std::future::Future;
use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, Waker, ready};

use btleplug::api::{
    Central, CentralEvent, CentralState, Characteristic, Peripheral as _, ValueNotification,
    WriteType,
};
use btleplug::platform::{Adapter, Peripheral};
use futures_core::Stream;
use tokio::runtime::Handle;

use super::radio::see_off;
use crate::transport::Transport;

type Events<T> = Pin<Box<dyn Stream<Item = T> + Send>>;
type Writing = Pin<Box<dyn Future<Output = btleplug::Result<()>> + Send>>;

/// Capacity for unwritten bytes. Choice: more than all frames of the widest window, so that the
/// last frames of a connection always fit.
const ROOM: usize = 512;

/// Destination of written bytes.
pub(super) struct Port {
    pub(super) device: Peripheral,
    pub(super) writes: Characteristic,
    pub(super) kind: WriteType,
    /// Maximum bytes per write.
    pub(super) chunk: usize,
}

/// Open line to a Bluetooth device.
pub(crate) struct Link {
    port: Arc<Port>,
    notifies: Characteristic,
    /// Notifications and adapter events, until the link is dropped.
    told: Option<(Events<ValueNotification>, Events<CentralEvent>)>,
    came: VecDeque<u8>,
    waiting: VecDeque<u8>,
    writing: Option<Writing>,
    runtime: Handle,
    /// True if the device is disconnected on drop: only if this program connected it.
    disconnect: bool,
}

impl Link {
    /// Subscribes to the notifications of a connected device.
    pub(super) async fn over(
        adapter: &Adapter,
        port: Arc<Port>,
        notifies: Characteristic,
        disconnect: bool,
    ) -> btleplug::Result<Self> {
        // This order misses neither the first bytes nor a disconnect.
        let notifications = port.device.notifications().await?;
        let events = adapter.events().await?;
        port.device.subscribe(&notifies).await?;
        if !port.device.is_connected().await? {
            return Err(btleplug::Error::NotConnected);
        }
        Ok(Self {
            port,
            notifies,
            told: Some((notifications, events)),
            came: VecDeque::new(),
            waiting: VecDeque::new(),
            writing: None,
            runtime: Handle::current(),
            disconnect,
        })
    }

    /// Continues writing; ready if nothing is left.
    fn poll_out(&mut self, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        loop {
            if let Some(writing) = &mut self.writing {
                let written = ready!(writing.as_mut().poll(cx));
                self.writing = None;
                written.map_err(|error| io::Error::new(io::ErrorKind::BrokenPipe, error))?;
            }
            match self.next_chunk() {
                Some(chunk) => self.writing = Some(Arc::clone(&self.port).write(chunk)),
                None => return Poll::Ready(Ok(())),
            }
        }
    }

    fn next_chunk(&mut self) -> Option<Vec<u8>> {
        let count = self.waiting.len().min(self.port.chunk);
        (count > 0).then(|| self.waiting.drain(..count).collect())
    }

    /// Reads all available notifications.
    fn poll_notifications(&mut self, cx: &mut Context<'_>) -> io::Result<()> {
        let Some((notifications, _)) = &mut self.told else {
            return Ok(());
        };
        while let Poll::Ready(next) = notifications.as_mut().poll_next(cx) {
            let next = next.ok_or(io::ErrorKind::ConnectionReset)?;
            let from = (next.service_uuid, next.uuid);
            if from == (self.notifies.service_uuid, self.notifies.uuid) {
                self.came.extend(next.value);
            }
        }
        Ok(())
    }

    /// Checks if the device has disconnected, or Bluetooth was switched off.
    fn poll_events(&mut self, cx: &mut Context<'_>) -> io::Result<()> {
        let id = self.port.device.id();
        let Some((_, events)) = &mut self.told else {
            return Ok(());
        };
        while let Poll::Ready(next) = events.as_mut().poll_next(cx) {
            let gone = match next {
                Some(CentralEvent::DeviceDisconnected(other)) => other == id,
                Some(CentralEvent::StateUpdate(state)) => state == CentralState::PoweredOff,
                Some(_) => false,
                None => true,
            };
            if gone {
                self.disconnect = false;
                return Err(io::ErrorKind::ConnectionReset.into());
            }
        }
        Ok(())
    }
}

impl Port {
    fn write(self: Arc<Self>, chunk: Vec<u8>) -> Writing {
        Box::pin(async move {
            let written = self.device.write(&self.writes, &chunk, self.kind);
            written.await
        })
    }
}

impl Transport for Link {
    fn poll_read(&mut self, cx: &mut Context<'_>, bytes: &mut [u8]) -> Poll<io::Result<usize>> {
        // Accepted bytes are written even if no more are.
        if let Poll::Ready(Err(error)) = self.poll_out(cx) {
            return Poll::Ready(Err(error));
        }
        let told = self.poll_notifications(cx);
        if !self.came.is_empty() {
            return Poll::Ready(io::Read::read(&mut self.came, bytes));
        }
        match told.and_then(|()| self.poll_events(cx)) {
            Ok(()) => Poll::Pending,
            Err(error) => Poll::Ready(Err(error)),
        }
    }

    fn poll_write(&mut self, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        if let Poll::Ready(Err(error)) = self.poll_out(cx) {
            return Poll::Ready(Err(error));
        }
        let room = ROOM.saturating_sub(self.waiting.len());
        // The caller keeps the rest and writes it again.
        let taken = bytes.get(..room).unwrap_or(bytes);
        if taken.is_empty() && !bytes.is_empty() {
            return Poll::Pending;
        }
        self.waiting.extend(taken);
        match self.poll_out(cx) {
            Poll::Ready(Err(error)) => Poll::Ready(Err(error)),
            _ => Poll::Ready(Ok(taken.len())),
        }
    }
}

impl Drop for Link {
    /// Writes the remaining bytes, then disconnects the device. If the runtime is ending, only as
    /// much happens as can be started at once.
    fn drop(&mut self) {
        let _inside = self.runtime.enter();
        self.told = None;
        let mut writes: VecDeque<Writing> = self.writing.take().into_iter().collect();
        while let Some(chunk) = self.next_chunk() {
            writes.push_back(Arc::clone(&self.port).write(chunk));
        }
        let at_once = self.port.kind == WriteType::WithoutResponse;
        let device = self.disconnect.then(|| self.port.device.clone());
        see_off(&self.runtime, async move {
            // Writes without response need not wait for each other.
            if at_once {
                let mut cx = Context::from_waker(Waker::noop());
                writes.retain_mut(|writing| writing.as_mut().poll(&mut cx).is_pending());
            }
            for writing in writes {
                let _ = writing.await;
            }
            // At this point an error has no remedy.
            if let Some(device) = device {
                let _ = device.disconnect().await;
            }
        });
    }
}
