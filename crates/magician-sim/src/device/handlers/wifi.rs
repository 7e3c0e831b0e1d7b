//! The Wi-Fi module's settings (document 1.17, model section 15). The flash keeps them, but for the command mode in which
//! they are set.

use magician_protocol::commands::*;
use magician_protocol::{Flag, NoArgs};

use crate::convert::micros;
use crate::device::Device;
use crate::device::dispatch::{Apply, Report, Step, Turn, kept};

impl Report for WifiConfigMode {
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        core.settings.wifi_config
    }
}

impl Apply for WifiConfigMode {
    /// When the module leaves its command mode it looks for the network anew.
    fn apply(&self, core: &mut Device, _: Turn) -> Step {
        core.settings.wifi_config = *self;
        core.wifi_begun = core.now;
        Step::Done
    }
}

kept!(
    WifiSsid in wifi_ssid,
    WifiPassword in wifi_password,
    WifiIpAddress in wifi_address,
    WifiNetmask in wifi_netmask,
    WifiGateway in wifi_gateway,
    WifiDns in wifi_dns,
);

impl Report for WifiConnectStatus {
    /// Any network that has a name is there, and is joined after a while.
    fn report(core: &mut Device, _: &NoArgs) -> Self {
        let named = !core.flash.wifi_ssid.ssid.as_bytes().is_empty();
        let looks = !core.settings.wifi_config.enable.is_on();
        let begun = core.wifi_begun.max(core.booted);
        let found = begun.saturating_add(micros(core.profile.wifi.association));
        Self {
            is_connected: Flag::from(named && looks && core.now >= found),
        }
    }
}
