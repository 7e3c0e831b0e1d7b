use super::Micros;

/// So much may wait on the line when another frame is handed out, ns.
const AHEAD: u64 = 1_000_000;

/// How long the frames that were handed out keep a serial line busy, so that what is handed to the system is never much
/// more than what it can send at once: a byte that was handed over cannot be overtaken any more.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    baud: Option<u64>,
    /// When the last byte will have passed, ns.
    free: u64,
    /// A frame waits for its turn until then.
    wakes: Option<Micros>,
}

impl Pace {
    pub(super) fn new(baud: Option<u32>) -> Self {
        Self {
            baud: baud.filter(|baud| *baud > 0).map(u64::from),
            free: 0,
            wakes: None,
        }
    }

    /// A frame of so many bytes is handed out.
    pub(super) fn sent(&mut self, now: Micros, bytes: usize) {
        if self.baud.is_some() {
            let begins = self.free.max(now.saturating_mul(1000));
            self.free = begins.saturating_add(self.time(bytes));
        }
    }

    /// Whether another frame, no stop, may go; remembers when not.
    pub(super) fn admits(&mut self, now: Micros) -> bool {
        let from = self.free.saturating_sub(AHEAD).div_ceil(1000);
        self.wakes = (self.baud.is_some() && from > now).then_some(from);
        self.wakes.is_none()
    }

    /// Whether a short frame may go behind one of `before` bytes that was handed out: a stop then has to
    /// wait no longer than behind two frames of `before` bytes.
    pub(super) fn admits_behind(&self, now: Micros, before: usize, bytes: usize) -> bool {
        let spared = self.time(before).saturating_sub(self.time(bytes));
        self.free <= now.saturating_mul(1000).saturating_add(AHEAD + spared)
    }

    /// How long so many bytes are on the line, ns.
    fn time(&self, bytes: usize) -> u64 {
        let time = |baud| (bytes as u64).saturating_mul(10_000_000_000) / baud;
        self.baud.map_or(0, time)
    }

    /// When a frame that waits will be admitted.
    pub(super) fn wakes(&self) -> Option<Micros> {
        self.wakes
    }

    pub(super) fn pass(&mut self, now: Micros) {
        self.wakes = self.wakes.filter(|at| *at > now);
    }

    /// Nothing is on the line: all was answered, or the line is another one.
    pub(super) fn begin_anew(&mut self) {
        (self.free, self.wakes) = (0, None);
    }
}
