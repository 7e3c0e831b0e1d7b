//! Identity of the arm (document 1.3), and undocumented ids that report it.

use magician_protocol::commands::*;
use magician_protocol::{Bytes, NoArgs};

use crate::device::context::Context;
use crate::device::effect::{Effects, ExecMode};
use crate::device::handlers::{Apply, Report, not_simulated, stored};
use crate::fidelity::Assumption;
use crate::profile::{MAX_NAME, MAX_SERIAL};

stored! {
    FirmwareMode in firmware_mode: OutsideTheDocument;
    Uart4PeripheralsEnabled in uart4: OutsideTheDocument;
}
not_simulated! { FirmwareSwitch: OutsideTheDocument; }

impl Report for DeviceSn {
    const ASSUMPTION: Assumption = Assumption::Identity;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.flash().serial
    }
}

impl Apply for DeviceSn {
    const ASSUMPTION: Assumption = Assumption::Identity;

    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        // Truncated, not refused: the vendor's buffer has that size (model section 15).
        let device_sn = self.device_sn.truncated(MAX_SERIAL);
        cx.store
            .write_flash(|flash| flash.serial = Self { device_sn });
        Effects::none()
    }
}

impl Report for DeviceName {
    const ASSUMPTION: Assumption = Assumption::Identity;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.flash().name
    }
}

impl Apply for DeviceName {
    const ASSUMPTION: Assumption = Assumption::Identity;

    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        let device_name = self.device_name.truncated(MAX_NAME);
        cx.store
            .write_flash(|flash| flash.name = Self { device_name });
        Effects::none()
    }
}

impl Report for DeviceVersion {
    const ASSUMPTION: Assumption = Assumption::Version;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        let [major_version, minor_version, revision] = cx.firmware.profile.identity.version;
        Self {
            major_version,
            minor_version,
            revision,
            // Newer firmware appends bytes of unknown meaning (E16).
            extra: Bytes::default(),
        }
    }
}

impl Report for DeviceWithL {
    const ASSUMPTION: Assumption = Assumption::RailSwitch;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        Self {
            // The get answers one byte, although the set has two (E15).
            with_l: cx.store.settings.motion.rail_setting.with_l,
        }
    }
}

impl Apply for SetDeviceWithL {
    const ASSUMPTION: Assumption = Assumption::RailSwitch;

    /// Applies to commands that start from now on; a moving carriage continues. The version of the
    /// rail has no effect here.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        cx.store.settings.motion.rail_setting = *self;
        Effects::none()
    }
}

impl Report for DeviceTime {
    const ASSUMPTION: Assumption = Assumption::Clock;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        // Wraps after 49.7 days: 32 bits of milliseconds (model section 15).
        let g_systick = (cx.now.micros_since(cx.booted) / 1000) as u32;
        Self { g_systick }
    }
}

impl Report for DeviceId {
    const ASSUMPTION: Assumption = Assumption::DeviceIdWords;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        // Derived from a seed: fixed for each virtual arm, and different between arms (model
        // section 15).
        let seed = cx.firmware.profile.identity.device_id_seed;
        let device_id = [1, 2, 3].map(|word| (scrambled(seed, word) >> 32) as u32);
        Self { device_id }
    }
}

/// Mixes a 64-bit seed: the finaliser of SplitMix64. Arms with neighbouring seeds get unrelated
/// ids.
fn scrambled(seed: u64, word: u64) -> u64 {
    let mut bits = seed.wrapping_add(word.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    bits ^ (bits >> 31)
}

impl Report for DeviceInfo {
    const ASSUMPTION: Assumption = Assumption::Zeros;

    fn report(_: &mut Context<'_>, _: &NoArgs) -> Self {
        Self {
            run_time: 0,
            power_on: 0,
            power_off: 0,
        }
    }
}

impl Report for Uart4PeripheralsModel {
    const ASSUMPTION: Assumption = Assumption::Zeros;

    fn report(_: &mut Context<'_>, _: &NoArgs) -> Self {
        Self { type_: 0 }
    }
}

impl Report for UserParams {
    const ASSUMPTION: Assumption = Assumption::Zeros;

    fn report(_: &mut Context<'_>, _: &NoArgs) -> Self {
        Self { params: [0.0; 8] }
    }
}
