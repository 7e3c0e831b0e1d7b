//! Decoding of text files: character encoding and line ends, for all formats in one place.
//!
//! The encoding is taken from the first of these that exists:
//!
//! 1. the byte order mark,
//! 2. the declaration in the file (`<?xml encoding=..?>`, `$DWGCODEPAGE` of DXF),
//! 3. UTF-8, if the bytes are valid UTF-8,
//! 4. a guess that depends on the format ([`Fallback`]), reported as a note.
//!
//! A lone carriage return also ends a line. Positions in a [`Diagnostic`] refer to the decoded
//! text, so a front end that shows a line of the file must take it from [`source_text`].

use magician_host::message;
use std::borrow::Cow;

use crate::{Diagnostic, DiagnosticCode, Lines};

/// Length of the head of a file in which an encoding may be declared, bytes. DXF declares its code
/// page behind other header variables, so one line is not enough.
const DECLARATION_BYTES: usize = 4096;

/// Handling of bytes that are neither UTF-8 nor in a declared encoding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fallback {
    /// Decode as Windows-1252, the legacy encoding of Western Europe.
    #[cfg_attr(
        not(any(feature = "drawings", feature = "lettering", feature = "programs")),
        allow(dead_code, reason = "only texts that people write are guessed")
    )]
    Western,
    /// Map each byte to one character: for formats that are defined in bytes (HPGL), or have other
    /// characters only in comments (G-code).
    #[cfg_attr(not(feature = "drawings"), allow(dead_code))]
    Bytes,
    /// Refuse: the format requires UTF-8.
    Refused,
}

/// A decoded text.
#[derive(Clone, Debug)]
#[cfg_attr(
    not(any(feature = "drawings", feature = "lettering", feature = "programs")),
    allow(dead_code)
)]
pub(crate) struct Decoded<'b> {
    /// Text without a byte order mark. Lines end with LF or CR LF.
    pub(crate) text: Cow<'b, str>,
    /// Note about an assumption or about characters left out.
    pub(crate) note: Option<Diagnostic>,
}

/// Decodes the text of a file.
///
/// # Errors
/// A [`Diagnostic`] if the encoding is unknown, the bytes are not text, or UTF-16 is cut off.
pub(crate) fn decode(bytes: &[u8], fallback: Fallback) -> Result<Decoded<'_>, Diagnostic> {
    let decoded = decode_characters(bytes, fallback)?;
    Ok(Decoded {
        text: with_line_feeds(decoded.text),
        ..decoded
    })
}

/// Returns the text of a file as the readers of this crate see it, for showing the lines that a
/// [`Diagnostic`] refers to. `None` if the file is not text.
///
/// ```
/// use magician_formats::source_text;
///
/// assert_eq!(source_text(b"G21\rG90\r").unwrap(), "G21\nG90\n");
/// assert_eq!(source_text(b"\xFF\xFEM\x002\x00").unwrap(), "M2");
/// assert_eq!(source_text(b"\x89PNG\r\n\x1A\n\0\0"), None);
/// ```
#[must_use]
pub fn source_text(bytes: &[u8]) -> Option<Cow<'_, str>> {
    let is_wide = utf16_order(bytes).is_some();
    if !is_wide && std::str::from_utf8(bytes).is_err() && bytes.contains(&0) {
        return None;
    }
    let decoded = decode(bytes, Fallback::Western).ok()?;
    Some(decoded.text)
}

/// Decodes the first bytes of a file for format detection. `None` if they are not text.
pub(crate) fn head(bytes: &[u8]) -> Option<Cow<'_, str>> {
    // The cut may fall within a character: drop the incomplete one.
    let bytes = match std::str::from_utf8(bytes) {
        Err(error) if error.error_len().is_none() => bytes.get(..error.valid_up_to())?,
        _ => bytes,
    };
    let even = bytes.get(..bytes.len() & !1)?;
    source_text(if utf16_order(bytes).is_some() {
        even
    } else {
        bytes
    })
}

/// Byte order of UTF-16.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Utf16Order {
    Little,
    Big,
}

