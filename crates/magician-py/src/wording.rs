//! What the driver's sentences say to do is the command line's; here it is what a Python program does.

/// What the command line says, and what Python says.
const PHRASES: [(&str, &str); 11] = [
    ("`magician alarms --clear`", "`arm.clear_alarms()`"),
    ("`magician queue start`", "`arm.start_queue()`"),
    ("`magician stop`", "`arm.stop()`"),
    ("`magician home`", "`arm.home()`"),
    ("`magician laser off`", "`arm.laser(False)`"),
    ("`magician ports`", "`magician.ports()`"),
    ("`--keep`", "`keep=True`"),
    ("`--unhomed`", "`unhomed=True`"),
    (
        "Name a port with --port, or use --port sim for a virtual arm",
        "Name a port, or use \"sim\" for a virtual arm",
    ),
    ("choose one with --port", "name one of them"),
    ("Arm::stop_jog", "`arm.stop_jog()`"),
];

/// What lets a laser burn.
pub(crate) const LASER: &str = ": put on goggles for its wavelength, clear what must not burn, stay with it, and say \
                                 allow_laser=True";

/// A sentence of the driver's for people who write Python.
pub(crate) fn for_python(sentence: &str) -> String {
    let mut sentence = sentence.to_owned();
    for (line, python) in PHRASES {
        if sentence.contains(line) {
            sentence = sentence.replace(line, python);
        }
    }
    sentence
}

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
