use magician_protocol::FrameBuf;

use super::Client;
use crate::connection::Micros;

/// Most answers that are kept.
const MOST: usize = 32;

/// A reply of the arm that can be shared with clients that ask the same.
#[derive(Debug)]
struct Reading {
    request: FrameBuf,
    reply: FrameBuf,
    at: Micros,
    /// The clients that have had it: none gets the same reply twice.
    had: Vec<Client>,
}

/// The latest answers. They are worth nothing as soon as anything may have changed.
#[derive(Debug, Default)]
pub(super) struct Readings {
    readings: Vec<Reading>,
}

impl Readings {
    /// Keeps an answer that these clients have had.
    pub(super) fn keep(
        &mut self,
        now: Micros,
        request: FrameBuf,
        reply: FrameBuf,
        had: Vec<Client>,
    ) {
        self.readings.retain(|reading| reading.request != request);
        if self.readings.len() >= MOST {
            self.readings.remove(0);
        }
        self.readings.push(Reading {
            request,
            reply,
            at: now,
            had,
        });
    }

    /// An answer that is not older than `fresh` and that this client has not had.
    pub(super) fn take(
        &mut self,
        now: Micros,
        fresh: Micros,
        client: Client,
        request: &FrameBuf,
    ) -> Option<FrameBuf> {
        let will_do = |reading: &&mut Reading| {
            reading.request == *request
                && now.saturating_sub(reading.at) < fresh
                && !reading.had.contains(&client)
        };
        let reading = self.readings.iter_mut().find(will_do)?;
        reading.had.push(client);
        Some(reading.reply)
    }

    pub(super) fn forget(&mut self) {
        self.readings.clear();
    }

    /// The number may name another client from now on.
    pub(super) fn forget_client(&mut self, client: Client) {
        for reading in &mut self.readings {
            reading.had.retain(|other| *other != client);
        }
    }
}
