//! Runs the commands of a piece as a user would in a shell, in a folder with the files.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use super::pieces::{Input, Piece};
use super::{marks, pictures};

/// Folders with the inputs of pieces.
const FILES: [&str; 3] = [
    "crates/magician-program/samples",
    "crates/magician-formats/fonts",
    "docs/evidence/workshop/files",
];

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Result of a piece.
pub(super) struct PieceResult {
    /// Output of the last command.
    pub(super) output: String,
    /// Pictures on the page: heading and file name, relative to the folder of the pictures.
    pub(super) shown: Vec<(&'static str, String)>,
    /// Pictures that were made.
    pub(super) pictures: Vec<(String, Vec<u8>)>,
    /// Deviations as text.
    pub(super) figures: String,
    pub(super) is_good: bool,
}

/// Folder with all files in which commands run.
pub(super) struct CommandFolder {
    place: PathBuf,
    path: String,
}

impl CommandFolder {
    /// Builds the command and copies the files.
    pub(super) fn new(root: &Path) -> Result<Self> {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let built = Command::new(cargo)
            .args(["build", "--quiet", "--package", "magician-cli"])
            .current_dir(root)
            .status()?;
        if !built.success() {
            return Err("the command does not build".into());
        }
        let here = std::env::current_exe()?;
        let built = here.parent().ok_or("no folder of the command")?;
        let place = built.join("workshop");
        let _ = fs::remove_dir_all(&place);
        fs::create_dir_all(&place)?;
        for folder in FILES {
            for entry in fs::read_dir(root.join(folder))? {
                let entry = entry?;
                if entry.file_type()?.is_file() {
                    fs::copy(entry.path(), place.join(entry.file_name()))?;
                }
            }
        }
        let path = std::env::var("PATH").unwrap_or_default();
        Ok(Self {
            path: format!("{}:{path}", built.display()),
            place,
        })
    }

    /// Previews the piece, then makes it.
    pub(super) fn make(&self, piece: &Piece) -> Result<PieceResult> {
        let (preview, drawn) = (piece.preview(), piece.drawn());
        self.shell(&piece.preview_command())?;
        let output = self.shell(&piece.make_command())?;
        // Also as lines, for the comparison, whatever the page shows.
        self.shell(&piece.preview_command_as("look.svg"))?;
        self.shell(&piece.make_command_as("left.svg"))?;
        let estimate: Value = serde_json::from_str(&self.shell(&piece.estimate_command())?)?;
        let [look, left] =
            ["look.svg", "left.svg"].map(|name| fs::read_to_string(self.place.join(name)));
        let input = match piece.input {
            Input::File(file) | Input::Lines(file, _) | Input::Tones(file, _) => {
                fs::read(self.place.join(file))?
            }
            Input::Words | Input::None => Vec::new(),
        };
        let matched = marks::figures(piece, &input, &look?, &left?, &estimate)?;
        let mut shown = Vec::new();
        let mut made = Vec::new();
        if let Some((name, bytes)) = pictures::input(piece, &input)? {
            shown.push(("the file", name.clone()));
            made.extend(bytes.map(|bytes| (name, bytes)));
        }
        shown.push(("preview", preview.clone()));
        made.push((preview.clone(), pictures::reduced(&self.read(&preview)?)?));
        if piece.leaves() {
            shown.push(("what the arm left", drawn.clone()));
            made.push((drawn.clone(), pictures::reduced(&self.read(&drawn)?)?));
        }
        Ok(PieceResult {
            output,
            shown,
            pictures: made,
            figures: matched.text,
            is_good: matched.is_good,
        })
    }

    fn read(&self, name: &str) -> Result<Vec<u8>> {
        Ok(fs::read(self.place.join(name))?)
    }

    /// Runs a line in a shell and returns its output on stdout.
    fn shell(&self, line: &str) -> Result<String> {
        let home = self.place.join(".home");
        let mut command = Command::new("/bin/sh");
        for variable in ["MAGICIAN_PORT", "MAGICIAN_TOOL", "MAGICIAN_WINDOW"] {
            command.env_remove(variable);
        }
        for variable in [
            "HOME",
            "XDG_CONFIG_HOME",
            "XDG_STATE_HOME",
            "XDG_DATA_HOME",
            "XDG_CACHE_HOME",
        ] {
            command.env(variable, &home);
        }
        let output = command
            .args(["-c", line])
            .env("PATH", &self.path)
            .env("MAGICIAN_CONFIG", "/dev/null")
            .env("NO_COLOR", "1")
            .current_dir(&self.place)
            .stdin(Stdio::null())
            .output()?;
        if !output.status.success() {
            let why = String::from_utf8_lossy(&output.stderr).into_owned();
            return Err(format!("{line}: {}: {why}", output.status).into());
        }
        Ok(String::from_utf8(output.stdout)?)
    }
}
