//! Words of a step: separated by spaces, or kept together by double quotes.

use std::time::Duration;

/// Splits a line into words; `"` keeps words together and is removed. Text after `#` is a comment.
pub(crate) fn split(line: &str) -> Result<Vec<String>, String> {
    let mut words: Vec<String> = Vec::new();
    let (mut quoted, mut in_word) = (false, false);
    for character in line.chars() {
        match character {
            '"' => {
                quoted = !quoted;
                if !in_word {
                    words.push(String::new());
                }
                in_word = true;
            }
            '#' if !quoted => break,
            character if character.is_whitespace() && !quoted => in_word = false,
            character => {
                if !in_word {
                    words.push(String::new());
                }
                in_word = true;
                if let Some(word) = words.last_mut() {
                    word.push(character);
                }
            }
        }
    }
    if quoted {
        return Err("a quotation mark is missing".to_owned());
    }
    Ok(words)
}

/// Parses bytes in hex.
pub(crate) fn bytes(words: &[String]) -> Result<Vec<u8>, String> {
    words.iter().map(|word| byte(word)).collect()
}

/// Parses a byte in hex.
pub(crate) fn byte(word: &str) -> Result<u8, String> {
    // `from_str_radix` accepts a sign, and one digit is more likely a typo.
    let has_two_digits = word.len() == 2 && !word.starts_with('+');
    let value = u8::from_str_radix(word, 16).ok().filter(|_| has_two_digits);
    value.ok_or_else(|| format!("'{word}' is not a byte: write two hex digits"))
}

/// Parses a duration: a number and `s` or `ms`, two words.
pub(crate) fn span(words: &[String]) -> Result<Duration, String> {
    let [number, unit] = words else {
        return Err("a time is missing: write '1.5 s' or '20 ms'".to_owned());
    };
    let factor = match unit.as_str() {
        "s" => 1.0,
        "ms" => 1e-3,
        other => return Err(format!("'{other}' is not a unit of time: write s or ms")),
    };
    let seconds = number.parse::<f64>().ok().map(|number| number * factor);
    seconds
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
        .ok_or_else(|| format!("'{number}' is not a time"))
}

/// Parses a code: decimal, or hex after `0x`.
pub(crate) fn code(word: &str) -> Result<u8, String> {
    let code = match word.strip_prefix("0x") {
        Some(hex) => u8::from_str_radix(hex, 16),
        None => word.parse(),
    };
    code.map_err(|_| format!("'{word}' is not a code: write 0x12 or 18"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_keep_words_together_and_comments_are_dropped() {
        let words = split(r#"set DeviceName device_name="A b" "" # the name"#).unwrap();
        assert_eq!(words, ["set", "DeviceName", "device_name=A b", ""]);
        assert!(split("a \"b").is_err());
        assert!(split("  # nothing").unwrap().is_empty());
    }

    #[test]
    fn times_bytes_and_codes_are_parsed() {
        let words = |text: &str| split(text).unwrap();
        assert_eq!(span(&words("1.5 s")), Ok(Duration::from_millis(1500)));
        assert_eq!(span(&words("20 ms")), Ok(Duration::from_millis(20)));
        for wrong in ["1.5", "x s", "1 h", "-1 s", "nan s"] {
            assert!(span(&words(wrong)).is_err(), "{wrong}");
        }
        assert_eq!(bytes(&words("AA 0f")), Ok(vec![0xAA, 0x0F]));
        assert!(byte("A").is_err() && byte("+A").is_err());
        assert_eq!((code("0x12"), code("18")), (Ok(18), Ok(18)));
    }
}
