//! What the controller keeps: settings until the next reset, and its flash without power (model
//! section 6).

pub(crate) mod flash;
pub(crate) mod program;
pub(crate) mod settings;

use magician_protocol::commands::DeviceSn;

use super::firmware::Firmware;
use flash::Flash;
use settings::Settings;

/// Settings and flash.
#[derive(Clone, Debug)]
pub(crate) struct Store {
    /// What hosts have set: a plain record, each value as it came.
    pub(crate) settings: Settings,
    flash: Flash,
    /// How often the flash has been written since power-up.
    writes: u64,
}

impl Store {
    pub(crate) fn new(firmware: &Firmware, flash: Flash) -> Self {
        Self {
            settings: Settings::new(firmware),
            flash,
            writes: 0,
        }
    }

    /// A reset forgets the settings; the flash stays, and so does the count of its writes.
    pub(crate) fn reset(&mut self, firmware: &Firmware) {
        self.settings = Settings::new(firmware);
    }

    pub(crate) fn flash(&self) -> &Flash {
        &self.flash
    }

    pub(crate) fn flash_writes(&self) -> u64 {
        self.writes
    }

    /// The flash has had this serial number all along: that is no write.
    pub(crate) fn begins_with_serial(&mut self, serial: DeviceSn) {
        self.flash.serial = serial;
    }

    /// Changes what the flash keeps.
    pub(crate) fn write_flash(&mut self, change: impl FnOnce(&mut Flash)) {
        change(&mut self.flash);
        self.writes = self.writes.saturating_add(1);
    }
}
