//! Table of all settings: name, meaning, default, and how a value is checked.

use magician::Target;
use magician_job::settings::quoted;
use magician_program::{Power, SetupOptions, Tool};
use magician_station::http::Listener;
use toml::de::DeValue;

use crate::numbers::numbers;

/// Setting of the configuration file.
pub(crate) struct Key {
    /// Name of the setting. A part before a dot is a table of the file.
    pub(crate) name: &'static str,
    /// Description for the list of settings.
    pub(crate) about: &'static str,
    /// Environment variable that overrides the setting.
    pub(crate) variable: Option<&'static str>,
    /// Value that applies while it is not set.
    pub(crate) default: &'static str,
    /// Type of the value.
    pub(crate) kind: ValueType,
}

/// Type of a setting's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ValueType {
    Port,
    Tool,
    /// Whole number from 1 to 8.
    Window,
    /// Height in mm; or a table with height and slope, which a station writes.
    Surface,
    /// Number, checked by the drawing option of this name.
    Option(&'static str),
    /// Whole number from 0 to 50: times a second.
    Rate,
    /// Percentage from 0 to 100, or two of them.
    Power,
    /// X,Y,Z in mm.
    Place,
    /// Table that another verb writes.
    Sheet,
    /// HOST:PORT to listen at.
    Address,
    /// Texts, typed with commas between them; a list in the file.
    List,
    /// Path of a folder.
    Folder,
    /// true or false.
    Switch,
}

/// All settings.
pub(crate) const KEYS: [Key; 19] = [
    Key {
        name: "port",
        about: "port of the arm, like --port",
        variable: Some("MAGICIAN_PORT"),
        default: "the only arm found",
        kind: ValueType::Port,
    },
    Key {
        name: "tool",
        about: "tool on the arm: none, suction, gripper, pen, laser, or X,Y,Z in mm",
        variable: Some("MAGICIAN_TOOL"),
        default: "chosen by the verb or the program",
        kind: ValueType::Tool,
    },
    Key {
        name: "window",
        about: "requests in flight at once, 1 to 8",
        variable: Some("MAGICIAN_WINDOW"),
        default: "1",
        kind: ValueType::Window,
    },
    Key {
        name: "surface",
        about: "height of the work surface, mm: z of `magician pose` when the tool touches it",
        variable: None,
        default: "none; -60 for a virtual arm",
        kind: ValueType::Surface,
    },
    Key {
        name: "sheet",
        about: "position, rotation and height of the sheet, measured by `magician calibrate`",
        variable: None,
        default: "not calibrated",
        kind: ValueType::Sheet,
    },
    Key {
        name: "park",
        about: "parking position of the tip of the tool at the end of a file: X,Y,Z in mm",
        variable: None,
        default: "not parked",
        kind: ValueType::Place,
    },
    Key {
        name: "draw.speed",
        about: "speed of the pen on the paper, mm/s",
        variable: None,
        default: "50",
        kind: ValueType::Option("speed"),
    },
    Key {
        name: "draw.travel_speed",
        about: "speed of the pen above the paper, mm/s",
        variable: None,
        default: "200",
        kind: ValueType::Option("travel_speed"),
    },
    Key {
        name: "draw.lift",
        about: "pen lift above the paper, mm",
        variable: None,
        default: "10",
        kind: ValueType::Option("lift"),
    },
    Key {
        name: "engrave.speed",
        about: "speed of the laser for drawings, images, and G-code before its first F, mm/s; if \
            not set, images are burnt at the highest constant speed, at most 20",
        variable: None,
        default: "20",
        kind: ValueType::Option("speed"),
    },
    Key {
        name: "engrave.power",
        about: "full power of the laser, percent, or LEAST..MOST, like --power",
        variable: None,
        default: "100",
        kind: ValueType::Power,
    },
    Key {
        name: "serve.listen",
        about: "address at which `magician serve` listens, HOST:PORT, like --listen",
        variable: None,
        default: "localhost:8910",
        kind: ValueType::Address,
    },
    Key {
        name: "serve.allow_host",
        about: "additional host names of the station, HOST[:PORT],.., like --allow-host",
        variable: None,
        default: "none",
        kind: ValueType::List,
    },
    Key {
        name: "serve.allow_origin",
        about: "origins of web pages that may use the station, like --allow-origin",
        variable: None,
        default: "none",
        kind: ValueType::List,
    },
    Key {
        name: "serve.student_laser",
        about: "allow the role student to switch on the laser of a real arm: true or false",
        variable: None,
        default: "false",
        kind: ValueType::Switch,
    },
    Key {
        name: "serve.programs",
        about: "folder of the station's program library, like --programs",
        variable: None,
        default: "`programs` in magician's user data folder",
        kind: ValueType::Folder,
    },
    Key {
        name: "serve.link",
        about: "serve programs for DobotLink, like --link: true or false",
        variable: None,
        default: "false",
        kind: ValueType::Switch,
    },
    Key {
        name: "serve.ring",
        about: "readings per second, 0 to 50, in a station's recording of the last ten minutes \
            while an arm moves; at most 5 while it stands; 0 records only what clients read",
        variable: None,
        default: "50",
        kind: ValueType::Rate,
    },
    Key {
        name: "serve.save_on_alarm",
        about: "save the last ten minutes to a file when an alarm occurs: true or false",
        variable: None,
        default: "true",
        kind: ValueType::Switch,
    },
];

