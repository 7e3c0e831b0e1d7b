//! Settings of single arms: the tables `[arms.NAME]` of the settings file.
//!
//! All front ends read them here: the `magician` command, the Python package and the vendor's C
//! library. An arm is identified by its port.
//!
//! ```toml
//! [arms.white]
//! port = "/dev/ttyUSB0"
//! laser = false                 # no laser is mounted: EIO 2 and 4 may drive something else
//! lowest_j2 = -9.0              # deg: lower limit of J2; never measure it by driving there
//!
//! [arms.white.fence]            # mm, in the arm's coordinates, for the tip of the tool
//! floor = -60.0
//! box = [[150, -200, -60], [310, 200, 150]]
//! keep_out = [[[150, 80, -60], [250, 150, 40]]]
//! top_speed = 100.0             # mm/s
//! strongest_laser = 60.0        # percent
//! ```

use std::ffi::OsString;
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use magician_motion::{Cuboid, Fence, FenceError};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::{Error, ErrorCode, Options, Result, Target};

/// Name of the table of all arms.
pub const TABLE: &str = "arms";
/// Allowed range of an arm's lower limit of J2, deg. It includes the lowest angle that a public
/// program requests (-13.1) and the limit that the vendor guarantees (0).
const LOWEST_J2: (f64, f64) = (-20.0, 0.0);
/// Largest accepted settings file, bytes. Choice, against a wrong path such as a device.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// Settings of one arm.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct KnownArm {
    /// Name of the arm.
    pub name: String,
    /// Address of the arm.
    pub port: Target,
    /// True if a laser may be mounted on it.
    pub laser: bool,
    /// Lower limit of J2, deg. If `None`, the limit of the model applies, and angles below the
    /// limit that every arm reaches give a warning.
    pub lowest_j2: Option<f64>,
    /// Fence of the arm, if any.
    pub fence: Option<Fence>,
}

/// Error in a settings file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Flaw {
    /// Location in the text, in bytes.
    pub place: Range<usize>,
    /// Description.
    pub message: String,
    /// Remedy, if any.
    pub help: Option<String>,
}

impl Flaw {
    fn new(place: Range<usize>, message: impl Into<String>) -> Self {
        Self {
            place,
            message: message.into(),
            help: None,
        }
    }

    fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        match &self.help {
            Some(help) => write!(f, "; {help}"),
            None => Ok(()),
        }
    }
}

/// Returns the path of the settings file: `MAGICIAN_CONFIG`, or `magician/config.toml` in the
/// system's directory for settings. `None` if neither is known.
#[must_use]
pub fn file() -> Option<PathBuf> {
    file_by(|name| std::env::var_os(name))
}

/// Returns the path for a given environment.
#[must_use]
pub fn file_by(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    let set = |name| variable(name).filter(|value| !value.is_empty());
    if let Some(path) = set("MAGICIAN_CONFIG") {
        return Some(path.into());
    }
    let config = set("XDG_CONFIG_HOME").map(PathBuf::from);
    // The XDG specification says that relative paths are to be ignored.
    let config = config.filter(|path| path.is_absolute());
    let local = || match (cfg!(windows), cfg!(target_os = "macos")) {
        (true, _) => set("APPDATA").map(PathBuf::from),
        (_, true) => {
            set("HOME").map(|home| PathBuf::from(home).join("Library/Application Support"))
        }
        _ => set("HOME").map(|home| PathBuf::from(home).join(".config")),
    };
    Some(config.or_else(local)?.join("magician").join("config.toml"))
}

/// Reads the arms from the user's settings file. A missing file counts as a file without arms.
///
/// # Errors
/// [`InvalidInput`](crate::ErrorKind::InvalidInput) with file, line and column if the file cannot
/// be read. The fences are unknown after this error, so the caller must not move an arm.
pub fn load() -> Result<Vec<KnownArm>> {
    match file() {
        Some(path) => load_from(&path),
        None => Ok(Vec::new()),
    }
}

/// Reads the arms from this file, as [`load`] does.
///
/// # Errors
/// Same as [`load`].
pub fn load_from(path: &Path) -> Result<Vec<KnownArm>> {
    let unreadable = |why: &dyn fmt::Display| {
        Error::new(
            ErrorCode::InvalidSettings,
            format!("{} cannot be read: {why}", path.display()),
        )
    };
    match std::fs::metadata(path) {
        // Most users have no settings file.
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Ok(about) if about.len() > MAX_FILE_BYTES => {
            return Err(unreadable(&"it is too large for a settings file"));
        }
        // Other errors appear again when the file is read, with the same text.
        _ => {}
    }
    let text = std::fs::read_to_string(path).map_err(|error| unreadable(&error))?;
    read_text(&text).map_err(|flaw| {
        // Editors count lines and columns from 1, in characters.
        let before = text.get(..flaw.place.start).unwrap_or(&text);
        let line = before.matches('\n').count() + 1;
        let column = before
            .rsplit('\n')
            .next()
            .unwrap_or_default()
            .chars()
            .count()
            + 1;
        Error::new(
            ErrorCode::InvalidSettings,
            format!("{}:{line}:{column}: {flaw}", path.display()),
        )
    })
}

