//! Settings of the Wi-Fi module (document 1.17, model section 15). The flash keeps all of them
//! except the command mode.

use magician_protocol::commands::*;
use magician_protocol::{Flag, NoArgs};

use crate::convert::micros;
use crate::device::context::Context;
use crate::device::effect::{Effects, ExecMode};
use crate::device::handlers::{Apply, Report, kept};
use crate::fidelity::Assumption;

impl Report for WifiConfigMode {
    const ASSUMPTION: Assumption = Assumption::WifiSettings;

    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        cx.store.settings.wifi_config
    }
}

impl Apply for WifiConfigMode {
    const ASSUMPTION: Assumption = Assumption::WifiSettings;

    /// Leaving the command mode makes the module join its network again.
    fn apply(&self, cx: &mut Context<'_>, _: ExecMode) -> Effects {
        cx.store.settings.wifi_config = *self;
        cx.store.settings.wifi_begun = cx.now;
        Effects::none()
    }
}

kept! {
    WifiSsid in wifi_ssid: WifiSettings, at first WifiDefaults;
    WifiPassword in wifi_password: WifiSettings, at first WifiDefaults;
    WifiIpAddress in wifi_address: WifiSettings, at first WifiDefaults;
    WifiNetmask in wifi_netmask: WifiSettings, at first WifiDefaults;
    WifiGateway in wifi_gateway: WifiSettings, at first WifiDefaults;
    WifiDns in wifi_dns: WifiSettings, at first WifiDefaults;
}

impl Report for WifiConnectStatus {
    const ASSUMPTION: Assumption = Assumption::WifiStatus;

    /// Reports whether a network with a name has been joined: any name works, after a delay.
    fn report(cx: &mut Context<'_>, _: &NoArgs) -> Self {
        let named = !cx.store.flash().wifi_ssid.ssid.as_bytes().is_empty();
        let looks = !cx.store.settings.wifi_config.enable.is_on();
        // A reset restarts the module as well.
        let begun = cx.store.settings.wifi_begun.max(cx.booted);
        let found = begun.after_micros(micros(cx.firmware.profile.wifi.association));
        Self {
            is_connected: Flag::from(named && looks && cx.now >= found),
        }
    }
}
