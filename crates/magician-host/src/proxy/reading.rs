//! Replies that several clients can share.

use magician_protocol::FrameBuf;

use super::Client;
use crate::connection::Micros;

/// Largest number of replies kept.
// A choice: more than any client polls.
const MAX_READINGS: usize = 32;

/// A reply of the arm that can be shared with other clients that send the same request.
#[derive(Debug)]
struct Reading {
    request: FrameBuf,
    reply: FrameBuf,
    at: Micros,
    /// Clients that have got it: no client gets it twice.
    had: Vec<Client>,
}

/// Latest replies, discarded as soon as anything may have changed.
#[derive(Debug, Default)]
pub(super) struct Readings {
    readings: Vec<Reading>,
}

impl Readings {
    /// Keeps a reply that these clients have got.
    pub(super) fn keep(
        &mut self,
        now: Micros,
        request: FrameBuf,
        reply: FrameBuf,
        had: Vec<Client>,
    ) {
        // One reply per request: an older one would only be less fresh.
        self.readings.retain(|reading| reading.request != request);
        if self.readings.len() >= MAX_READINGS {
            self.readings.remove(0);
        }
        self.readings.push(Reading {
            request,
            reply,
            at: now,
            had,
        });
    }

    /// Returns a reply that is younger than `max_reply_age` and new to this client. `None` if no
    /// kept reply fits.
    pub(super) fn take(
        &mut self,
        now: Micros,
        max_reply_age: Micros,
        client: Client,
        request: &FrameBuf,
    ) -> Option<FrameBuf> {
        let will_do = |reading: &&mut Reading| {
            reading.request == *request
                && now.saturating_sub(reading.at) < max_reply_age
                && !reading.had.contains(&client)
        };
        let reading = self.readings.iter_mut().find(will_do)?;
        reading.had.push(client);
        Some(reading.reply)
    }

    pub(super) fn forget(&mut self) {
        self.readings.clear();
    }

    /// Forgets a client, whose number may identify another one from now on.
    pub(super) fn forget_client(&mut self, client: Client) {
        for reading in &mut self.readings {
            reading.had.retain(|other| *other != client);
        }
    }
}
