//! Library of programs in memory, and a reader that can be held back.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Read};
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex};

use magician_job::presets::PresetStore;
use magician_program::Format;
use magician_station::{
    ConversionResult, FormatReader, LibraryError, ProgramEntry, ProgramName, ProgramReading,
    ProgramStore, Reader, ReadingArm, Role, Source, Upload,
};

type Programs = Arc<Mutex<BTreeMap<ProgramName, Vec<u8>>>>;

/// Programs in memory, with limited room.
pub(crate) struct MemoryLibrary {
    pub(crate) programs: Programs,
    /// Largest program that fits, bytes.
    pub(crate) room: Mutex<usize>,
}

impl Default for MemoryLibrary {
    fn default() -> Self {
        Self {
            programs: Programs::default(),
            room: Mutex::new(usize::MAX),
        }
    }
}

impl MemoryLibrary {
    /// Returns the content of a program.
    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        let name = ProgramName::new(name).unwrap();
        self.programs.lock().unwrap()[&name].clone()
    }
}

impl ProgramStore for MemoryLibrary {
    fn folder(&self) -> Option<&Path> {
        Some(Path::new("/shelf"))
    }

    fn list(&self) -> Result<Vec<ProgramEntry>, LibraryError> {
        let programs = self.programs.lock().unwrap();
        let entry = |(name, bytes): (&ProgramName, &Vec<u8>)| ProgramEntry {
            name: name.clone(),
            bytes: bytes.len() as u64,
            modified: 1000.5,
            format: Format::of(name.as_str(), bytes),
        };
        Ok(programs.iter().map(entry).collect())
    }

    fn open(&self, name: &ProgramName) -> Result<(u64, Box<dyn Read + Send>), LibraryError> {
        let programs = self.programs.lock().unwrap();
        let bytes = programs.get(name).ok_or(LibraryError::Unknown)?.clone();
        Ok((bytes.len() as u64, Box::new(Cursor::new(bytes))))
    }

    fn upload(
        &self,
        name: &ProgramName,
        _: Role,
        _: Option<u64>,
    ) -> Result<Box<dyn Upload>, LibraryError> {
        Ok(Box::new(MemoryUpload {
            programs: Arc::clone(&self.programs),
            name: name.clone(),
            bytes: Vec::new(),
            room: *self.room.lock().unwrap(),
        }))
    }

    fn delete(&self, name: &ProgramName) -> Result<(), LibraryError> {
        let mut programs = self.programs.lock().unwrap();
        programs.remove(name).map(drop).ok_or(LibraryError::Unknown)
    }
}

struct MemoryUpload {
    programs: Programs,
    name: ProgramName,
    bytes: Vec<u8>,
    room: usize,
}

impl Upload for MemoryUpload {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LibraryError> {
        self.bytes.extend_from_slice(bytes);
        if self.bytes.len() > self.room {
            return Err(LibraryError::Full);
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<bool, LibraryError> {
        let mut programs = self.programs.lock().unwrap();
        Ok(programs.insert(self.name, self.bytes).is_none())
    }
}

/// Presets in memory.
#[derive(Debug, Default)]
pub(crate) struct MemoryPresets(Mutex<BTreeMap<String, String>>);

impl PresetStore for MemoryPresets {
    fn names(&self) -> Vec<String> {
        self.0.lock().unwrap().keys().cloned().collect()
    }

    fn load(&self, name: &str) -> io::Result<Option<String>> {
        Ok(self.0.lock().unwrap().get(name).cloned())
    }

    fn save(&self, name: &str, text: &str) -> io::Result<()> {
        let mut kept = self.0.lock().unwrap();
        kept.insert(name.to_owned(), text.to_owned());
        Ok(())
    }

    fn remove(&self, name: &str) -> io::Result<bool> {
        Ok(self.0.lock().unwrap().remove(name).is_some())
    }
}

/// State of the readers.
#[derive(Default)]
pub(crate) struct GateState {
    pub(crate) closed: bool,
    pub(crate) now: usize,
    pub(crate) most: usize,
}

/// Gate that holds readers back while it is closed.
#[derive(Clone, Default)]
pub(crate) struct Gate(Arc<(Mutex<GateState>, Condvar)>);

impl Gate {
    pub(crate) fn close(&self, closed: bool) {
        self.0.0.lock().unwrap().closed = closed;
        self.0.1.notify_all();
    }

    /// Returns the number of readers at work.
    pub(crate) fn now(&self) -> usize {
        self.0.0.lock().unwrap().now
    }

    /// Returns the largest number of readers at work at once.
    pub(crate) fn most(&self) -> usize {
        self.0.0.lock().unwrap().most
    }
}

/// Reader behind a gate.
pub(crate) struct Gated(pub(crate) FormatReader, pub(crate) Gate);

impl Reader for Gated {
    fn read(
        &self,
        source: &Source,
        arm: &ReadingArm,
    ) -> Result<ProgramReading, magician_station::api::RpcError> {
        let (reads, changed) = &*self.1.0;
        let mut held = reads.lock().unwrap();
        held.now += 1;
        held.most = held.most.max(held.now);
        let mut held = changed.wait_while(held, |reads| reads.closed).unwrap();
        held.now -= 1;
        drop(held);
        self.0.read(source, arm)
    }

    fn convert(
        &self,
        source: &Source,
        to: &str,
    ) -> Result<ConversionResult, magician_station::api::RpcError> {
        self.0.convert(source, to)
    }
}
