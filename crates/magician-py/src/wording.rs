//! What the driver's sentences say to do is the command line's; here it is what a Python program does.

/// A help of the command line in the words of `magician.load`: `--scale 0.5` is `scale=0.5`.
pub(crate) fn arguments(help: &str) -> String {
    let mut words = help.split(' ').peekable();
    let mut said: Vec<String> = Vec::new();
    while let Some(word) = words.next() {
        let Some(flag) = word.trim_start_matches('`').strip_prefix("--") else {
            said.push(word.to_owned());
            continue;
        };
        let end = flag.find(|letter: char| !letter.is_ascii_lowercase() && letter != '-');
        let (flag, rest) = flag.split_at(end.unwrap_or(flag.len()));
        let is_value = |next: &&str| {
            matches!(flag, "dialect" | "white")
                || next
                    .starts_with(|first: char| first.is_ascii_digit() || first.is_ascii_uppercase())
        };
        let value = words.next_if(|next| rest.is_empty() && is_value(next));
        let rest = rest.trim_start_matches('`');
        said.push(match (flag, value) {
            ("fit" | "mirror" | "invert" | "place" | "raw" | "clip-page", _) => {
                format!("{}=True{rest}", flag.replace('-', "_"))
            }
            ("no-order", _) => format!("order=False{rest}"),
            ("no-turn", _) => format!("turn=False{rest}"),
            ("dialect" | "white", Some(value)) => format!("{flag}=\"{value}\""),
            (flag, None) => format!("{}={rest}", flag.replace('-', "_")),
            (flag, Some(value)) => {
                let plain = value.trim_end_matches(['`', ',']);
                let after = value
                    .get(plain.len()..)
                    .unwrap_or_default()
                    .trim_start_matches('`');
                let plain = plain.to_ascii_lowercase();
                let plain = match plain.contains(',') {
                    true => format!("({})", plain.replace(',', ", ")),
                    false => plain,
                };
                format!("{}={plain}{after}", flag.replace('-', "_"))
            }
        });
    }
    said.join(" ")
}