impl Key {
    /// Finds a setting by name; `-` is accepted for `_`.
    pub(crate) fn named(name: &str) -> Option<&'static Self> {
        let name = name.replace('-', "_");
        KEYS.iter().find(|key| key.name == name)
    }

    /// Converts a value as typed by the user into TOML.
    pub(crate) fn write(&self, text: &str) -> Result<String, String> {
        let text = text.trim();
        match self.kind {
            ValueType::Port => {
                let target = text.parse::<Target>().map_err(|error| error.to_string());
                target.map(|_| quoted(text))
            }
            ValueType::Tool => text.parse::<Tool>().map(|tool| quoted(&tool.to_string())),
            ValueType::Window | ValueType::Rate => {
                self.number(text).map(|value| format!("{value:.0}"))
            }
            ValueType::Surface => self.number(text).map(|value| value.to_string()),
            ValueType::Option(option) => {
                check(option, text)?;
                self.number(text).map(|value| value.to_string())
            }
            ValueType::Power => {
                check("power", text)?;
                let power = text.parse::<Power>()?.to_string();
                // A single power stays a number in the file, for files from before ranges were
                // supported.
                Ok(if power.contains("..") {
                    quoted(&power)
                } else {
                    power
                })
            }
            ValueType::Place => numbers::<3>(text).map(|_| quoted(text)),
            ValueType::Sheet => Err("set it with `magician calibrate`".to_owned()),
            ValueType::Address => match Listener::check(text) {
                Ok(()) => Ok(quoted(text)),
                Err(error) => Err(error.to_string()),
            },
            ValueType::List => {
                let texts: Vec<_> = list(text).map(toml::Value::from).collect();
                Ok(toml::Value::from(texts).to_string())
            }
            ValueType::Folder if text.is_empty() => Err("expected a folder".to_owned()),
            ValueType::Folder => Ok(quoted(text)),
            ValueType::Switch if ["true", "false"].contains(&text) => Ok(text.to_owned()),
            ValueType::Switch => Err("expected true or false".to_owned()),
        }
    }

    /// Converts a value of a file into what a user would type.
    pub(super) fn read(&self, value: &DeValue<'_>) -> Result<String, String> {
        let text = match (self.kind, value) {
            (ValueType::Sheet, DeValue::Table(_)) => return Ok("calibrated".to_owned()),
            (ValueType::Sheet, _) => return Err("expected a table".to_owned()),
            (ValueType::Surface, DeValue::Table(_)) => return Ok("tilted".to_owned()),
            (
                ValueType::Port
                | ValueType::Tool
                | ValueType::Place
                | ValueType::Power
                | ValueType::Address
                | ValueType::Folder,
                DeValue::String(text),
            ) => text.to_string(),
            (
                ValueType::Port
                | ValueType::Tool
                | ValueType::Place
                | ValueType::Address
                | ValueType::Folder,
                _,
            ) => {
                return Err("expected a quoted string".to_owned());
            }
            (ValueType::List, DeValue::Array(texts)) => {
                let texts = texts.iter().map(|text| text.get_ref().as_str());
                let texts: Option<Vec<_>> = texts.collect();
                let texts = texts.ok_or("expected quoted strings in brackets")?;
                texts.join(",")
            }
            (ValueType::List, _) => return Err("expected quoted strings in brackets".to_owned()),
            (ValueType::Switch, DeValue::Boolean(on)) => on.to_string(),
            (ValueType::Switch, _) => return Err("expected true or false".to_owned()),
            (_, DeValue::Integer(number)) => number.as_str().replace('_', ""),
            (_, DeValue::Float(number)) => number.as_str().replace('_', ""),
            _ => return Err("expected a number".to_owned()),
        };
        self.write(&text).map(|_| text)
    }

    fn number(&self, text: &str) -> Result<f64, String> {
        let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
        let (good, wanted): (fn(f64) -> bool, _) = match self.kind {
            ValueType::Window => (
                |value| (1.0..=8.0).contains(&value) && value.fract() == 0.0,
                "expected a whole number from 1 to 8",
            ),
            ValueType::Rate => (
                |value| (0.0..=50.0).contains(&value) && value.fract() == 0.0,
                "expected a whole number from 0 to 50",
            ),
            _ => (|_| true, "expected a number"),
        };
        value
            .filter(|value| good(*value))
            .ok_or_else(|| wanted.to_owned())
    }
}

