//! Unsupported file formats of other programs, each with advice on how to convert it.

use super::content;
use crate::Diagnostic;
use magician_host::{Message, message};

/// Unsupported file format that users are likely to try.
struct ForeignFormat {
    /// File name extensions.
    endings: &'static [&'static str],
    /// Name with its article, as used in a sentence.
    what: fn() -> Message,
    /// Advice on converting it to a supported format.
    help: fn() -> Message,
}

const SAVE_AS_SVG: fn() -> Message = || {
    message!("open it in Inkscape and save it as SVG, or export SVG from the program that made it")
};
const SAVE_AS_DXF: fn() -> Message = || message!("save it as DXF in the program that made it");
const SAVE_AS_JPEG: fn() -> Message = || message!("save it as JPEG or PNG, and draw or burn that");
const MODEL_KIND: fn() -> Message = || message!("a model of three dimensions");
const EXPORT_MODEL: fn() -> Message = || {
    message!(
        "export a drawing or a section of it as DXF or SVG, or G-code from a slicer or CAM program"
    )
};

const PDF: ForeignFormat = ForeignFormat {
    endings: &[".pdf"],
    what: || message!("a PDF document"),
    help: SAVE_AS_SVG,
};
const POSTSCRIPT: ForeignFormat = ForeignFormat {
    endings: &[".eps", ".ps"],
    what: || message!("a PostScript drawing"),
    help: SAVE_AS_SVG,
};
const DWG: ForeignFormat = ForeignFormat {
    endings: &[".dwg"],
    what: || message!("a DWG drawing of AutoCAD"),
    help: SAVE_AS_DXF,
};
const HEIC: ForeignFormat = ForeignFormat {
    endings: &[".heic", ".heif"],
    what: || message!("a HEIC photo"),
    help: SAVE_AS_JPEG,
};
const AVIF: ForeignFormat = ForeignFormat {
    endings: &[".avif"],
    what: || message!("an AVIF image"),
    help: SAVE_AS_JPEG,
};
const LIGHTBURN: ForeignFormat = ForeignFormat {
    endings: &[".lbrn", ".lbrn2"],
    what: || message!("a project of LightBurn"),
    help: || {
        message!("save G-code in LightBurn, for a GRBL laser, and burn that; or export SVG or DXF")
    },
};
const STL: ForeignFormat = ForeignFormat {
    endings: &[".stl"],
    what: MODEL_KIND,
    help: EXPORT_MODEL,
};
const SCRIPT: ForeignFormat = ForeignFormat {
    endings: &[".script", ".py"],
    what: || message!("a program in Python, as the script editor of DobotStudio saves it"),
    help: || {
        message!(
            "run it with Python: the vendor's library and the Python package of this program both run it"
        )
    },
};
/// All kinds. Where the first bytes of a file identify a kind, they take precedence over its
/// extension.
const FOREIGN_FORMATS: [&ForeignFormat; 12] = [
    &PDF,
    &POSTSCRIPT,
    &DWG,
    &HEIC,
    &AVIF,
    &LIGHTBURN,
    &STL,
    &SCRIPT,
    &ForeignFormat {
        endings: &[".ai", ".cdr"],
        what: || message!("a drawing of Illustrator or CorelDRAW"),
        help: SAVE_AS_SVG,
    },
    &ForeignFormat {
        endings: &[
            ".3mf", ".obj", ".step", ".stp", ".iges", ".igs", ".f3d", ".blend",
        ],
        what: MODEL_KIND,
        help: EXPORT_MODEL,
    },
    &ForeignFormat {
        endings: &[".psd", ".xcf", ".kra", ".jxl", ".jp2", ".ico"],
        what: || message!("an image that is not read"),
        help: SAVE_AS_JPEG,
    },
    &ForeignFormat {
        endings: &[".docx", ".doc", ".odt", ".rtf"],
        what: || message!("a document of a word processor"),
        help: || {
            message!(
                "save its text as a text file, and write that; or export a PDF and save that as SVG"
            )
        },
    },
];

/// Identifies a kind by the first bytes of a file, if they are unambiguous.
fn by_content(bytes: &[u8]) -> Option<&'static ForeignFormat> {
    let brand = bytes.get(8..12).unwrap_or_default();
    let is_media = bytes.get(4..8) == Some(b"ftyp");
    let digits = |range| {
        let digits: &[u8] = bytes
            .get::<std::ops::Range<usize>>(range)
            .unwrap_or_default();
        !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
    };
    if bytes.starts_with(b"%PDF-") {
        Some(&PDF)
    } else if bytes.starts_with(b"%!PS") || bytes.starts_with(b"\xC5\xD0\xD3\xC6") {
        Some(&POSTSCRIPT)
    } else if bytes.starts_with(b"AC10") && digits(4..6) {
        Some(&DWG)
    } else if is_media && [b"avif", b"avis"].iter().any(|known| brand == *known) {
        Some(&AVIF)
    } else if is_media
        && [b"heic", b"heix", b"hevc", b"mif1", b"msf1"]
            .iter()
            .any(|known| brand == *known)
    {
        Some(&HEIC)
    } else if content::begins_with_element(bytes, "LightBurnProject") {
        Some(&LIGHTBURN)
    } else {
        None
    }
}

impl ForeignFormat {
    fn diagnostic(&self) -> Diagnostic {
        Diagnostic::of_file(message!(
            "this is {what}, which is not read",
            what = (self.what)()
        ))
        .help((self.help)())
    }
}

/// Refuses bytes that are certainly of an unsupported kind, whatever format the caller named.
pub(super) fn check(bytes: &[u8]) -> Result<(), Diagnostic> {
    by_content(bytes).map_or(Ok(()), |kind| Err(kind.diagnostic()))
}

/// Identifies a file that is in none of the supported [formats](super::Format) by its first bytes,
/// else by its name, and returns advice on how to convert it. `None` if neither is known.
///
/// ```
/// let found = magician_formats::foreign("plan.pdf", b"%PDF-1.4").unwrap();
/// assert_eq!(found.message, "this is a PDF document, which is not read");
/// assert!(found.help.unwrap().contains("SVG"));
/// assert_eq!(magician_formats::foreign("a.xyzzy", b""), None);
/// ```
#[must_use]
pub fn foreign(name: &str, bytes: &[u8]) -> Option<Diagnostic> {
    let name = name.to_ascii_lowercase();
    let by_name = || {
        let ends =
            |kind: &&&ForeignFormat| kind.endings.iter().any(|ending| name.ends_with(ending));
        FOREIGN_FORMATS.iter().find(ends).copied()
    };
    by_content(bytes)
        .or_else(by_name)
        .map(ForeignFormat::diagnostic)
}
