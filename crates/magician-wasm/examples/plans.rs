//! Writes the samples into a folder, each with the plan that a native station makes of it
//! (`NAME.made`) or its error (`NAME.error`). The script `try` beside this folder compares them
//! with the results of the modules.

use std::path::{Path, PathBuf};
use std::{env, fs};

use magician_program::Format;
use magician_station::{
    ConversionResult, FormatReader, LibraryError, ProgramEntry, ProgramName, ProgramStore, Reader,
    Role, Source, Upload,
};

/// The samples as a library.
struct Samples(PathBuf);

impl ProgramStore for Samples {
    fn folder(&self) -> Option<&Path> {
        None
    }

    fn list(&self) -> Result<Vec<ProgramEntry>, LibraryError> {
        Ok(Vec::new())
    }

    fn open(
        &self,
        name: &ProgramName,
    ) -> Result<(u64, Box<dyn std::io::Read + Send>), LibraryError> {
        let bytes = fs::read(self.0.join(name.as_str())).map_err(|_| LibraryError::Unknown)?;
        Ok((bytes.len() as u64, Box::new(std::io::Cursor::new(bytes))))
    }

    fn upload(
        &self,
        _: &ProgramName,
        _: Role,
        _: Option<u64>,
    ) -> Result<Box<dyn Upload>, LibraryError> {
        Err(LibraryError::Full)
    }

    fn delete(&self, _: &ProgramName) -> Result<(), LibraryError> {
        Err(LibraryError::Unknown)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(env::args_os().nth(1).ok_or("into which folder?")?);
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../magician-program/samples");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder)?;
    for entry in fs::read_dir(samples)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if Format::of(&name, b"").is_some() {
            fs::copy(&path, folder.join(&*name))?;
        }
    }
    // Invalid files must give the same error natively and in the modules.
    fs::write(folder.join("wrong.nc"), "G90\nG1 X10 Y%\n")?;
    fs::write(folder.join("from-there.nc"), "G91\nG1 X5 Y5 F600\nG1 X5\n")?;
    fs::write(folder.join("cut.svg"), "<svg width=\"10\"><path d=\"M0 0")?;
    fs::write(folder.join("no.png"), b"\x89PNG\r\n\x1A\nno more")?;
    let reader = FormatReader::default().with_library(std::sync::Arc::new(Samples(folder.clone())));
    for entry in fs::read_dir(&folder)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        let source: Source = serde_json::from_value(serde_json::json!({ "program": name }))?;
        let (ending, bytes) = match reader.convert(&source, "made.plan.json") {
            Ok(ConversionResult::Done(bytes, _)) => ("made", bytes),
            Ok(_) => return Err("the readers are not built in".into()),
            Err(error) => ("error", error.message.into_bytes()),
        };
        fs::write(folder.join(format!("{name}.{ending}")), bytes)?;
    }
    Ok(())
}