/// Detects UTF-16 by its byte order mark, or by two ASCII characters at the start. Returns the byte
/// order and the length of the mark.
fn utf16_order(bytes: &[u8]) -> Option<(Utf16Order, usize)> {
    match bytes {
        [0xFF, 0xFE, ..] => Some((Utf16Order::Little, 2)),
        [0xFE, 0xFF, ..] => Some((Utf16Order::Big, 2)),
        [9..=126, 0, 9..=126, 0, ..] => Some((Utf16Order::Little, 0)),
        [0, 9..=126, 0, 9..=126, ..] => Some((Utf16Order::Big, 0)),
        _ => None,
    }
}

/// Decodes as [`decode`] does, but keeps carriage returns: in labels of HPGL they return to the
/// margin.
///
/// # Errors
/// Same as [`decode`].
pub(crate) fn decode_characters(
    bytes: &[u8],
    fallback: Fallback,
) -> Result<Decoded<'_>, Diagnostic> {
    if let Some((order, mark)) = utf16_order(bytes) {
        let text = decode_utf16(bytes.get(mark..).unwrap_or_default(), order)?;
        return Ok(Decoded {
            text: text.into(),
            note: None,
        });
    }
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let is_utf8 = std::str::from_utf8(bytes);
    if let Some(declared) = declared(bytes, is_utf8.is_ok()).filter(|_| !bytes.is_ascii())
        && let Some(decoded) = decode_declared(bytes, declared)
    {
        return decoded;
    }
    let good = match is_utf8 {
        Ok(text) => {
            return Ok(Decoded {
                text: text.into(),
                note: None,
            });
        }
        Err(error) => bytes.get(..error.valid_up_to()).unwrap_or_default(),
    };
    let place = || {
        let good = with_line_feeds(String::from_utf8_lossy(good));
        Lines::new(&good).origin(good.len()..good.len())
    };
    let refused = || Err(Diagnostic::new(place(), message!("this is not UTF-8 text")));
    match fallback {
        Fallback::Refused => refused(),
        Fallback::Bytes => Ok(Decoded {
            text: bytes.iter().map(|byte| char::from(*byte)).collect(),
            note: None,
        }),
        // No single-byte text contains a zero byte, so this is binary data.
        Fallback::Western if bytes.contains(&0) => refused(),
        Fallback::Western => {
            let message = message!(
                "the file is not UTF-8 from here on, and names no encoding: it is read as Windows-1252"
            );
            let note = Diagnostic::new(place(), message).coded(DiagnosticCode::Assumed);
            Ok(Decoded {
                text: western(bytes).into(),
                note: Some(note.help(message!("save it as UTF-8 if characters are wrong"))),
            })
        }
    }
}

fn decode_utf16(bytes: &[u8], order: Utf16Order) -> Result<String, Diagnostic> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    let units = pairs.iter().map(|pair| match order {
        Utf16Order::Little => u16::from_le_bytes(*pair),
        Utf16Order::Big => u16::from_be_bytes(*pair),
    });
    let text: Result<String, _> = char::decode_utf16(units).collect();
    match (text, rest) {
        (Ok(text), []) => Ok(text),
        _ => Err(
            Diagnostic::of_file(message!("it begins as UTF-16, and is damaged or cut off"))
                .help(message!("save it as UTF-8")),
        ),
    }
}

/// Windows-1252 from 0x80 to 0x9F. Its five undefined codes stay control characters.
const WINDOWS_1252: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8D}', 'Ž', '\u{8F}',
    '\u{90}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9D}', 'ž', 'Ÿ',
];

fn western(bytes: &[u8]) -> String {
    let character = |byte: &u8| match byte {
        0x80..=0x9F => WINDOWS_1252[usize::from(byte - 0x80)],
        byte => char::from(*byte),
    };
    bytes.iter().map(character).collect()
}