/// Reads the arms from a text.
///
/// # Errors
/// The first error in the text, with its location.
pub fn read_text(text: &str) -> std::result::Result<Vec<KnownArm>, Flaw> {
    let file = DeTable::parse(text)
        .map_err(|error| Flaw::new(error.span().unwrap_or_default(), error.message().trim()))?;
    let table = file.get_ref().iter();
    let table = table.into_iter().find(|(name, _)| name.get_ref() == TABLE);
    table.map_or(Ok(Vec::new()), |(_, table)| read(table))
}

/// Reads the arms of the table `arms`.
///
/// # Errors
/// The first error in the table, with its location.
pub fn read(table: &Spanned<DeValue<'_>>) -> std::result::Result<Vec<KnownArm>, Flaw> {
    let DeValue::Table(arms) = table.get_ref() else {
        return Err(Flaw::new(
            table.span(),
            "write [arms.NAME] and its values below it",
        ));
    };
    arms.iter().map(|(name, arm)| read_arm(name, arm)).collect()
}

fn read_arm(
    name: &Spanned<std::borrow::Cow<'_, str>>,
    arm: &Spanned<DeValue<'_>>,
) -> std::result::Result<KnownArm, Flaw> {
    let full = format!("{TABLE}.{}", name.get_ref());
    let DeValue::Table(values) = arm.get_ref() else {
        return Err(Flaw::new(
            arm.span(),
            format!("write [{full}] and its values below it"),
        ));
    };
    // A laser is assumed unless denied: that errs on the safe side.
    let (mut port, mut laser, mut lowest_j2, mut fence) = (None, true, None, None);
    for (key, value) in values {
        let wrong =
            |what: &str| Flaw::new(value.span(), format!("{full}.{}: {what}", key.get_ref()));
        match (key.get_ref().as_ref(), value.get_ref()) {
            ("port", DeValue::String(text)) => {
                let target = text.parse::<Target>();
                port = Some(target.map_err(|error| wrong(&error.to_string()))?);
            }
            ("port", _) => return Err(wrong("expected a quoted string")),
            ("laser", DeValue::Boolean(mounted)) => laser = *mounted,
            ("laser", _) => return Err(wrong("expected true or false")),
            ("lowest_j2", value) => {
                let range = LOWEST_J2.0..=LOWEST_J2.1;
                let angle = number(value).filter(|angle| range.contains(angle));
                lowest_j2 = Some(angle.ok_or_else(|| wrong("expected degrees from -20 to 0"))?);
            }
            ("fence", _) => fence = Some(fence_of(&format!("{full}.fence"), value)?),
            // Unknown keys are errors: a misspelt fence must not be ignored.
            (other, _) => {
                let flaw = Flaw::new(key.span(), format!("unknown setting '{full}.{other}'"));
                return Err(flaw.help("an arm has port, laser, lowest_j2 and fence"));
            }
        }
    }
    let Some(port) = port else {
        let flaw = Flaw::new(name.span(), format!("{full} has no port"));
        return Err(flaw.help("set port = \"...\""));
    };
    Ok(KnownArm {
        name: name.get_ref().to_string(),
        port,
        laser,
        lowest_j2,
        // An empty fence would still cost reads before each motion.
        fence: fence.filter(|fence| !fence.is_empty()),
    })
}

