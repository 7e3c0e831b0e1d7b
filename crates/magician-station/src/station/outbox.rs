//! What waits to be sent to a client: bounded, and of states the newest.

use std::collections::VecDeque;

use super::CloseCode;

/// Unsent notifications and frames, bytes.
const NOTICES: usize = 256 * 1024;
/// Unsent answers, bytes.
const ANSWERS: usize = 8 * 1024 * 1024;

#[derive(Debug)]
enum Waiting<K> {
    Answer(String),
    Notice(String),
    /// The newest state, made when it is sent.
    State(K),
}

/// What a socket sends next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Next<K = u16> {
    /// A text.
    Text(String),
    /// The state of this, as it is now.
    State(K),
    /// The end.
    Close(CloseCode),
}

/// What waits to be sent to a client, with states of what `K` names. One that reads too little is at its end: by then nothing
/// else is sent.
#[derive(Debug)]
pub struct Outbox<K = u16> {
    waiting: VecDeque<Waiting<K>>,
    notices: usize,
    answers: usize,
    /// It is over when what waits was sent.
    closing: Option<CloseCode>,
    /// The end was sent.
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
    /// Whether it comes to its end.
    #[must_use]
    pub fn is_closing(&self) -> bool {
        self.closing.is_some()
    }

    /// Ends it when what waits was sent.
    pub fn close(&mut self, code: CloseCode) {
        self.closing.get_or_insert(code);
    }

    /// Ends it now: what waits is not sent.
    fn cut(&mut self, code: CloseCode) {
        self.waiting.clear();
        (self.notices, self.answers) = (0, 0);
        self.closing = Some(code);
    }

    /// An answer.
    pub fn answer(&mut self, text: String) {
        // Nothing comes behind the end.
        if self.ended {
            return;
        }
        self.answers += text.len();
        self.waiting.push_back(Waiting::Answer(text));
        if self.answers > ANSWERS {
            self.cut(CloseCode::SLOW);
        }
    }

    /// A notification.
    pub fn notice(&mut self, text: String) {
        if self.closing.is_some() {
            return;
        }
        self.notices += text.len();
        self.waiting.push_back(Waiting::Notice(text));
        if self.notices > NOTICES {
            self.cut(CloseCode::SLOW);
        }
    }

    /// A notification that goes with the state that is sent just now.
    pub fn notice_next(&mut self, text: String) {
        self.notices += text.len();
        self.waiting.push_front(Waiting::Notice(text));
    }

    /// A state is due. One that waits already is the newest when it is sent.
    pub fn state_due(&mut self, what: K) -> bool {
        let waits = |waiting: &Waiting<K>| matches!(waiting, Waiting::State(id) if *id == what);
        if self.closing.is_some() || self.waiting.iter().any(waits) {
            return false;
        }
        self.waiting.push_back(Waiting::State(what));
        true
    }

    /// A state that was due is not sent.
    pub fn state_is_void(&mut self, what: K) {
        self.waiting
            .retain(|waiting| !matches!(waiting, Waiting::State(id) if *id == what));
    }

    /// What waits to be sent: bytes, without states.
    #[must_use]
    pub fn unsent(&self) -> usize {
        let text = |waiting: &Waiting<K>| match waiting {
            Waiting::Answer(text) | Waiting::Notice(text) => text.len(),
            Waiting::State(_) => 0,
        };
        self.waiting.iter().map(text).sum()
    }

    /// What is to be sent next: a text, a state, or the end.
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
