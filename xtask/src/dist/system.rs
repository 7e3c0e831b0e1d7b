//! The five systems of a release, and how to link for them on one Linux machine.

use std::error::Error;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{Metadata, output, run};

/// Oldest glibc that the Linux command supports: that of manylinux2014, as for the wheels.
pub(super) const GLIBC: (u32, u32) = (2, 17);

/// System with a release archive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct System {
    pub(crate) triple: &'static str,
    pub(super) family: Family,
    /// Debian's name of its processor; empty if no `.deb` is built.
    pub(super) debian: &'static str,
    /// Compiler whose `libgcc_s` the program links (Linux), or which links the program (Windows).
    compiler: &'static str,
    /// Debian package of that compiler.
    compiler_package: &'static str,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Family {
    Linux,
    Windows,
    /// With the oldest macOS that programs require.
    MacOs(&'static str),
}

/// Systems of `docs/guide/PLATFORMS.md`.
pub(super) const SYSTEMS: [System; 5] = [
    System {
        triple: "x86_64-unknown-linux-gnu",
        family: Family::Linux,
        debian: "amd64",
        compiler: "x86_64-linux-gnu-gcc",
        compiler_package: "gcc-x86-64-linux-gnu",
    },
    System {
        triple: "aarch64-unknown-linux-gnu",
        family: Family::Linux,
        debian: "arm64",
        compiler: "aarch64-linux-gnu-gcc",
        compiler_package: "gcc-aarch64-linux-gnu",
    },
    System {
        triple: "x86_64-pc-windows-gnu",
        family: Family::Windows,
        debian: "",
        compiler: "x86_64-w64-mingw32-gcc",
        compiler_package: "gcc-mingw-w64-x86-64",
    },
    System {
        triple: "aarch64-apple-darwin",
        family: Family::MacOs("11.0"),
        debian: "",
        compiler: "",
        compiler_package: "",
    },
    System {
        triple: "x86_64-apple-darwin",
        family: Family::MacOs("10.12"),
        debian: "",
        compiler: "",
        compiler_package: "",
    },
];

impl System {
    pub(super) fn by_triple(triple: &str) -> Option<Self> {
        SYSTEMS.into_iter().find(|system| system.triple == triple)
    }

    /// Returns the file name of the command.
    pub(super) fn program(&self) -> &'static str {
        match self.family {
            Family::Windows => "magician.exe",
            _ => "magician",
        }
    }

    /// Returns the name of the archive without its extension, which is also that of the folder
    /// inside.
    pub(super) fn archive(&self, version: &str) -> String {
        format!("magician-{version}-{}", self.triple)
    }

    /// Returns the archive's extension. Windows unpacks zip without other tools, and winget accepts
    /// nothing else.
    pub(super) fn ending(&self) -> &'static str {
        match self.family {
            Family::Windows => "zip",
            _ => "tar.gz",
        }
    }
}

/// Releases include sites. This adds 5.7 MB to the archive, but there is only one program to
/// choose.
pub(super) const RELEASE_PACKAGE: (&str, &str) = ("magician-cli", "magician-cli/site");

/// Builds packages of this workspace, for this machine or for a [`System`].
pub(crate) struct Builder {
    pub(crate) root: PathBuf,
    pub(crate) metadata: Metadata,
    /// Cargo profile.
    pub(crate) profile: String,
}

impl Builder {
    pub(crate) fn new(root: &Path, profile: &str) -> Result<Self, Box<dyn Error>> {
        Ok(Self {
            root: root.to_owned(),
            metadata: Metadata::read(&super::cargo(), root)?,
            profile: profile.to_owned(),
        })
    }

    /// Builds packages with cargo alone, for a target or this machine. Returns the output folder.
    pub(crate) fn plain(
        &self,
        target: Option<&str>,
        packages: &[&str],
    ) -> Result<PathBuf, Box<dyn Error>> {
        let mut build = Command::new(super::cargo());
        self.run_build(build.arg("build"), target, target, packages)
    }

    /// Builds packages for a system of a release. Returns the output folder.
    pub(crate) fn release(
        &self,
        system: &System,
        packages: &[&str],
    ) -> Result<PathBuf, Box<dyn Error>> {
        // `CARGO_ENCODED_RUSTFLAGS` separates its arguments by the byte 0x1f, so that they may
        // contain spaces.
        let mut flags = self.path_remapping_flags()?;
        let mut build = match system.family {
            Family::Windows => {
                let mut cargo = Command::new(super::cargo());
                cargo.arg("build");
                cargo
            }
            Family::Linux | Family::MacOs(_) => self.zigbuild()?,
        };
        let mut target = system.triple.to_owned();
        match system.family {
            Family::Windows => {}
            Family::Linux => {
                target += &format!(".{}.{}", GLIBC.0, GLIBC.1);
                flags += &format!("\x1f-Clink-arg={}", self.unwinder(system)?);
                // This `libgcc_s` needs a newer glibc than the program, and the program will be
                // loaded with another.
                flags += "\x1f-Clink-arg=-Wl,--allow-shlib-undefined";
            }
            Family::MacOs(oldest) => drop(build.env("MACOSX_DEPLOYMENT_TARGET", oldest)),
        }
        build.env("CARGO_ENCODED_RUSTFLAGS", flags);
        self.run_build(&mut build, Some(&target), Some(system.triple), packages)
    }

