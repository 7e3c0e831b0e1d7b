//! Remedies for errors and notes in terms of Python: methods and arguments.

use magician::{Action, PinUse, Setting, SettingValue, Voice};

/// [`Voice`] of the Python package.
pub(crate) struct Python;

impl Voice for Python {
    fn action(&self, action: Action) -> String {
        let call = match action {
            Action::ClearAlarms => "arm.clear_alarms()",
            Action::ListAlarms => "arm.alarms()",
            Action::StartQueue => "arm.start_queue()",
            Action::Stop => "arm.stop()",
            Action::StopJog => "arm.stop_jog()",
            Action::Jog => "arm.jog(..)",
            Action::Home => "arm.home()",
            Action::LaserOff => "arm.laser(False)",
            Action::SuctionOff => "arm.suction(False)",
            Action::GripperOff => "arm.pump_off()",
            Action::ListPorts => "magician.ports()",
            Action::ListCommands => "magician.commands",
            Action::UseRail => "arm.rail(True, ..)",
            Action::CalibrateSurface => "magician calibrate surface",
            Action::TouchOff => "arm.touch_off()",
            Action::Engrave => "magician.load(.., work=\"engrave\")",
            other => return other.name().to_owned(),
        };
        format!("`{call}`")
    }

    fn give(&self, setting: Setting, given: &SettingValue) -> String {
        // These two are methods of their own, not arguments.
        match setting {
            Setting::Loops => return "`plan.repeated(times)`".to_owned(),
            Setting::SpeedRatio => return "`arm.speed(percent)`".to_owned(),
            _ => {}
        }
        let value = match given {
            SettingValue::On => "True".to_owned(),
            SettingValue::Off => "False".to_owned(),
            SettingValue::Number(number) => number.to_string(),
            SettingValue::Point(x, y) => format!("({x}, {y})"),
            SettingValue::Position([x, y, z]) => format!("({x:.3}, {y:.3}, {z:.3})"),
            SettingValue::Word(word) => format!("\"{word}\""),
            SettingValue::Any(name) if name.contains(',') => {
                format!("({})", name.to_lowercase().replace(',', ", "))
            }
            SettingValue::Any(name) => name.to_lowercase().replace('/', "_per_"),
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        };
        format!("{}={value}", self.setting(setting))
    }

    fn set_pin(&self, pin: u8, function: PinUse) -> String {
        format!("`arm.multiplex({pin}, \"{}\")`", function.name())
    }

    fn system(&self, line: &str) -> String {
        format!("`{line}`")
    }

    fn use_station(&self, url: &str) -> String {
        format!("`magician.Station(\"{url}\")`")
    }

    fn setting(&self, setting: Setting) -> String {
        setting.name().to_owned()
    }
}