/// Returns the encoding that a file declares, as the Encoding Standard names it.
fn declared(bytes: &[u8], is_utf8: bool) -> Option<String> {
    let head = bytes.get(..DECLARATION_BYTES).unwrap_or(bytes);
    let head: String = head.iter().map(|byte| char::from(*byte)).collect();
    if head.starts_with("<?xml") {
        let declaration = head.split("?>").next()?;
        let value = declaration.split_once("encoding")?.1.trim_start();
        let value = value.strip_prefix('=')?.trim_start();
        let quote = value.chars().next().filter(|sign| "'\"".contains(*sign))?;
        let name = value[1..].split(quote).next()?.trim();
        // A file whose declaration is readable byte by byte is not UTF-16: ignore the declaration.
        let wrong = name.to_ascii_lowercase().starts_with("utf-16");
        return (!wrong).then(|| name.to_owned());
    }
    // From version 2007 on AutoCAD writes UTF-8 and still names a code page: ignore it if the bytes
    // are valid UTF-8.
    let mut lines = head.lines().map(str::trim);
    lines
        .find(|line| *line == "$DWGCODEPAGE")
        .filter(|_| !is_utf8)?;
    let page = lines.nth(1)?.to_ascii_lowercase();
    Some(match page.strip_prefix("ansi_").unwrap_or(&page) {
        "932" => "shift_jis".to_owned(),
        "936" | "gb2312" => "gbk".to_owned(),
        "949" => "euc-kr".to_owned(),
        "950" | "big5" => "big5".to_owned(),
        "dos866" => "ibm866".to_owned(),
        number if number.bytes().all(|byte| byte.is_ascii_digit()) => format!("windows-{number}"),
        other => other.to_owned(),
    })
}

/// Decodes in the declared encoding. `None` if the declaration is not needed: it names UTF-8, or an
/// unknown encoding although the bytes are valid UTF-8.
#[cfg(any(feature = "drawings", feature = "programs"))]
fn decode_declared<'b>(bytes: &'b [u8], name: String) -> Option<Result<Decoded<'b>, Diagnostic>> {
    let encoding = encoding_rs::Encoding::for_label_no_replacement(name.as_bytes());
    let Some(encoding) = encoding else {
        // Most files with an unknown declaration are in fact UTF-8.
        let message = message!(
            "the file says that its encoding is {name}, which is unknown",
            name
        );
        let refused = Diagnostic::of_file(message).help(message!("save it as UTF-8"));
        return std::str::from_utf8(bytes).is_err().then_some(Err(refused));
    };
    if encoding == encoding_rs::UTF_8 {
        return None;
    }
    let (text, damaged) = encoding.decode_without_bom_handling(bytes);
    let note = damaged.then(|| {
        let message = message!(
            "characters that {encoding} does not have are left out",
            encoding = encoding.name()
        );
        Diagnostic::of_file(message).coded(DiagnosticCode::LeftOut)
    });
    let text = if damaged {
        text.replace('\u{FFFD}', "").into()
    } else {
        text
    };
    Some(Ok(Decoded { text, note }))
}

#[cfg(not(any(feature = "drawings", feature = "programs")))]
fn decode_declared<'b>(_: &'b [u8], _: String) -> Option<Result<Decoded<'b>, Diagnostic>> {
    None
}