fn fence_of(full: &str, table: &Spanned<DeValue<'_>>) -> std::result::Result<Fence, Flaw> {
    let DeValue::Table(values) = table.get_ref() else {
        return Err(Flaw::new(
            table.span(),
            format!("write [{full}] and its values below it"),
        ));
    };
    let mut fence = Fence::default();
    for (key, value) in values {
        let wrong = |why: String| Flaw::new(value.span(), format!("{full}.{why}"));
        let name = key.get_ref().as_ref();
        let expected = |what: &str| wrong(format!("{name}: expected {what}"));
        let flawed = |error: FenceError| wrong(error.to_string());
        let a_number = || number(value.get_ref()).ok_or_else(|| expected("a number"));
        let corners = "two corners, [[x, y, z], [x, y, z]]";
        fence = match name {
            "floor" => fence.with_floor(a_number()?).map_err(flawed)?,
            "top_speed" => fence.with_top_speed(a_number()?).map_err(flawed)?,
            "strongest_laser" => fence.with_strongest_laser(a_number()?).map_err(flawed)?,
            "box" => {
                let within = cuboid(value.get_ref()).ok_or_else(|| expected(corners))?;
                fence.with_box(within).map_err(flawed)?
            }
            "keep_out" => {
                let DeValue::Array(boxes) = value.get_ref() else {
                    return Err(expected("a list of boxes, each of two corners"));
                };
                for each in boxes {
                    let wrong = |why: String| Flaw::new(each.span(), format!("{full}.{why}"));
                    let keep_out = cuboid(each.get_ref());
                    let keep_out =
                        keep_out.ok_or_else(|| wrong(format!("keep_out: expected {corners}")))?;
                    let more = fence.with_keep_out(keep_out);
                    fence = more.map_err(|error| wrong(error.to_string()))?;
                }
                fence
            }
            other => {
                let flaw = Flaw::new(key.span(), format!("unknown setting '{full}.{other}'"));
                return Err(
                    flaw.help("a fence has floor, box, keep_out, top_speed and strongest_laser")
                );
            }
        };
    }
    Ok(fence)
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        // Converted through `i64`, since TOML numbers may be hexadecimal or octal.
        DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix())
            .ok()
            .map(|number| number as f64),
        DeValue::Float(number) => number.as_str().parse().ok(),
        _ => None,
    }
}

fn point(value: &DeValue<'_>) -> Option<[f64; 3]> {
    let DeValue::Array(numbers) = value else {
        return None;
    };
    let numbers: Option<Vec<f64>> = numbers.iter().map(|each| number(each.get_ref())).collect();
    numbers?.try_into().ok()
}

fn cuboid(value: &DeValue<'_>) -> Option<Cuboid> {
    let DeValue::Array(corners) = value else {
        return None;
    };
    let mut corners = corners.iter().map(|corner| point(corner.get_ref()));
    match (corners.next(), corners.next(), corners.next()) {
        (Some(Some(min)), Some(Some(max)), None) => Some(Cuboid { min, max }),
        _ => None,
    }
}

/// Parses a fence written as an inline table, `{ floor = -60.0 }`. `None` if it has no bounds.
///
/// ```
/// let fence = magician::arms::fence("{ floor = -60.0, top_speed = 100 }")?.unwrap();
/// assert_eq!(fence.to_string(), "floor z -60.0 mm, at most 100.0 mm/s");
/// assert!(magician::arms::fence("{ roof = 3 }").is_err());
/// # Ok::<(), magician::Error>(())
/// ```
///
/// # Errors
/// [`InvalidInput`](crate::ErrorKind::InvalidInput) if the text is not a fence.
pub fn fence(text: &str) -> Result<Option<Fence>> {
    // The parser reads whole documents, so the inline table becomes the value of a key.
    let text = format!("fence = {text}");
    let file = DeTable::parse(&text);
    let file = file.map_err(|error| {
        Error::new(
            ErrorCode::InvalidSettings,
            format!("fence: {}", error.message().trim()),
        )
    })?;
    let mut values = file.get_ref().iter();
    let fence = match (values.next(), values.next()) {
        (Some((_, table)), None) => fence_of("fence", table),
        _ => Err(Flaw::new(0..0, "fence: expected one table")),
    };
    let fence = fence.map_err(|flaw| Error::new(ErrorCode::InvalidSettings, flaw.to_string()))?;
    Ok(Some(fence).filter(|fence| !fence.is_empty()))
}

/// Returns the arm at this port, if known.
#[must_use]
pub fn at<'a>(arms: &'a [KnownArm], port: &Target) -> Option<&'a KnownArm> {
    arms.iter().find(|arm| arm.port == *port)
}

