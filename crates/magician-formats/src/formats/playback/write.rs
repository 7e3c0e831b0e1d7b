//! Writer of playback files in the style of DobotStudio: one line, no XML declaration.

use super::Playback;
use super::row::Part;

impl Playback {
    /// Serialises the file. Unchanged items keep their text, including unknown ones.
    #[must_use]
    pub fn to_xml(&self) -> String {
        let mut xml = String::from("<root>");
        let heads = [
            ("DobotType", &self.dobot_type),
            ("row_StudioVersion", &self.version),
        ];
        for (name, text) in heads {
            if let Some(text) = text {
                xml.push_str(&format!("<{name}>"));
                item(&mut xml, 0, text);
                xml.push_str(&format!("</{name}>"));
            }
        }
        xml.extend(self.others.iter().map(String::as_str));
        for row in &self.rows {
            xml.push_str(&format!("<row{}>", row.number));
            for part in &row.parts {
                match part {
                    Part::Item(number, text) => item(&mut xml, *number, text),
                    Part::Other(source) => xml.push_str(source),
                }
            }
            xml.push_str(&format!("</row{}>", row.number));
        }
        xml.push_str("</root>");
        xml
    }
}

fn item(xml: &mut String, number: u32, text: &str) {
    if text.is_empty() {
        xml.push_str(&format!("<item_{number} />"));
        return;
    }
    xml.push_str(&format!("<item_{number}>"));
    for character in text.chars() {
        match character {
            '<' => xml.push_str("&lt;"),
            '>' => xml.push_str("&gt;"),
            '&' => xml.push_str("&amp;"),
            // XML readers normalise a literal carriage return to a line feed.
            '\r' => xml.push_str("&#13;"),
            plain => xml.push(plain),
        }
    }
    xml.push_str(&format!("</item_{number}>"));
}

/// True if XML can contain the character.
pub(super) fn is_xml_character(character: char) -> bool {
    matches!(character, '\t' | '\n' | '\r' | ' '..='\u{fffd}' | '\u{10000}'..)
}