/// Checks a value with the parser of the drawing option of this name.
fn check(option: &str, text: &str) -> Result<(), String> {
    let value = SetupOptions::option(option).map(|row| row.value_of(text));
    let fields = [(option.to_owned(), value.unwrap_or_default())];
    let read = SetupOptions::from_partial_fields(&fields.into_iter().collect());
    read.map(|_| ()).map_err(|error| error.message.into())
}

/// Splits a list as typed by the user.
pub(crate) fn list(text: &str) -> impl Iterator<Item = &str> {
    text.split(',')
        .map(str::trim)
        .filter(|text| !text.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(name: &str, text: &str) -> Result<String, String> {
        Key::named(name).expect("a key").write(text)
    }

    #[test]
    fn defaults_are_those_that_hold() {
        use magician_program::artwork::Marking;
        use magician_program::raster::Engrave;
        let (pen, laser) = (Marking::pen(), Engrave::default());
        for (name, value) in [
            ("draw.speed", f64::from(pen.speed)),
            ("draw.travel_speed", f64::from(pen.travel)),
            ("draw.lift", pen.lift),
            ("engrave.speed", laser.speed),
            ("engrave.power", laser.power[1]),
        ] {
            let key = Key::named(name).expect("a key");
            assert_eq!(key.default.parse(), Ok(value), "{name}");
        }
    }

    #[test]
    fn settings_accept_the_values_of_flags() {
        assert_eq!(write("port", "COM3"), Ok("\"COM3\"".to_owned()));
        assert_eq!(write("tool", "Pen"), Ok("\"pen\"".to_owned()));
        assert_eq!(write("window", "4"), Ok("4".to_owned()));
        assert_eq!(write("surface", "-61.25"), Ok("-61.25".to_owned()));
        assert_eq!(write("draw.travel-speed", "150"), Ok("150".to_owned()));
        assert_eq!(write("engrave.power", "60"), Ok("60".to_owned()));
        assert_eq!(write("engrave.power", "5..60%"), Ok("\"5..60\"".to_owned()));
        assert_eq!(
            write("park", "200,-80, 60"),
            Ok("\"200,-80, 60\"".to_owned())
        );
        assert_eq!(
            write("serve.allow-host", "lab.local, arm:8910"),
            Ok("[\"lab.local\", \"arm:8910\"]".to_owned())
        );
        assert_eq!(
            write("serve.listen", "0.0.0.0:8910"),
            Ok("\"0.0.0.0:8910\"".to_owned())
        );
        assert_eq!(write("serve.student_laser", "true"), Ok("true".to_owned()));
        assert_eq!(write("serve.ring", "0"), Ok("0".to_owned()));
        assert_eq!(
            write("serve.programs", "/srv/programs"),
            Ok("\"/srv/programs\"".to_owned())
        );
        for (name, wrong) in [
            ("serve.listen", "lab.local:8910"),
            ("serve.student_laser", "yes"),
            ("serve.programs", " "),
            ("serve.link", "9090"),
            ("serve.ring", "51"),
            ("serve.ring", "0.5"),
            ("serve.save_on_alarm", "no"),
            ("port", "nowhere"),
            ("tool", "hammer"),
            ("window", "0"),
            ("window", "1.5"),
            ("surface", "nan"),
            ("draw.speed", "0"),
            ("draw.speed", "0.001"),
            ("draw.travel_speed", "99999"),
            ("engrave.power", "0"),
            ("engrave.power", "101"),
            ("engrave.power", "60..5"),
            ("sheet", "1"),
            ("park", "200,80"),
        ] {
            assert!(write(name, wrong).is_err(), "{name} {wrong}");
        }
    }
}