impl Options {
    /// Applies the settings of an arm: its [`laser_pins`](Self::laser_pins), its
    /// [`fence`](Self::fence), and its lowest J2 in the [`model`](Self::model).
    #[must_use]
    pub fn for_arm(self, known: Option<&KnownArm>) -> Self {
        let Some(known) = known else {
            return self;
        };
        let model = match known.lowest_j2 {
            Some(degrees) => self.model.with_lowest_j2(degrees),
            None => self.model,
        };
        (self.laser_pins(known.laser))
            .fence(known.fence)
            .model(model)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "\
[arms.white]
port = 'udp:192.168.1.5'
laser = false

[arms.white.fence]
floor = -60
box = [[150, -200, -60.0], [310, 200, 150]]
keep_out = [[[150, 80, -60], [250, 150, 40]], [[0, 0, 0], [1, 1, 1]]]
top_speed = 100.0
strongest_laser = 60

[arms.black]
port = 'COM3'
lowest_j2 = -9
";

    #[test]
    fn arm_is_found_by_its_port() {
        let arms = read_text(FILE).expect("it is right");
        let known = |port: &str| at(&arms, &port.parse().expect("a port"));
        let white = known("udp:192.168.1.5:8899").expect("the white one");
        let fence = white.fence.expect("it has one");
        assert!(!white.laser && fence.floor() == Some(-60.0));
        assert_eq!(
            fence.within().map(|within| within.max),
            Some([310.0, 200.0, 150.0])
        );
        assert_eq!(fence.keep_outs().len(), 2);
        assert_eq!(
            (fence.top_speed(), fence.strongest_laser()),
            (Some(100.0), Some(60.0))
        );
        let black = known("COM3").expect("the black one");
        assert!(black.laser && black.fence.is_none());
        assert!(known("COM4").is_none());
        let options = Options::default().for_arm(Some(white));
        assert!(options.fence == Some(fence) && !options.laser_pins);
        assert_eq!(options.model, magician_motion::ArmModel::MAGICIAN);
        let model = Options::default().for_arm(Some(black)).model;
        assert_eq!((model.limits.j2.min, model.certain.j2.min), (-9.0, -9.0));
    }

    #[test]
    fn error_names_its_line_and_setting() {
        let fence = |line: &str| format!("[arms.white]\nport = 'COM3'\n[arms.white.fence]\n{line}");
        for (text, line, part) in [
            ("arms = 3".to_owned(), 1, "[arms.NAME]"),
            ("[arms]\nwhite = 3".to_owned(), 2, "[arms.white]"),
            ("[arms.white]\nlaser = false".to_owned(), 1, "has no port"),
            (
                "[arms.white]\nport = 'nowhere'".to_owned(),
                2,
                "arms.white.port",
            ),
            (
                "[arms.white]\nport = 'COM3'\nlaser = 'no'".to_owned(),
                3,
                "true or false",
            ),
            (
                "[arms.white]\nport = 'COM3'\nlowest_j2 = -45".to_owned(),
                3,
                "degrees from -20 to 0",
            ),
            (
                "[arms.white]\nport = 'COM3'\nlazer = false".to_owned(),
                3,
                "arms.white.lazer",
            ),
            (
                "[arms.white]\nport = 'COM3'\nfence = 3".to_owned(),
                3,
                "[arms.white.fence]",
            ),
            (fence("floor = nan"), 4, "floor: expected finite numbers"),
            (fence("floor = 'low'"), 4, "floor: expected a number"),
            (fence("\nroof = 3"), 5, "arms.white.fence.roof"),
            (fence("box = [[0, 0, 0], [10, 10, -10]]"), 4, "is not on z"),
            (fence("box = [[0, 0], [10, 10]]"), 4, "two corners"),
            (
                fence("keep_out = [\n[[0, 0, 0], [10, 10, 10]],\n[[0, 0, 0], [-1, 10, 10]]]"),
                6,
                "is not on x",
            ),
            (fence("top_speed = 0"), 4, "above 0"),
            (fence("strongest_laser = 120"), 4, "0 to 100"),
        ] {
            let flaw = read_text(&text).expect_err(&text);
            let found = text[..flaw.place.start].matches('\n').count() + 1;
            assert_eq!(found, line, "{text}");
            assert!(flaw.to_string().contains(part), "{text}: {flaw}");
        }
    }

    #[test]
    #[cfg(unix)]
    fn settings_path_is_the_named_or_the_default_one() {
        let with = |name: &'static str, value: &'static str| {
            file_by(move |asked| (asked == name).then(|| value.into()))
        };
        assert_eq!(
            with("XDG_CONFIG_HOME", "/config"),
            Some("/config/magician/config.toml".into())
        );
        assert_eq!(with("MAGICIAN_CONFIG", "my.toml"), Some("my.toml".into()));
        assert_eq!(with("MAGICIAN_CONFIG", ""), None);
    }

    #[test]
    fn error_of_a_file_has_line_and_column() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("config.toml");
        assert_eq!(load_from(&path).expect("nothing there"), []);
        std::fs::write(
            &path,
            "port = 'COM3'\n[arms.white]\nport = 'COM3'\nlazer = 1\n",
        )
        .expect("a disk");
        let error = load_from(&path).unwrap_err().to_string();
        assert!(
            error.contains("config.toml:4:1: unknown setting"),
            "{error}"
        );
    }
}
