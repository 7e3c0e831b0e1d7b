//! Queue of messages to one client, bounded in bytes.
//!
//! Answers and notifications are limited separately; a client that reads too slowly is closed.
//! States are not stored as text: the queue holds a marker, and the text is made when the client
//! takes it, so a slow client misses states instead of collecting them.

use std::collections::VecDeque;

use super::CloseCode;

/// Most bytes of unsent notifications. A choice that bounds memory per client.
const MAX_NOTICE_BYTES: usize = 256 * 1024;
/// Most bytes of unsent answers: some of the largest ones, such as the preview of a program.
const MAX_ANSWER_BYTES: usize = 8 * 1024 * 1024;

#[derive(Debug)]
enum Waiting<K> {
    Answer(String),
    Notice(String),
    /// The newest state, made when it is sent.
    State(K),
}

/// Next message to a socket.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Next<K = u16> {
    /// Text message.
    Text(String),
    /// State of this subscription, to be made now.
    State(K),
    /// Close.
    Close(CloseCode),
}

/// Queue of messages to one client. `K` identifies states. A client that exceeds a limit is closed,
/// and nothing else is sent to it.
#[derive(Debug)]
pub struct Outbox<K = u16> {
    waiting: VecDeque<Waiting<K>>,
    notices: usize,
    answers: usize,
    /// Code of the close that follows the waiting messages.
    closing: Option<CloseCode>,
    /// True once the close was sent.
    ended: bool,
}

impl<K> Default for Outbox<K> {
    fn default() -> Self {
        Self {
            waiting: VecDeque::new(),
            notices: 0,
            answers: 0,
            closing: None,
            ended: false,
        }
    }
}

impl<K: Copy + PartialEq> Outbox<K> {
    /// True if the socket is being closed.
    #[must_use]
    pub fn is_closing(&self) -> bool {
        self.closing.is_some()
    }

    /// Closes the socket after the waiting messages. Keeps the code of an earlier call.
    pub fn close(&mut self, code: CloseCode) {
        self.closing.get_or_insert(code);
    }

    /// Closes the socket at once and drops all waiting messages.
    fn cut(&mut self, code: CloseCode) {
        // Frees the memory at once: a client that slow would not read the rest in time.
        self.waiting.clear();
        (self.notices, self.answers) = (0, 0);
        self.closing = Some(code);
    }

    /// Appends an answer.
    pub fn answer(&mut self, text: String) {
        // Nothing may follow a close.
        if self.ended {
            return;
        }
        self.answers += text.len();
        self.waiting.push_back(Waiting::Answer(text));
        if self.answers > MAX_ANSWER_BYTES {
            self.cut(CloseCode::SLOW);
        }
    }

    /// Appends a notification. No effect while closing.
    pub fn notice(&mut self, text: String) {
        // A client that is being closed still gets its answers, but no news.
        if self.closing.is_some() {
            return;
        }
        self.notices += text.len();
        self.waiting.push_back(Waiting::Notice(text));
        if self.notices > MAX_NOTICE_BYTES {
            self.cut(CloseCode::SLOW);
        }
    }

    /// Prepends a notification, to be sent together with the state that is being sent.
    pub fn notice_next(&mut self, text: String) {
        self.notices += text.len();
        // In front, because the state's frame is sent by the caller just now.
        self.waiting.push_front(Waiting::Notice(text));
    }

    /// Marks a state as due. Returns false if it is waiting already, because it will be the newest
    /// anyway, or while closing.
    pub fn state_due(&mut self, what: K) -> bool {
        let waits = |waiting: &Waiting<K>| matches!(waiting, Waiting::State(id) if *id == what);
        if self.closing.is_some() || self.waiting.iter().any(waits) {
            return false;
        }
        self.waiting.push_back(Waiting::State(what));
        true
    }

    /// Removes a state that was due.
    pub fn drop_state(&mut self, what: K) {
        self.waiting
            .retain(|waiting| !matches!(waiting, Waiting::State(id) if *id == what));
    }

    /// Returns the size of waiting texts, bytes. States do not count.
    #[must_use]
    pub fn unsent(&self) -> usize {
        let text = |waiting: &Waiting<K>| match waiting {
            Waiting::Answer(text) | Waiting::Notice(text) => text.len(),
            Waiting::State(_) => 0,
        };
        self.waiting.iter().map(text).sum()
    }

    /// Removes and returns the next message. `None` if none waits.
    pub fn pop(&mut self) -> Option<Next<K>> {
        match self.waiting.pop_front() {
            Some(Waiting::Answer(text)) => {
                self.answers -= text.len();
                Some(Next::Text(text))
            }
            Some(Waiting::Notice(text)) => {
                self.notices -= text.len();
                Some(Next::Text(text))
            }
            Some(Waiting::State(what)) => Some(Next::State(what)),
            None => {
                self.ended = self.closing.is_some();
                self.closing.map(Next::Close)
            }
        }
    }
}
