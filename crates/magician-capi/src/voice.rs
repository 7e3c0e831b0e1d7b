//! Remedies for errors in terms of the vendor's interface: names of its functions.

use magician::{Action, PinUse, Setting, SettingValue, Voice};

/// [`Voice`] of the vendor's library.
pub(crate) struct Vendor;

impl Voice for Vendor {
    fn action(&self, action: Action) -> String {
        match action {
            Action::ClearAlarms => "ClearAllAlarmsState",
            Action::ListAlarms => "GetAlarmsState",
            Action::StartQueue => "SetQueuedCmdStartExec",
            Action::Stop => "SetQueuedCmdForceStopExec with SetQueuedCmdClear",
            Action::StopJog => "SetJOGCmd with command 0",
            Action::Jog => "SetJOGCmd",
            Action::Home => "SetHOMECmd",
            Action::LaserOff => "SetEndEffectorLaser with 0, 0",
            Action::SuctionOff => "SetEndEffectorSuctionCup with 0, 0",
            Action::GripperOff => "SetEndEffectorGripper with 0, 0",
            Action::ListPorts => "SearchDobot",
            Action::UseRail => "SetDeviceWithL",
            other => return other.name().to_owned(),
        }
        .to_owned()
    }

    fn give(&self, setting: Setting, given: &SettingValue) -> String {
        match setting {
            Setting::Port => format!("{} {given}", self.setting(setting)),
            setting => format!("{} {given} in another program", self.setting(setting)),
        }
    }

    fn set_pin(&self, pin: u8, function: PinUse) -> String {
        format!("SetIOMultiplexing of {pin} to {}", function.name())
    }

    fn setting(&self, setting: Setting) -> String {
        match setting {
            Setting::Port => "ConnectDobot with".to_owned(),
            setting => setting.name().to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use magician::Remedy;

    use super::*;

    #[test]
    fn actions_are_functions_of_the_vendor() {
        for action in Action::ALL {
            let said = Vendor.action(*action);
            let function = said.split(' ').next().unwrap_or_default();
            let known = crate::FUNCTIONS.iter().any(|known| known.name == function);
            let absent = [
                Action::ListCommands,
                Action::CalibrateSurface,
                Action::TouchOff,
                Action::Engrave,
            ];
            assert!(known || absent.contains(action), "{said}");
        }
    }

    #[test]
    fn remedies_are_one_sentence() {
        let remedies = [
            Remedy::new(Action::Home, "homes it"),
            Remedy::new(
                (Setting::Port, SettingValue::Word("sim")),
                "is a virtual arm",
            ),
        ];
        let said = "SetHOMECmd homes it; ConnectDobot with sim is a virtual arm";
        assert_eq!(Vendor.remedies(&remedies).as_deref(), Some(said));
    }
}
