//! Recording of a served arm, if requested.

#[cfg(feature = "record")]
pub(super) use on::Recording;

#[cfg(not(feature = "record"))]
pub(super) use off::Recording;

#[cfg(feature = "record")]
mod on {
    use std::io::{self, Write};
    use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
    use std::time::SystemTime;

    use super::super::ServeError;
    use super::super::behind::{Full, WriteBehind};
    use magician_record::mcap::Recorder;
    use magician_sim::{LinkId, Runner, Speed};

    type Shared = Arc<Mutex<Recorder<WriteBehind>>>;

    /// Recorder that observes the arm's runner.
    #[derive(Default)]
    pub(in super::super) struct Recording {
        recorder: Option<Shared>,
        told: bool,
    }

    impl Recording {
        /// Starts a recording; the epoch is now. At full speed the arm's clock waits for a slow
        /// disk; otherwise it does not.
        pub(in super::super) fn begin(
            out: Box<dyn Write + Send>,
            runner: &mut Runner,
            speed: Speed,
        ) -> Result<Self, ServeError> {
            let full = match speed {
                Speed::Max => Full::Wait,
                Speed::Times(_) => Full::Fail,
            };
            // The file counts from the start of the arm's clock, so the epoch is now minus that.
            let since_1970 = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
            let millis = u64::try_from(since_1970.as_millis()).unwrap_or_default();
            let clock = runner.controller().now();
            let epoch = millis
                .saturating_mul(1_000_000)
                .saturating_sub(clock.as_micros().saturating_mul(1000));
            let recorder = WriteBehind::new(out, full).and_then(|out| Recorder::new(out, epoch));
            let recorder = Arc::new(Mutex::new(recorder.map_err(ServeError::Record)?));
            runner.observe(Arc::clone(&recorder));
            Ok(Self {
                recorder: Some(recorder),
                told: false,
            })
        }

        fn recorder(&self) -> Option<MutexGuard<'_, Recorder<WriteBehind>>> {
            let recorder = self.recorder.as_ref()?;
            Some(recorder.lock().unwrap_or_else(PoisonError::into_inner))
        }

        /// Names a link.
        pub(in super::super) fn name(&self, link: LinkId, name: &str) {
            if let Some(mut recorder) = self.recorder() {
                recorder.name(link, name);
            }
        }

        /// Returns the reason for an early end, once.
        pub(in super::super) fn ended(&mut self) -> Option<io::Error> {
            if self.told {
                return None;
            }
            let error = {
                let recorder = self.recorder()?;
                let error = recorder.error()?;
                io::Error::new(error.kind(), error.to_string())
            };
            self.told = true;
            Some(error)
        }

        /// Completes the file.
        pub(in super::super) fn end(&mut self, runner: &mut Runner) -> Result<(), ServeError> {
            let Some(recorder) = self.recorder.take() else {
                return Ok(());
            };
            runner.unobserve();
            let Some(recorder) = Arc::into_inner(recorder) else {
                return Ok(());
            };
            let recorder = recorder
                .into_inner()
                // A panic while recording leaves a file that may still be completed.
                .unwrap_or_else(PoisonError::into_inner);
            let finished = recorder.finish().and_then(|behind| behind.finish());
            finished.map_err(ServeError::Record)
        }
    }
}

/// Empty substitute without the feature.
#[cfg(not(feature = "record"))]
mod off {
    use std::io;

    use super::super::ServeError;
    use magician_sim::{LinkId, Runner};

    #[derive(Default)]
    pub(in super::super) struct Recording(());

    impl Recording {
        pub(in super::super) fn name(&self, _: LinkId, _: &str) {}

        pub(in super::super) fn ended(&mut self) -> Option<io::Error> {
            None
        }

        pub(in super::super) fn end(&mut self, _: &mut Runner) -> Result<(), ServeError> {
            Ok(())
        }
    }
}
