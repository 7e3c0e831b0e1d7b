//! Persistence of the arm's flash in a file.

use std::path::PathBuf;
use std::time::Duration;

use magician_sim::{Controller, HostInstant};

use super::files::{FlashFileError, save_flash};

/// Delay of a write after a change. Choice: ten settings in a row then cause a single write.
const DELAY: Duration = Duration::from_millis(500);

/// Flash file, and the state of the flash it contains.
pub(super) struct FlashFile {
    path: PathBuf,
    written: u64,
    /// Time of the next write.
    due: Option<HostInstant>,
    /// True if the last write failed.
    failed: bool,
}

impl FlashFile {
    /// Creates a keeper; the file holds the flash at power-up, or will hold it.
    pub(super) fn new(path: PathBuf, controller: &Controller) -> Self {
        Self {
            path,
            written: controller.flash_writes(),
            due: None,
            failed: false,
        }
    }

    /// Writes changes some time after the first. A failed write is repeated with the next change or
    /// at the end.
    pub(super) fn keep(
        &mut self,
        now: HostInstant,
        controller: &Controller,
    ) -> Result<(), FlashFileError> {
        if controller.flash_writes() == self.written {
            return Ok(());
        }
        let due = *self.due.get_or_insert(now + DELAY);
        if due > now {
            return Ok(());
        }
        self.write(controller)
    }

    /// Returns the time of the next write.
    pub(super) fn due(&self) -> Option<HostInstant> {
        self.due
    }

    /// Writes outstanding changes at the end.
    pub(super) fn finish(&mut self, controller: &Controller) -> Result<(), FlashFileError> {
        if self.failed || controller.flash_writes() != self.written {
            return self.write(controller);
        }
        Ok(())
    }

    fn write(&mut self, controller: &Controller) -> Result<(), FlashFileError> {
        self.due = None;
        self.written = controller.flash_writes();
        let saved = save_flash(controller.flash(), &self.path);
        self.failed = saved.is_err();
        saved
    }
}

#[cfg(test)]
mod tests {
    use super::super::files::load_flash;
    use super::*;
    use magician_protocol::commands::DeviceName;
    use magician_protocol::{Ctrl, FrameBuf};
    use magician_sim::{LinkId, Profile, World};

    const BEGIN: HostInstant = HostInstant::ZERO;

    fn rename(controller: &mut Controller, name: &[u8]) {
        let frame = FrameBuf::new(1, Ctrl::SET, name).unwrap();
        controller.receive(LinkId(0), frame.bytes());
    }

    fn name(path: &std::path::Path) -> Option<String> {
        let flash = load_flash(path).unwrap()?;
        let mut arm = Controller::with_flash(Profile::default(), World::default(), flash);
        let get = FrameBuf::new(1, Ctrl::GET, &[]).unwrap();
        let replies = arm.exchange(LinkId(0), get.bytes());
        let name = replies[0].frame().read::<DeviceName>().unwrap();
        Some(name.device_name.as_str().unwrap().to_owned())
    }

    #[test]
    fn changes_are_written_together_a_while_after_the_first() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("flash");
        let mut arm = Controller::default();
        let mut keeper = FlashFile::new(path.clone(), &arm);
        keeper.keep(BEGIN, &arm).unwrap();
        keeper.finish(&arm).unwrap();
        assert_eq!((keeper.due(), name(&path)), (None, None), "nothing to keep");

        let changed = BEGIN + Duration::from_millis(1);
        rename(&mut arm, b"one\0");
        keeper.keep(changed, &arm).unwrap();
        assert_eq!(keeper.due(), Some(changed + DELAY));
        rename(&mut arm, b"two\0");
        keeper.keep(BEGIN + DELAY, &arm).unwrap();
        assert_eq!(name(&path), None);
        keeper.keep(changed + DELAY, &arm).unwrap();
        assert_eq!(keeper.due(), None);
        assert_eq!(name(&path).as_deref(), Some("two"));

        rename(&mut arm, b"three\0");
        keeper.finish(&arm).unwrap();
        assert_eq!(name(&path).as_deref(), Some("three"));
    }

    #[test]
    fn what_could_not_be_written_is_written_at_the_end() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("later/flash");
        let mut arm = Controller::default();
        let mut keeper = FlashFile::new(path.clone(), &arm);
        rename(&mut arm, b"one\0");
        keeper.keep(BEGIN, &arm).unwrap();
        assert!(keeper.keep(BEGIN + DELAY, &arm).is_err());
        assert!(keeper.keep(BEGIN + 9 * DELAY, &arm).is_ok(), "said once");
        std::fs::create_dir(directory.path().join("later")).unwrap();
        keeper.finish(&arm).unwrap();
        assert_eq!(name(&path).as_deref(), Some("one"));
    }
}
