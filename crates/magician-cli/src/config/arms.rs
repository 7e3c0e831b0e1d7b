//! `[arms.NAME]`: what is true of one arm.

use magician::Target;
use magician_program::{Lines, Problem};
use toml::Spanned;
use toml::de::DeValue;

/// The table of all arms.
pub(super) const TABLE: &str = "arms";

/// What is known of one arm.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Arm {
    /// Where it is, as `--port` takes it.
    port: String,
    /// Whether a laser may be mounted on it.
    laser: bool,
}

/// The arms of a file, or where it is wrong.
pub(super) fn read(lines: &Lines<'_>, table: &Spanned<DeValue<'_>>) -> Result<Vec<Arm>, Problem> {
    let wrong = |place, message: String| Problem::new(lines.origin(place), message);
    let DeValue::Table(arms) = table.get_ref() else {
        let message = "write [arms.NAME] and its values below it".to_owned();
        return Err(wrong(table.span(), message));
    };
    let mut known = Vec::new();
    for (name, arm) in arms {
        let full = format!("{TABLE}.{}", name.get_ref());
        let DeValue::Table(values) = arm.get_ref() else {
            return Err(wrong(
                arm.span(),
                format!("write [{full}] and its values below it"),
            ));
        };
        let (mut port, mut laser) = (None, true);
        for (key, value) in values {
            match (key.get_ref().as_ref(), value.get_ref()) {
                ("port", DeValue::String(text)) => {
                    let target = text.parse::<Target>();
                    target.map_err(|error| wrong(value.span(), format!("{full}.port: {error}")))?;
                    port = Some(text.to_string());
                }
                ("port", _) => {
                    return Err(wrong(
                        value.span(),
                        format!("{full}.port: expected a text in quotes"),
                    ));
                }
                ("laser", DeValue::Boolean(mounted)) => laser = *mounted,
                ("laser", _) => {
                    return Err(wrong(
                        value.span(),
                        format!("{full}.laser: expected true or false"),
                    ));
                }
                (other, _) => {
                    let problem =
                        wrong(key.span(), format!("there is no setting `{full}.{other}`"));
                    return Err(problem.help("an arm has port and laser"));
                }
            }
        }
        let Some(port) = port else {
            let message = format!("{full} does not say which arm it is");
            return Err(wrong(name.span(), message).help("port = \"...\" does, as --port takes it"));
        };
        known.push(Arm { port, laser });
    }
    Ok(known)
}

/// Whether a laser may be mounted on the arm at this port: yes, unless the file says that there is none.
pub(super) fn laser_is_mounted(arms: &[Arm], port: Option<&str>) -> bool {
    let same = |arm: &&Arm| {
        let (known, meant) = (arm.port.parse::<Target>(), port.map(str::parse::<Target>));
        matches!((known, meant), (Ok(known), Some(Ok(meant))) if known == meant)
    };
    arms.iter().find(same).is_none_or(|arm| arm.laser)
}

#[cfg(test)]
mod tests {
    use toml::de::DeTable;

    use super::*;

    fn arms(text: &str) -> Result<Vec<Arm>, Problem> {
        let lines = Lines::new(text);
        let file = DeTable::parse(text).expect("it is TOML");
        let (_, table) = (file.get_ref().iter())
            .find(|(name, _)| name.get_ref() == TABLE)
            .expect("arms");
        read(&lines, table)
    }

    #[test]
    fn an_arm_is_known_by_its_port_and_has_a_laser_unless_the_file_says_none() {
        let text =
            "[arms.white]\nport = 'udp:192.168.1.5'\nlaser = false\n[arms.black]\nport = 'COM3'\n";
        let arms = arms(text).expect("it is right");
        let mounted = |port| laser_is_mounted(&arms, port);
        assert!(!mounted(Some("udp:192.168.1.5")) && !mounted(Some("udp:192.168.1.5:8899")));
        assert!(mounted(Some("COM3")) && mounted(Some("COM4")) && mounted(None));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        for (text, line, part) in [
            ("arms = 3", 1, "[arms.NAME]"),
            ("[arms]\nwhite = 3", 2, "[arms.white]"),
            ("[arms.white]\nlaser = false", 1, "which arm"),
            ("[arms.white]\nport = 'nowhere'", 2, "arms.white.port"),
            (
                "[arms.white]\nport = 'COM3'\nlaser = 'no'",
                3,
                "true or false",
            ),
            (
                "[arms.white]\nport = 'COM3'\nlazer = false",
                3,
                "arms.white.lazer",
            ),
        ] {
            let problem = arms(text).expect_err(text);
            assert_eq!(problem.origin.line, line, "{text}");
            assert!(problem.message.contains(part), "{text}: {problem}");
        }
    }
}
