//! Whoever looks on as the arm is served: a recording, if there is one.

#[cfg(feature = "record")]
pub(super) use recording::{Watch, begin};

/// Without the feature nobody looks on.
#[cfg(not(feature = "record"))]
pub(super) type Watch = ();

#[cfg(feature = "record")]
mod recording {
    use std::io::{self, Write};
    use std::time::SystemTime;

    use crate::record::{Full, Recorder, WriteBehind};
    use crate::{Micros, Speed};

    pub(in super::super) type Watch = Option<Recorder<WriteBehind>>;

    /// Begins a recording of an arm whose clock shows `now`. At full speed the arm's clock waits for the disk;
    /// otherwise it does not.
    pub(in super::super) fn begin(
        out: Box<dyn Write + Send>,
        now: Micros,
        speed: Speed,
    ) -> io::Result<Watch> {
        let full = match speed {
            Speed::Max => Full::Wait,
            Speed::Times(_) => Full::Fail,
        };
        let since_1970 = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
        let millis = u64::try_from(since_1970.as_millis()).unwrap_or_default();
        let epoch = millis
            .saturating_mul(1_000_000)
            .saturating_sub(now.saturating_mul(1000));
        Recorder::new(WriteBehind::new(out, full)?, epoch).map(Some)
    }
}