/// Replaces each lone carriage return with a line feed. CR LF stays.
///
/// Both are one byte, so offsets into the text stay valid.
pub(crate) fn with_line_feeds(text: Cow<'_, str>) -> Cow<'_, str> {
    // Runs of carriage returns that no line feed follows.
    let mut alone: Vec<std::ops::Range<usize>> = Vec::new();
    let bytes = text.as_bytes();
    let mut at = 0;
    while let Some(next) = bytes
        .get(at..)
        .and_then(|rest| rest.iter().position(|byte| *byte == b'\r'))
    {
        let start = at + next;
        let run = bytes[start..].iter().take_while(|byte| **byte == b'\r');
        at = start + run.count();
        if bytes.get(at) != Some(&b'\n') {
            alone.push(start..at);
        }
    }
    if alone.is_empty() {
        return text;
    }
    let mut changed = String::with_capacity(text.len());
    let mut done = 0;
    for run in alone {
        changed += &text[done..run.start];
        changed.extend(run.clone().map(|_| '\n'));
        done = run.end;
    }
    changed += &text[done..];
    changed.into()
}

/// Parses a finite number as programs of any locale write it: with a decimal comma, or with the
/// exponent of Fortran (`2.0D+01`).
pub(crate) fn number(text: &str) -> Option<f64> {
    let plain = text.parse().ok();
    let read = plain.or_else(|| {
        let one_comma = text.matches(',').count() == 1 && !text.contains('.');
        let mut changed = if one_comma {
            text.replace(',', ".")
        } else {
            text.to_owned()
        };
        if let Some(at) = changed.find(['d', 'D']) {
            changed.replace_range(at..=at, "e");
        }
        changed.parse().ok()
    });
    read.filter(|number: &f64| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8]) -> String {
        decode(bytes, Fallback::Western).unwrap().text.into_owned()
    }

    #[test]
    fn byte_order_marks_and_zero_bytes_identify_utf_16() {
        let wide = |text: &str, mark: bool, big: bool| -> Vec<u8> {
            let mark = mark.then_some('\u{FEFF}');
            let text: String = mark.into_iter().chain(text.chars()).collect();
            let units = text.encode_utf16();
            let bytes = units.flat_map(|unit| {
                if big {
                    unit.to_be_bytes()
                } else {
                    unit.to_le_bytes()
                }
            });
            bytes.collect()
        };
        for (mark, big) in [(true, true), (true, false), (false, true), (false, false)] {
            assert_eq!(
                text(&wide("G21\r\nG90 (größer)", mark, big)),
                "G21\r\nG90 (größer)"
            );
        }
        assert_eq!(text("\u{FEFF}G21".as_bytes()), "G21");
        let cut = decode(&[0xFF, 0xFE, 0x3C], Fallback::Western).unwrap_err();
        assert!(cut.message.contains("cut off"), "{cut}");
    }

    #[cfg(any(feature = "drawings", feature = "programs"))]
    #[test]
    fn declared_encodings_are_decoded() {
        let latin = b"<?xml version='1.0' encoding='ISO-8859-1'?><a b='Tr\xE4ger'/>";
        assert!(text(latin).contains("Träger"));
        let chinese = b"<?xml version=\"1.0\" encoding=\"GB2312\"?><a b=\"\xB5\xE3\"/>";
        assert!(text(chinese).contains('点'));
        let page = |page: &str, value: &[u8]| {
            let head = format!("0\nSECTION\n2\nHEADER\n9\n$DWGCODEPAGE\n3\n{page}\n1\n");
            text(&[head.as_bytes(), value].concat())
        };
        assert!(page("ANSI_1251", b"\xC4\xE0").ends_with("Да"));
        assert!(page("ANSI_936", b"\xB5\xE3").ends_with('点'));
        assert!(page("ANSI_1252", "Träger".as_bytes()).ends_with("Träger"));
        let unknown = b"<?xml encoding='EBCDIC-X'?><a b='\xE4'/>";
        let refused = decode(unknown, Fallback::Western).unwrap_err();
        assert!(refused.message.contains("EBCDIC-X"), "{refused}");
    }

    #[test]
    fn undeclared_bytes_are_guessed_with_a_note_at_their_position() {
        let decoded = decode(b"G21\n(\x80 Tr\xE4ger)", Fallback::Western).unwrap();
        assert_eq!(decoded.text, "G21\n(€ Träger)");
        let note = decoded.note.unwrap();
        assert_eq!((note.origin.line, note.origin.column), (2, 2));
        let bytes = decode(b"PE\xBF\x80;", Fallback::Bytes).unwrap();
        assert_eq!(bytes.text, "PE\u{BF}\u{80};");
        assert!(decode(b"{\xFF}", Fallback::Refused).is_err());
        assert!(decode(b"\x89PNG\0\xFF", Fallback::Western).is_err());
    }

    #[test]
    fn lone_carriage_returns_end_lines_and_keep_positions() {
        for (from, to) in [
            ("a\rb\r\rc", "a\nb\n\nc"),
            ("a\r\nb", "a\r\nb"),
            ("a\r\r\nb\rc", "a\r\r\nb\nc"),
            ("a\n\rb", "a\n\nb"),
            ("é\r", "é\n"),
        ] {
            assert_eq!(text(from.as_bytes()), to, "{from:?}");
        }
        assert!(matches!(
            decode(b"a\r\nb", Fallback::Refused).unwrap().text,
            Cow::Borrowed(_)
        ));
    }

    #[test]
    fn localised_numbers_are_read_if_unambiguous() {
        assert_eq!(number("0,5"), Some(0.5));
        assert_eq!(number("-2.0D+01"), Some(-20.0));
        assert_eq!(number("1,5d1"), Some(15.0));
        for text in ["1,234.5", "1,2,3", "", "d", "0,5,", "inf", "nan"] {
            assert_eq!(number(text), None, "{text}");
        }
    }
}