    fn run_build(
        &self,
        build: &mut Command,
        target: Option<&str>,
        folder: Option<&str>,
        packages: &[&str],
    ) -> Result<PathBuf, Box<dyn Error>> {
        build.current_dir(&self.root);
        build.args(["--locked", "--profile", &self.profile]);
        build.args(packages.iter().flat_map(|name| ["--package", name]));
        let (shipped, features) = RELEASE_PACKAGE;
        if packages.contains(&shipped) {
            build.args(["--features", features]);
        }
        build.args(target.iter().flat_map(|target| ["--target", target]));
        run(build)?;
        let mut built = self.metadata.target_directory.clone();
        built.extend(folder);
        // The output folder of Cargo's profile `dev` is still called `debug`.
        built.push(match self.profile.as_str() {
            "dev" => "debug",
            profile => profile,
        });
        Ok(built)
    }

    /// Returns flags that remove this machine's paths from the messages of panics.
    fn path_remapping_flags(&self) -> Result<String, Box<dyn Error>> {
        let places = self.source_folders()?;
        let hidden = places.into_iter().zip(["magician", "cargo", "rust"]);
        let hidden =
            hidden.map(|(place, name)| format!("--remap-path-prefix={}={name}", place.display()));
        Ok(hidden.collect::<Vec<_>>().join("\x1f"))
    }

    /// Returns the folders of our sources, of other crates' sources, and of the compiler.
    pub(super) fn source_folders(&self) -> Result<[PathBuf; 3], Box<dyn Error>> {
        let printed = output(Command::new("rustc").args(["--print", "sysroot"]))?;
        let home = || std::env::home_dir().unwrap_or_default().join(".cargo");
        let cargo = std::env::var_os("CARGO_HOME").map_or_else(home, PathBuf::from);
        let rust = PathBuf::from(String::from_utf8(printed)?.trim());
        Ok([self.root.canonicalize()?, cargo, rust])
    }

    /// Returns the path of the system's unwinder, as gcc links it. zig links its own, but if the C
    /// library unwinds a thread inside one of our calls, both must use the same. `packaging/wheels`
    /// says more.
    fn unwinder(&self, system: &System) -> Result<String, Box<dyn Error>> {
        let mut asked = Command::new(system.compiler);
        let printed = output(asked.arg("-print-file-name=libgcc_s.so.1"))?;
        let library = String::from_utf8(printed)?.trim().to_owned();
        if Path::new(&library).is_absolute() {
            Ok(library)
        } else {
            Err(format!("{} has no libgcc_s.so.1", system.compiler).into())
        }
    }

    /// Returns cargo-zigbuild from the Python packages of `packaging/dist.txt`, which are installed
    /// once.
    fn zigbuild(&self) -> Result<Command, Box<dyn Error>> {
        let pins = std::fs::read_to_string(self.root.join("packaging/dist.txt"))?;
        let home = self.metadata.target_directory.join("dist-tools");
        let stamp = home.join("made-of");
        if std::fs::read_to_string(&stamp).ok().as_ref() != Some(&pins) {
            let _ = std::fs::remove_dir_all(&home);
            run(Command::new("python3").args(["-m", "venv"]).arg(&home))?;
            let mut pip = Command::new(home.join("bin/python"));
            pip.args(["-m", "pip", "install", "--quiet", "--no-deps"]);
            pip.args(["--disable-pip-version-check", "--retries", "5", "-r"]);
            run(pip.arg(self.root.join("packaging/dist.txt")))?;
            std::fs::write(stamp, pins)?;
        }
        let mut path = OsString::from(home.join("bin"));
        path.push(":");
        path.push(std::env::var_os("PATH").unwrap_or_default());
        let mut build = Command::new(home.join("bin/cargo-zigbuild"));
        build.arg("zigbuild").env("PATH", path);
        Ok(build)
    }

    /// Returns what this machine lacks to build for a system, as a sentence; `None` if nothing.
    pub(super) fn missing_requirement(&self, system: &System) -> Option<String> {
        if !cfg!(target_os = "linux") {
            return Some("releases are made on Linux".to_owned());
        }
        let needed = [
            (system.compiler, system.compiler_package),
            ("python3", "python3-venv"),
        ];
        for (program, package) in needed {
            if !program.is_empty() && !is_on_path(program) {
                return Some(format!("no {program}: install {package}"));
            }
        }
        let mut add = Command::new("rustup");
        let added = output(add.args(["target", "add", system.triple]));
        added
            .err()
            .map(|error| format!("no standard library: {error}"))
    }
}

/// True if a program is on the search path.
pub(super) fn is_on_path(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
}
