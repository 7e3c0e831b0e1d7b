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
    (
        "Name a port with --port, or use --port sim for a virtual arm",
        "Name a port, or use \"sim\" for a virtual arm",
    ),
    ("choose one with --port", "name one of them"),
    ("Arm::stop_jog", "`arm.stop_jog()`"),
    ("laser(false)", "laser(False)"),
];

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
