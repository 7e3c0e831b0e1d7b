//! Stored data: settings until the next reset, and the flash (model section 6).

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
    /// Settings sent by hosts.
    pub(crate) settings: Settings,
    flash: Flash,
    /// Number of writes to the flash since power-up.
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

    /// Resets the settings. The flash and the number of its writes stay.
    pub(crate) fn reset(&mut self, firmware: &Firmware) {
        self.settings = Settings::new(firmware);
    }

    pub(crate) fn flash(&self) -> &Flash {
        &self.flash
    }

    pub(crate) fn flash_writes(&self) -> u64 {
        self.writes
    }

    /// Changes the serial number without counting a write, as if it had always been there.
    pub(crate) fn begins_with_serial(&mut self, serial: DeviceSn) {
        self.flash.serial = serial;
    }

    /// Changes the flash and counts a write.
    pub(crate) fn write_flash(&mut self, change: impl FnOnce(&mut Flash)) {
        change(&mut self.flash);
        self.writes = self.writes.saturating_add(1);
    }
}
