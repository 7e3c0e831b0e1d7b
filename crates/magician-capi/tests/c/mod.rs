//! Checks of a family's header and library with a C compiler and C programs. Cargo has built the
//! library beside the test.

use std::collections::BTreeSet;
use std::env;
use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use magician_capi::structure::STRUCTURES;
use magician_capi::{FUNCTIONS, Family, Function, Ids};

/// Declares the tests of a family.
macro_rules! tests {
    ($family:ident, $number:literal) => {
        const SUBJECT: c::Subject = c::Subject {
            family: magician_capi::Family::$family,
            number: $number,
        };

        #[test]
        fn layouts_match_the_vendors() {
            SUBJECT.layouts_match_the_vendors();
        }

        #[test]
        fn prototypes_match_the_table() {
            SUBJECT.prototypes_match_the_table();
        }

        #[test]
        fn program_completes_a_session() {
            SUBJECT.program_completes_a_session();
        }

        #[test]
        fn program_may_exit_while_connected() {
            SUBJECT.program_may_exit_while_connected();
        }
    };
}
pub(crate) use tests;

/// A family under test.
#[derive(Clone, Copy)]
pub(crate) struct Subject {
    pub(crate) family: Family,
    /// `1`, `2` or `3`.
    pub(crate) number: u8,
}

impl Subject {
    /// Sizes and offsets of all structures match the vendor's files, and sizes match those of this
    /// crate.
    pub(crate) fn layouts_match_the_vendors(self) {
        let mut source = fs::read_to_string(here().join("layout.c")).expect("layout.c");
        let used: BTreeSet<&str> = (self.functions())
            .flat_map(|function| function.arguments)
            .map(|(_, rust)| rust.split(['<', '>']).nth(1).unwrap_or(rust))
            .collect();
        for (name, size) in STRUCTURES.iter().filter(|(name, _)| used.contains(name)) {
            writeln!(source, "SIZE({name}, {size});").unwrap();
        }
        self.compile("layout.c", &source);
    }

    /// The header declares exactly the functions of the table, with their types.
    pub(crate) fn prototypes_match_the_table(self) {
        let mut source = "#include \"DobotDll.h\"\n".to_owned();
        for function in self.functions() {
            let (name, arguments) = (function.name, self.arguments(function));
            writeln!(source, "int (*const a_{name})({arguments}) = {name};").unwrap();
        }
        self.compile("prototypes.c", &source);
        let [(_, header), _] = magician_capi::headers::headers(self.family);
        let declared: BTreeSet<&str> = (header.split("DOBOTDLLSHARED_EXPORT int ").skip(1))
            .filter_map(|rest| Some(rest.split_once('(')?.0))
            .collect();
        let ours: BTreeSet<&str> = self.functions().map(|function| function.name).collect();
        let missing: Vec<_> = ours.difference(&declared).collect();
        let surplus: Vec<_> = declared.difference(&ours).collect();
        assert!(
            missing.is_empty() && surplus.is_empty(),
            "the header lacks {missing:?}; the table lacks {surplus:?}"
        );
    }

    /// A linked program finds all functions and completes a session.
    pub(crate) fn program_completes_a_session(self) {
        let folder = self.folder("session");
        let library = self.install(&folder);
        let mut names = "static const char *const NAMES[] = {\n".to_owned();
        for function in self.functions() {
            writeln!(names, "    \"{}\",", function.name).unwrap();
        }
        fs::write(folder.join("names.h"), names + "};\n").unwrap();
        let said = run(self.program("session.c", &folder).arg(&library));
        assert_eq!(said, "done\n");
    }

    /// A program may exit with its arm connected, and with its log closed.
    pub(crate) fn program_may_exit_while_connected(self) {
        let folder = self.folder("leaving");
        self.install(&folder);
        assert_eq!(run(&mut self.program("leaving.c", &folder)), "left\n");
        if cfg!(target_os = "linux") {
            let full = fs::File::options().write(true).open("/dev/full").unwrap();
            let mut program = self.program("leaving.c", &folder);
            let said = program.stderr(full).output().unwrap();
            assert!(said.status.success(), "{}", said.status);
            assert_eq!(said.stdout, b"left\n");
        }
    }

