//! The Wi-Fi module's settings (document 1.17). The flash keeps them, but for the mode of its command line; no network is joined.

use magician_protocol::commands::*;
use magician_protocol::{Flag, NoArgs};

use crate::core::Core;
use crate::dispatch::{Report, kept, stored};

stored!(WifiConfigMode in wifi_config);
kept!(
    WifiSsid in wifi_ssid,
    WifiPassword in wifi_password,
    WifiIpAddress in wifi_address,
    WifiNetmask in wifi_netmask,
    WifiGateway in wifi_gateway,
    WifiDns in wifi_dns,
);

impl Report for WifiConnectStatus {
    fn report(core: &mut Core, _: &NoArgs) -> Self {
        Self {
            is_connected: Flag::from(core.profile.defaults.wifi.connected),
        }
    }
}
