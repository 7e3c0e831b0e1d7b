//! Selection of systems for a release.

use std::error::Error;

use super::PROFILE;
use super::system::{SYSTEMS, System};

/// Parsed arguments.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Selection {
    pub(super) systems: Vec<System>,
    /// Cargo profile. Profiles other than `dist` serve to test the release process.
    pub(super) profile: String,
}

impl Selection {
    pub(super) fn read(words: &[String]) -> Result<Self, Box<dyn Error>> {
        let (mut only, mut skip) = (Vec::new(), Vec::new());
        let mut profile = PROFILE.to_owned();
        let mut words = words.iter();
        while let Some(option) = words.next() {
            let value = words.next().ok_or("dist: each option needs a value")?;
            let system = || {
                let known = SYSTEMS.map(|system| system.triple).join(", ");
                System::by_triple(value)
                    .ok_or_else(|| format!("dist: unknown target {value}; known: {known}"))
            };
            match option.as_str() {
                "--only" => only.push(system()?),
                "--skip" => skip.push(system()?),
                "--profile" => profile.clone_from(value),
                _ => return Err(format!("dist: unknown option {option}").into()),
            }
        }
        let wanted =
            |system: &System| (only.is_empty() || only.contains(system)) && !skip.contains(system);
        Ok(Self {
            systems: SYSTEMS.into_iter().filter(wanted).collect(),
            profile,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(words: &[&str]) -> Result<Vec<&'static str>, String> {
        let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
        let selection = Selection::read(&words).map_err(|error| error.to_string())?;
        Ok(selection
            .systems
            .iter()
            .map(|system| system.triple)
            .collect())
    }

    #[test]
    fn all_five_systems_are_built_unless_named_or_skipped() {
        let all = read(&[]).expect("nothing to refuse");
        assert_eq!(all.len(), 5);
        assert_eq!(read(&["--only", all[3]]), Ok(vec![all[3]]));
        assert_eq!(read(&["--skip", all[0]]), Ok(all[1..].to_vec()));
        assert!(read(&["--only", "riscv64gc-unknown-linux-gnu"]).is_err());
        assert!(read(&["--only"]).is_err());
    }
}
