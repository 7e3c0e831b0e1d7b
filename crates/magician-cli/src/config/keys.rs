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
    pub(crate) kind: Kind,
}

/// Type of a setting's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
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
        about: "port of the arm, as for --port",
        variable: Some("MAGICIAN_PORT"),
        default: "the only arm found",
        kind: Kind::Port,
    },
    Key {
        name: "tool",
        about: "the tool on the arm: none, suction, gripper, pen, laser, or X,Y,Z in mm",
        variable: Some("MAGICIAN_TOOL"),
        default: "as the program says",
        kind: Kind::Tool,
    },
    Key {
        name: "window",
        about: "requests in flight at once, 1 to 8",
        variable: Some("MAGICIAN_WINDOW"),
        default: "1",
        kind: Kind::Window,
    },
    Key {
        name: "surface",
        about: "height of the work surface: the z of `magician pose` when the tool touches it, mm",
        variable: None,
        default: "none; -60 for a virtual arm",
        kind: Kind::Surface,
    },
    Key {
        name: "sheet",
        about: "position, rotation and height of the sheet: `magician calibrate` measures them",
        variable: None,
        default: "not calibrated",
        kind: Kind::Sheet,
    },
    Key {
        name: "park",
        about: "where the tip of the tool is parked at the end of a file: X,Y,Z in mm",
        variable: None,
        default: "nowhere",
        kind: Kind::Place,
    },
    Key {
        name: "draw.speed",
        about: "speed of the pen on the paper, mm/s",
        variable: None,
        default: "50",
        kind: Kind::Option("speed"),
    },
    Key {
        name: "draw.travel_speed",
        about: "speed of the pen above the paper, mm/s",
        variable: None,
        default: "200",
        kind: Kind::Option("travel_speed"),
    },
    Key {
        name: "draw.lift",
        about: "how far the pen is lifted, mm",
        variable: None,
        default: "10",
        kind: Kind::Option("lift"),
    },
    Key {
        name: "engrave.speed",
        about: "speed of the laser on drawings, images, and G-code before its first F, mm/s; unless set, images are burnt at the highest even speed, 20 at most",
        variable: None,
        default: "20",
        kind: Kind::Option("speed"),
    },
    Key {
        name: "engrave.power",
        about: "full power of the laser, percent, or LEAST..MOST, as for --power",
        variable: None,
        default: "100",
        kind: Kind::Power,
    },
    Key {
        name: "serve.listen",
        about: "where `magician serve` listens, HOST:PORT, as for --listen",
        variable: None,
        default: "localhost:8910",
        kind: Kind::Address,
    },
    Key {
        name: "serve.allow_host",
        about: "further names of the station, HOST[:PORT],.., as for --allow-host",
        variable: None,
        default: "none",
        kind: Kind::List,
    },
    Key {
        name: "serve.allow_origin",
        about: "sites whose pages may use the station, as for --allow-origin",
        variable: None,
        default: "none",
        kind: Kind::List,
    },
    Key {
        name: "serve.student_laser",
        about: "whether the role student may switch the laser of a real arm on: true or false",
        variable: None,
        default: "false",
        kind: Kind::Switch,
    },
    Key {
        name: "serve.programs",
        about: "folder of the programs that a station keeps, as for --programs",
        variable: None,
        default: "programs, in the user's data of magician",
        kind: Kind::Folder,
    },
    Key {
        name: "serve.link",
        about: "whether programs for DobotLink are answered, as for --link: true or false",
        variable: None,
        default: "false",
        kind: Kind::Switch,
    },
    Key {
        name: "serve.ring",
        about: "readings a second, 0 to 50, that a station keeps of the last ten minutes of a moving arm; 5 while it stands; 0: only what others read",
        variable: None,
        default: "50",
        kind: Kind::Rate,
    },
    Key {
        name: "serve.save_on_alarm",
        about: "whether an alarm has the last ten minutes written into a file: true or false",
        variable: None,
        default: "true",
        kind: Kind::Switch,
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
            Kind::Port => {
                let target = text.parse::<Target>().map_err(|error| error.to_string());
                target.map(|_| quoted(text))
            }
            Kind::Tool => text.parse::<Tool>().map(|tool| quoted(&tool.to_string())),
            Kind::Window | Kind::Rate => self.number(text).map(|value| format!("{value:.0}")),
            Kind::Surface => self.number(text).map(|value| value.to_string()),
            Kind::Option(option) => {
                check(option, text)?;
                self.number(text).map(|value| value.to_string())
            }
            Kind::Power => {
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
            Kind::Place => numbers::<3>(text).map(|_| quoted(text)),
            Kind::Sheet => Err("set it with `magician calibrate`".to_owned()),
            Kind::Address => match Listener::check(text) {
                Ok(()) => Ok(quoted(text)),
                Err(error) => Err(error.to_string()),
            },
            Kind::List => {
                let texts: Vec<_> = list(text).map(toml::Value::from).collect();
                Ok(toml::Value::from(texts).to_string())
            }
            Kind::Folder if text.is_empty() => Err("expected a folder".to_owned()),
            Kind::Folder => Ok(quoted(text)),
            Kind::Switch if ["true", "false"].contains(&text) => Ok(text.to_owned()),
            Kind::Switch => Err("expected true or false".to_owned()),
        }
    }

    /// Converts a value of a file into what a user would type.
    pub(super) fn read(&self, value: &DeValue<'_>) -> Result<String, String> {
        let text = match (self.kind, value) {
            (Kind::Sheet, DeValue::Table(_)) => return Ok("calibrated".to_owned()),
            (Kind::Sheet, _) => return Err("expected a table".to_owned()),
            (Kind::Surface, DeValue::Table(_)) => return Ok("tilted".to_owned()),
            (
                Kind::Port | Kind::Tool | Kind::Place | Kind::Power | Kind::Address | Kind::Folder,
                DeValue::String(text),
            ) => text.to_string(),
            (Kind::Port | Kind::Tool | Kind::Place | Kind::Address | Kind::Folder, _) => {
                return Err("expected a quoted string".to_owned());
            }
            (Kind::List, DeValue::Array(texts)) => {
                let texts = texts.iter().map(|text| text.get_ref().as_str());
                let texts: Option<Vec<_>> = texts.collect();
                let texts = texts.ok_or("expected quoted strings in brackets")?;
                texts.join(",")
            }
            (Kind::List, _) => return Err("expected quoted strings in brackets".to_owned()),
            (Kind::Switch, DeValue::Boolean(on)) => on.to_string(),
            (Kind::Switch, _) => return Err("expected true or false".to_owned()),
            (_, DeValue::Integer(number)) => number.as_str().replace('_', ""),
            (_, DeValue::Float(number)) => number.as_str().replace('_', ""),
            _ => return Err("expected a number".to_owned()),
        };
        self.write(&text).map(|_| text)
    }

    fn number(&self, text: &str) -> Result<f64, String> {
        let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
        let (good, wanted): (fn(f64) -> bool, _) = match self.kind {
            Kind::Window => (
                |value| (1.0..=8.0).contains(&value) && value.fract() == 0.0,
                "expected a whole number from 1 to 8",
            ),
            Kind::Rate => (
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
    fn values_are_what_the_flags_take() {
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
