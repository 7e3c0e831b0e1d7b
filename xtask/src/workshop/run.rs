//! Runs the commands of a piece in a shell, as a user would, in a folder with all input files.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use super::pieces::{Input, Piece};
use super::{marks, pictures};

/// Folders with the inputs of pieces.
const INPUT_FOLDERS: [&str; 3] = [
    "crates/magician-program/samples",
    "crates/magician-formats/fonts",
    "docs/evidence/workshop/files",
];

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Output and pictures of the commands of a piece, and their comparison.
pub(super) struct PieceResult {
    /// Output of the last command.
    pub(super) output: String,
    /// Pictures on the page: heading and file name, relative to the folder of the pictures.
    pub(super) shown: Vec<(&'static str, String)>,
    /// Pictures to write: file name and bytes.
    pub(super) pictures: Vec<(String, Vec<u8>)>,
    /// Deviations between file, preview and result, as text.
    pub(super) figures: String,
    pub(super) is_good: bool,
}

/// Folder in which the commands run, with all input files.
pub(super) struct CommandFolder {
    folder: PathBuf,
    path_variable: String,
}

impl CommandFolder {
    /// Builds `magician` and copies the input files into a new folder.
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
        let folder = built.join("workshop");
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder)?;
        for input_folder in INPUT_FOLDERS {
            for entry in fs::read_dir(root.join(input_folder))? {
                let entry = entry?;
                if entry.file_type()?.is_file() {
                    fs::copy(entry.path(), folder.join(entry.file_name()))?;
                }
            }
        }
        let path_variable = std::env::var("PATH").unwrap_or_default();
        Ok(Self {
            path_variable: format!("{}:{path_variable}", built.display()),
            folder,
        })
    }

    /// Previews the piece, then makes it.
    pub(super) fn make(&self, piece: &Piece) -> Result<PieceResult> {
        let (preview, result) = (piece.preview(), piece.result());
        self.shell(&piece.preview_command())?;
        let output = self.shell(&piece.make_command())?;
        // The comparison needs both pictures as lines, even if the page shows pixels.
        self.shell(&piece.preview_command_as("look.svg"))?;
        self.shell(&piece.make_command_as("left.svg"))?;
        let estimate: Value = serde_json::from_str(&self.shell(&piece.estimate_command())?)?;
        let [preview_svg, result_svg] =
            ["look.svg", "left.svg"].map(|name| fs::read_to_string(self.folder.join(name)));
        let input = match piece.input {
            Input::File(file) | Input::Lines(file, _) | Input::Tones(file, _) => {
                fs::read(self.folder.join(file))?
            }
            Input::Words | Input::None => Vec::new(),
        };
        let matched = marks::compare_piece(piece, &input, &preview_svg?, &result_svg?, &estimate)?;
        let mut shown = Vec::new();
        let mut written = Vec::new();
        if let Some((name, bytes)) = pictures::input(piece, &input)? {
            shown.push(("the file", name.clone()));
            written.extend(bytes.map(|bytes| (name, bytes)));
        }
        shown.push(("preview", preview.clone()));
        written.push((preview.clone(), pictures::reduced(&self.read(&preview)?)?));
        if piece.makes_marks() {
            shown.push(("what the arm left", result.clone()));
            written.push((result.clone(), pictures::reduced(&self.read(&result)?)?));
        }
        Ok(PieceResult {
            output,
            shown,
            pictures: written,
            figures: matched.text,
            is_good: matched.is_good,
        })
    }

    fn read(&self, name: &str) -> Result<Vec<u8>> {
        Ok(fs::read(self.folder.join(name))?)
    }

    /// Runs a line in a shell and returns its output on stdout.
    fn shell(&self, command_line: &str) -> Result<String> {
        let home = self.folder.join(".home");
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
            .args(["-c", command_line])
            .env("PATH", &self.path_variable)
            .env("MAGICIAN_CONFIG", "/dev/null")
            .env("NO_COLOR", "1")
            .current_dir(&self.folder)
            .stdin(Stdio::null())
            .output()?;
        if !output.status.success() {
            let why = String::from_utf8_lossy(&output.stderr).into_owned();
            return Err(format!("{command_line}: {}: {why}", output.status).into());
        }
        Ok(String::from_utf8(output.stdout)?)
    }
}
