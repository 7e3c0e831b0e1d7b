//! Splits a line into words.

use crate::failure::Failure;

/// Splits a line at spaces. Quotes keep words together, and `#` begins a comment.
pub(super) fn split(line: &str) -> Result<Vec<String>, Failure> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    for letter in line.chars() {
        match (quote, letter) {
            (Some(mark), letter) if letter == mark => quote = None,
            (Some(_), letter) => word.get_or_insert_default().push(letter),
            (None, '"' | '\'') => {
                quote = Some(letter);
                word.get_or_insert_default();
            }
            (None, '#') if word.is_none() => break,
            (None, letter) if letter.is_whitespace() => words.extend(word.take()),
            (None, letter) => word.get_or_insert_default().push(letter),
        }
    }
    if let Some(mark) = quote {
        return Err(Failure::usage(format!("unclosed {mark}")));
    }
    words.extend(word);
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::split;

    #[test]
    fn words_quotes_and_comments() {
        let words = |line| split(line).map_err(|failure| failure.message);
        assert_eq!(
            words("move 1  -2 3 # up"),
            Ok(["move", "1", "-2", "3"].map(String::from).to_vec())
        );
        assert_eq!(
            words("set X device_name='my arm'"),
            Ok(["set", "X", "device_name=my arm"]
                .map(String::from)
                .to_vec())
        );
        assert_eq!(words("  # nothing"), Ok(Vec::new()));
        assert_eq!(words("''"), Ok(vec![String::new()]));
        assert!(words("set name=\"open").is_err());
    }
}
