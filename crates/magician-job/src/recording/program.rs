//! Recording as a program that repeats the motion.

use std::path::{Path, PathBuf};

use magician::Event;
use magician_program::formats::playback::Playback;
use magician_program::{CaptureMode, Plan, PoseReading, Recording, Tool};
use magician_record::Reading;

use super::reference_tool::with_tool;
use super::sink::{Format, RecordingStart, Sink};
use super::{RecordError, unwritable};
use crate::files::WholeFile;

/// The file is rewritten completely at each flush, so that a killed program leaves a runnable one.
pub(super) struct Program {
    path: PathBuf,
    /// `None` once the file is complete.
    file: Option<WholeFile>,
    format: Format,
    /// Tool that the program is for.
    tool: Tool,
    tolerance: f64,
    recording: Recording,
    /// True if readings are missing in the file.
    stale: bool,
}

impl Program {
    pub(super) fn open(
        path: &Path,
        format: Format,
        start: &RecordingStart,
    ) -> Result<Self, RecordError> {
        let file = WholeFile::grow(path).map_err(unwritable(path))?;
        let mut program = Self {
            path: path.to_owned(),
            file: Some(file),
            format,
            tool: start.tool,
            tolerance: start.tolerance,
            recording: Recording::new(start.tolerance),
            stale: false,
        };
        // Write an empty program first, so that a file that cannot be written fails now.
        match format {
            Format::Playback => program.write("<root></root>")?,
            _ => program.write(&program.plan().to_json())?,
        }
        Ok(program)
    }

    fn plan(&self) -> Plan {
        let title = self.path.file_name().unwrap_or_default().to_string_lossy();
        let title = title.trim_end_matches(".json").trim_end_matches(".plan");
        let follow = match self.format {
            Format::Playback => CaptureMode::Lines,
            _ => CaptureMode::Path,
        };
        self.recording
            .plan(title.trim_end_matches(".playback"), Some(self.tool), follow)
    }

    /// Writes the program; returns its number of steps.
    fn save(&mut self) -> Result<usize, RecordError> {
        let plan = self.plan();
        let text = match self.format {
            Format::Playback => Playback::from_plan(&plan)
                .map_err(RecordError::Program)?
                .to_xml(),
            _ => plan.to_json(),
        };
        self.write(&text)?;
        Ok(plan.steps.len())
    }

    fn write(&mut self, text: &str) -> Result<(), RecordError> {
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        let written = file.rewrite(text.as_bytes());
        written.map_err(unwritable(&self.path))
    }
}

impl Sink for Program {
    fn write(&mut self, reading: &Reading, tool: Tool) -> Result<(), RecordError> {
        if tool != self.tool && self.recording.length() == 0.0 {
            // No motion has been recorded yet: the changed tool applies to the whole program.
            self.tool = tool;
            self.recording = Recording::new(self.tolerance);
        }
        let pose = with_tool(&reading.pose, tool, self.tool);
        self.recording.push(PoseReading {
            t: reading.t,
            pose: [pose.x, pose.y, pose.z, pose.r].map(f64::from),
            j4: f64::from(pose.joint_angle[3]),
        });
        self.stale = true;
        Ok(())
    }

    fn note(&mut self, _: f64, _: &Event) -> Result<(), RecordError> {
        Ok(())
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        if std::mem::take(&mut self.stale) {
            self.save()?;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<Option<usize>, RecordError> {
        let steps = self.save()?;
        if let Some(file) = self.file.take() {
            file.finish().map_err(unwritable(&self.path))?;
        }
        Ok(Some(steps))
    }
}