    /// Builds a program that is linked with the library installed in a folder.
    fn program(self, source: &str, folder: &Path) -> Command {
        let program = folder.join("program");
        run(self
            .compiler(folder)
            .arg(here().join(source))
            .arg("-o")
            .arg(&program)
            .arg(format!("-L{}", folder.display()))
            .args(["-lDobotDll", "-ldl", "-lm"])
            .arg(format!("-Wl,-rpath,{}", folder.display())));
        let mut program = Command::new(program);
        program
            .env_remove("MAGICIAN_PORT")
            .env_remove("MAGICIAN_LOG");
        program
    }

    fn functions(self) -> impl Iterator<Item = &'static Function> {
        FUNCTIONS
            .iter()
            .filter(move |function| function.families.contains(&self.family))
    }

    /// Formats the argument types of a function as C.
    fn arguments(self, function: &Function) -> String {
        let ids = match (self.family, function.ids) {
            (Family::V1, _) | (_, Ids::None) => 0,
            (Family::V2, _) | (Family::V3, Ids::Master) => 1,
            (Family::V3, Ids::Arm) => 2,
        };
        let mut types = vec!["int".to_owned(); ids];
        types.extend(function.arguments.iter().map(|(_, rust)| c_type(rust)));
        if function.name == "SetCircleCmd" {
            // Functions that read only the beginning still take the whole structure in C.
            types = types
                .iter()
                .map(|c| c.replace("ARCCmd", "CircleCmd"))
                .collect();
        }
        if types.is_empty() {
            return "void".to_owned();
        }
        types.join(", ")
    }

    /// Writes the family's headers to the folder. Returns a compiler that finds them.
    fn compiler(self, folder: &Path) -> Command {
        for (name, text) in magician_capi::headers::headers(self.family) {
            fs::write(folder.join(name), text).unwrap();
        }
        let mut command = Command::new(env::var_os("CC").unwrap_or_else(|| "cc".into()));
        command
            .args([
                "-std=c11",
                "-D_DEFAULT_SOURCE",
                "-Wall",
                "-Wextra",
                "-Werror",
            ])
            .arg(format!("-DFAMILY={}", self.number))
            .arg(format!("-I{}", folder.display()));
        command
    }

    /// Compiles a source without linking.
    fn compile(self, name: &str, source: &str) {
        let folder = self.folder(name);
        let file = folder.join(name);
        fs::write(&file, source).unwrap();
        run(self.compiler(&folder).arg("-fsyntax-only").arg(&file));
    }

    /// Creates an empty folder for this test.
    fn folder(self, name: &str) -> PathBuf {
        let folder =
            Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("v{}-{name}", self.number));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).expect("a folder in the target directory");
        folder
    }

    /// Installs the library in a folder under the vendor's names. Returns the path that programs
    /// open.
    fn install(self, folder: &Path) -> PathBuf {
        let test = env::current_exe().expect("the path of this test");
        let (prefix, suffix) = (env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX);
        let built = test.with_file_name(format!("{prefix}dobotdll_v{}{suffix}", self.number));
        let name = folder.join(format!("{prefix}DobotDll{suffix}"));
        fs::copy(&built, &name).unwrap_or_else(|error| panic!("{}: {error}", built.display()));
        if cfg!(target_vendor = "apple") {
            return name;
        }
        let mut soname = OsString::from(&name);
        soname.push(".1");
        fs::rename(&name, &soname).unwrap();
        std::os::unix::fs::symlink("libDobotDll.so.1", &name).unwrap();
        soname.into()
    }
}

fn here() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/c"))
}

/// Converts an argument type of the table to C.
fn c_type(rust: &str) -> String {
    match rust {
        "Bool" => return "bool".to_owned(),
        "c_int" | "i32" => return "int".to_owned(),
        "f32" => return "float".to_owned(),
        "Text" => return "const char *".to_owned(),
        "Buffer" => return "char *".to_owned(),
        "u8" | "u16" | "u32" | "u64" => return format!("uint{}_t", &rust[1..]),
        _ => {}
    }
    let compact: String = rust.chars().filter(|c| !c.is_whitespace()).collect();
    let pointed = ["In<", "Out<"]
        .iter()
        .find_map(|head| compact.strip_prefix(head)?.strip_suffix('>'));
    pointed.map_or_else(|| rust.to_owned(), |of| format!("{} *", c_type(of)))
}

/// Runs a program that must succeed. Returns its output.
fn run(command: &mut Command) -> String {
    let output = (command.output())
        .unwrap_or_else(|error| panic!("{command:?}: {error}; a C compiler is needed, $CC or cc"));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let complained = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "{command:?}: {}\n{said}{complained}",
        output.status
    );
    said
}
