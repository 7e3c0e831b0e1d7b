//! Invalid options, through the program itself: the messages are those of all front ends.

use crate::magician::run;

const SQUARE: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../magician-program/samples/logo.svg"
);

#[test]
fn bad_option_is_refused_before_a_file_is_read() {
    for (arguments, message) in [
        (
            &["--fill", "hatch", "--fill-spacing", "0.001"][..],
            "--fill-spacing: fill_spacing is a number from 0.02 to 10000 mm, not 0.001",
        ),
        (
            &["--fill", "hatch", "--fill-inset=-3"],
            "--fill-inset: fill_inset is a number from 0 to 10000 mm, not -3",
        ),
        (
            &["--fill", "hatch", "--fill-inset=nan"],
            "--fill-inset: fill_inset is a number from 0 to 10000 mm, not nan",
        ),
        (
            &["--brightness", "400"],
            "--brightness: brightness is a number from -100 to 100, not 400",
        ),
        (
            &["--merge", "1e300"],
            "--merge: merge is a number from 0 to 10000 mm, not 1e300",
        ),
        (
            &["--scale", "-1"],
            "--scale: scale is a number above 0 and at most 10000, not -1",
        ),
        (&["--margin", "5"], "`--margin` needs `--page`"),
        (
            &["--image", "outline", "--levels", "3"],
            "`--levels` needs `--image`: halftone or hatch",
        ),
        (
            &["--raw", "--at", "200,0"],
            "--raw: raw and at contradict each other",
        ),
    ] {
        let ran = run(&[&["draw", SQUARE, "--check"], arguments].concat());
        assert_eq!(ran.status, 2, "{ran:?}");
        assert!(ran.err.contains(message), "{message}: {ran:?}");
    }
}
