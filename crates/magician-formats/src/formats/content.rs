//! Format detection by the first bytes of a file. It knows every format, whether its reader is
//! built in or not.

pub(super) mod plot;
pub(super) mod points;

use super::Format;
use crate::encoding;

/// Bytes at the start of a file that are examined. A choice: headers and comments before the first
/// characteristic line are shorter.
const EXAMINED_BYTES: usize = 4096;
/// Magic number of gzip files (RFC 1952, section 2.3.1).
pub(crate) const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Detects the format of a file from its bytes; `None` if they do not determine it.
pub(super) fn of(bytes: &[u8]) -> Option<Format> {
    let head = bytes.get(..EXAMINED_BYTES).unwrap_or(bytes);
    let begins = |with: &[u8]| head.starts_with(with);
    if begins(b"\x89PNG\r\n\x1A\n")
        || begins(b"\xFF\xD8\xFF")
        || begins(b"BM") && head.contains(&0)
        || begins(b"GIF8")
        || begins(b"II*\0")
        || begins(b"MM\0*")
        || begins(b"RIFF") && head.get(8..12) == Some(b"WEBP")
        || is_netpbm(head)
    {
        return Some(Format::Image);
    }
    if points::is_recording(head) {
        return Some(Format::Points);
    }
    // SVG is the only supported format that is commonly packed (`.svgz`).
    if begins(&GZIP_MAGIC) {
        return Some(Format::Svg);
    }
    if begins(b"AutoCAD Binary DXF\r\n") {
        return Some(Format::Dxf);
    }
    let text = encoding::head(head)?;
    let text = text.trim_start();
    match text.chars().next()? {
        '<' => match root_element(text)? {
            "root" => Some(Format::Playback),
            "svg" => Some(Format::Svg),
            "xml" => Some(Format::Blockly),
            _ => None,
        },
        '{' if text.contains("\"magician-plan\"") => Some(Format::Plan),
        '{' if text.contains("\"magician-testgrid\"") => Some(Format::TestGrid),
        _ if points::is_point_list(text) => Some(Format::Points),
        '{' => None,
        // A program of DobotLab is a JSON list.
        // DXF, HPGL and G-code come last because their tests are the weakest.
        '[' if text.contains("\"type\"") && text.contains("\"params\"") => Some(Format::Playback),
        _ if is_dxf(text) => Some(Format::Dxf),
        _ if is_hpgl(text) => Some(Format::Hpgl),
        _ if is_gcode(text) => Some(Format::Gcode),
        _ => None,
    }
}

/// True for the netpbm formats: `P1` to `P6`, followed by the size.
fn is_netpbm(head: &[u8]) -> bool {
    let Some((magic, rest)) = head.split_at_checked(2) else {
        return false;
    };
    let mut rest = rest.iter().skip_while(|byte| byte.is_ascii_whitespace());
    let is_one = matches!(magic, [b'P', b'1'..=b'6']);
    let separated = head.get(2).is_some_and(u8::is_ascii_whitespace);
    is_one
        && separated
        && rest
            .next()
            .is_some_and(|byte| byte.is_ascii_digit() || *byte == b'#')
}

/// True if a file is XML whose root element has this name.
pub(super) fn begins_with_element(bytes: &[u8], name: &str) -> bool {
    let text = encoding::head(bytes.get(..EXAMINED_BYTES).unwrap_or(bytes));
    text.is_some_and(|text| text.trim_start().starts_with('<') && root_element(&text) == Some(name))
}

/// Returns the name of the root element without its namespace.
fn root_element(mut text: &str) -> Option<&str> {
    loop {
        text = text.trim_start();
        let end = match text {
            _ if text.starts_with("<!--") => "-->",
            _ if text.starts_with("<?") => "?>",
            // A document type may contain declarations in brackets, which contain `>` themselves.
            _ if text.starts_with("<!") && text.split('>').next()?.contains('[') => "]>",
            _ if text.starts_with("<!") => ">",
            _ => break,
        };
        text = text.split_once(end)?.1;
    }
    let name = text.strip_prefix('<')?;
    let name = name
        .split(|end: char| end.is_whitespace() || matches!(end, '>' | '/'))
        .next()?;
    Some(name.rsplit(':').next().unwrap_or(name))
}

/// True if the text begins with a DXF section, possibly after comments. DXF is pairs of lines, a
/// code and a value.
fn is_dxf(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim);
    while let (Some(code), Some(value)) = (lines.next(), lines.next()) {
        match (code, value) {
            ("999", _) => {}
            ("0", value) => return value == "SECTION",
            _ => return false,
        }
    }
    false
}

/// True if the text begins with a two-letter instruction that plots begin with and contains a
/// terminator.
fn is_hpgl(text: &str) -> bool {
    const FIRST_INSTRUCTIONS: [&str; 9] = ["IN", "DF", "SP", "PU", "PD", "PA", "PG", "VS", "BP"];
    let text = plot::without_escapes(text).trim_start_matches([';', ':']);
    let first = text.get(..2).map(str::to_ascii_uppercase);
    let rest = text.get(2..).unwrap_or_default();
    first.is_some_and(|first| FIRST_INSTRUCTIONS.contains(&first.as_str()))
        && rest.starts_with(|next: char| !next.is_ascii_lowercase())
        && rest.contains(';')
}

/// True if the first line, comments aside, consists of words of a letter and a number, one of them
/// a G or an M.
fn is_gcode(text: &str) -> bool {
    let mut lines = text
        .lines()
        .map(without_comments)
        .filter(|line| !line.is_empty() && line != "%");
    let Some(line) = lines.next() else {
        return false;
    };
    let mut letters = line.chars().filter(char::is_ascii_alphabetic);
    let allowed = |sign: char| sign.is_ascii_digit() || matches!(sign, '+' | '-' | '.');
    let words = line
        .split(|sign: char| sign.is_ascii_alphabetic())
        .map(str::trim);
    let mut numbers = words
        .skip(1)
        .map(|number| number.split_whitespace().collect::<String>());
    line.starts_with(|first: char| first.is_ascii_alphabetic())
        && letters.any(|letter| matches!(letter.to_ascii_uppercase(), 'G' | 'M'))
        && numbers.all(|number| {
            number.contains(|sign: char| sign.is_ascii_digit()) && number.chars().all(allowed)
        })
}

/// Removes the comments of a line of G-code: parentheses, and anything after a semicolon.
fn without_comments(line: &str) -> String {
    let mut depth = 0u32;
    let code = line.split(';').next().unwrap_or_default();
    let outside = code.chars().filter(|sign| match sign {
        '(' => {
            depth += 1;
            false
        }
        ')' => {
            depth = depth.saturating_sub(1);
            false
        }
        _ => depth == 0,
    });
    outside.collect::<String>().trim().to_owned()
}
