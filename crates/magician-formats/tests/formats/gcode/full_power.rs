//! Full laser power: the S word that means 100 %, where it is found, and guesses that err towards
//! less power.

use magician_formats::formats::{Dialect, GcodeOptions};
use magician_formats::{Action, Diagnostic};

use super::{actions, actions_with, diagnostic, notes, try_read, try_with};

/// Returns the powers of a program's burns, percent.
fn powers_with(text: &str, set: impl FnOnce(&mut GcodeOptions)) -> Vec<f32> {
    let all = actions_with(text, set).into_iter();
    all.filter_map(|action| match action {
        Action::Burn { power, .. } if power > 0.0 => Some(power),
        _ => None,
    })
    .collect()
}

fn powers(text: &str) -> Vec<f32> {
    powers_with(text, |_| {})
}

/// Returns a job as LightBurn writes it, with a comment for each cut (percent, S).
fn lightburn(cuts: &[(f64, f64)]) -> String {
    let mut text = "; LightBurn 1.4.00\n; GRBL device profile, absolute coords\nG00 G17 G40 G21 G54\nG90\nM4\nG0 X220 Y0 Z0\n".to_owned();
    for (nth, (percent, s)) in cuts.iter().enumerate() {
        text += &format!(
            "; Cut @ 600 mm/min, {percent}% power\nM8\nG0 X220Y{nth}\n; Layer C0{nth}\nG1 X240S{s}F600\nM9\nG1 S0\n"
        );
    }
    text + "M5\nM2\n"
}

#[test]
fn job_at_20_percent_burns_at_20_percent() {
    assert_eq!(powers(&lightburn(&[(20.0, 200.0)])), [20.0]);
    assert_eq!(
        powers(&lightburn(&[(20.0, 51.0)])),
        [5.1],
        "a range of 255 is darker than it was meant"
    );
    assert_eq!(powers(&lightburn(&[(20.0, 2000.0)])), [20.0]);
    // Full power is the greatest value of all cuts, so that no cut exceeds 100 %.
    assert_eq!(
        powers(&lightburn(&[(50.0, 500.0), (20.0, 400.0)])),
        [25.0, 20.0]
    );
    assert_eq!(
        powers(&lightburn(&[(90.0, 1200.0), (100.0, 1500.0)])),
        [80.0, 100.0]
    );
    let told = notes(&lightburn(&[(20.0, 400.0)]));
    assert_eq!(
        told[0],
        "line 7, column 1: full power is S2000, by LightBurn's comments: 20 % is S400"
    );
}

#[test]
fn first_matching_rule_sets_full_power() {
    let program = |head: &str, s: &str| format!("{head}G0 X220 Y0 Z0\nM3\nG1 X221 F600 S{s}\nM5\n");
    for (head, s, full, power) in [
        ("$30=500\n", "100", "S500, as $30 says", 20.0),
        ("; grbl $30=255 $32=1\n", "51", "S255, as $30 says", 20.0),
        ("(max: $30 = 12000)\n", "6000", "S12000, as $30 says", 50.0),
        ("$30=500\n$30=400\n", "100", "S400, as $30 says", 25.0),
        (
            "$30=400\n; Cut @ 600 mm/min, 20% power\n",
            "100",
            "S400, as $30 says",
            25.0,
        ),
        ("", "100", "assumed to be S1000", 10.0),
        ("", "1000", "assumed to be S1000", 100.0),
        ("$30=0\n", "100", "assumed to be S1000", 10.0),
    ] {
        let text = program(head, s);
        assert_eq!(powers(&text), [power], "{text}");
        assert!(notes(&text)[0].contains(full), "{:?}", notes(&text));
        let said = powers_with(&text, |options| options.s_max = Some(20_000.0));
        assert_eq!(said, [s.parse::<f32>().unwrap() / 200.0], "{text}");
    }
    // A setting after the laser was switched on belongs to another job.
    assert_eq!(
        powers("G0 X220 Y0 Z0\nM3\n$30=100\nG1 X221 F600 S50\n"),
        [5.0]
    );
    let fan = "G0 X220 Y0 Z0\nM106 S51\nG1 X221 F600\nM107\n";
    assert_eq!(powers(fan), [20.0]);
    assert!(notes(fan)[0].contains("S255, that of a fan"));
    // Where M3 switches the laser, M106 is a fan, whose S does not define full power.
    assert_eq!(
        powers("G0 X220 Y0 Z0\nM106 S255\nM3 S100\nG1 X221 F600\nM107\n"),
        [10.0]
    );
    // A program without M3 has the same default.
    let bare = "G0 X220 Y0 Z0\nG1 X221 S100 F600\n";
    assert_eq!(
        powers_with(bare, |options| options.dialect = Dialect::Laser),
        [10.0]
    );
    let usual = try_read(bare).expect("it is all right").1;
    assert_eq!(usual[0].remedies[0].act.to_string(), "s_max N");
}

#[test]
fn undeterminable_full_power_is_refused_with_its_line() {
    let of = |text: &str, s_max| -> Diagnostic {
        try_with(text, |options| options.s_max = s_max).expect_err(text)
    };
    let fast = "G0 X220 Y0 Z0\nM3 S10\nG1 X221 S12000\nG1 X222 S15000\nM5\n";
    let refused = of(fast, None);
    assert_eq!(
        refused.to_string(),
        "line 3, column 9: S12000 is above 1000, but the S of full power is unknown"
    );
    assert_eq!(refused.remedies[0].act.to_string(), "s_max N");
    assert!(
        of(fast, Some(12000.0))
            .to_string()
            .starts_with("line 4, column 9: S15000 is above full power")
    );
    assert!(
        diagnostic("$30=100\nG0 X220 Y0 Z0\nM3 S101\n")
            .starts_with("line 3, column 4: S101 is above")
    );
    assert!(
        diagnostic("G0 X220 Y0 Z0\nM106 S256\n").starts_with("line 2, column 6: S256 is above")
    );
    assert!(
        diagnostic("G0 X220 Y0 Z0\nM3 S5\nG1 X221 S-1\n")
            .starts_with("line 3, column 9: the power is S-1")
    );
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = of(fast, Some(wrong));
        assert_eq!(refused.remedies[0].act.to_string(), "s_max N");
    }
}

#[test]
fn a_mill_burns_nothing() {
    let mills = [
        (
            "G0 X220 Y0 Z5\nM3 S800\nG1 Z-1 F100\nG1 X240 F300\nM5\n",
            "cuts at Z",
        ),
        (
            "G0 X220 Y0 Z5\nM3 S12000\nG1 Z-1 F100\nG1 X240 F300\nM5\n",
            "cuts at Z",
        ),
        (
            "G0 X220 Y0 Z1\nG91\nM3 S800\nG1 Z-2 F100\nG1 X20 F300\nM5\n",
            "cuts at Z",
        ),
        (
            "T1 M6\nM3 S800\nG0 X220 Y0 Z0\nG1 X240 F300\nM5\n",
            "changes tools",
        ),
        (
            "T1\nM3 S800\nG0 X220 Y0 Z0\nG1 X240 F300\nT2\nM5\n",
            "changes tools",
        ),
        (
            "M3 S800\nM8\nG0 X220 Y0 Z0\nG1 X240 F300\nM9\nM5\n",
            "switches coolant",
        ),
        ("M7\nG0 X220 Y0 Z0\nG1 X240 F300 S800\n", "switches coolant"),
        (
            "G43 H1\nM3 S800\nG0 X220 Y0 Z5\nG1 Z1 F100\nG1 X240 F300\nM5\n",
            "tool length",
        ),
    ];
    for (text, sign) in mills {
        assert_eq!(powers(text), [0.0; 0], "{text}");
        assert!(
            actions(text)
                .iter()
                .any(|action| matches!(action, Action::Path { .. }))
        );
        let told = notes(text);
        assert!(
            told[0].contains(sign) && told[0].contains("nothing burns"),
            "{told:?}"
        );
        // The header of a laser program or the caller's dialect overrides the guess.
        if !text.contains("S12000") {
            for head in ["; made for a Laser\n", "(LightBurn)\n", "$32=1\n"] {
                let mut burnt = powers(&format!("{head}{text}"));
                burnt.dedup();
                assert_eq!(burnt, [80.0], "{head}{text}");
            }
            let laser = powers_with(text, |options| options.dialect = Dialect::Laser);
            assert!(!laser.is_empty() && laser.iter().all(|power| *power == 80.0));
        }
    }
    // Only comments before the first move are a header.
    assert_eq!(powers(&format!("{}; laser\n", mills[0].0)), [0.0; 0]);
    // A tool that is lifted, moved across and fed down again is a mill's; a laser goes down to its
    // work only once.
    let cut = "G1 Z0.5 F100\nX240 F300\nG0 Z5\nX220 Y5\n";
    let text = format!("M3 S12000\nG0 X220 Y0 Z5\n{cut}{cut}M5\n");
    assert_eq!(powers(&text), [0.0; 0]);
    assert!(notes(&text)[0].contains("it lifts its tool between cuts"));
    let text = format!("S1000\nG0 X220 Y0 Z5\no1 repeat [2]\n{cut}o1 endrepeat\n");
    assert_eq!(powers(&text), [0.0; 0]);
    let once = powers(&format!("G0 X220 Y0 Z5\nM3 S800\n{cut}G1 X240\nM5\n"));
    assert!(once.contains(&80.0), "{once:?}");
    // A single tool number and a Z below 0 without feeding do not indicate a mill.
    assert_eq!(
        powers("T1\nM3 S800\nG0 X220 Y0 Z-5\nG0 Z0\nG1 X240 F300\nM5\n"),
        [80.0]
    );
}

#[test]
fn laser_without_a_feed_gets_the_default_speed() {
    use magician::build;
    let text = "G0 X220 Y0 Z0\nM3 S100\nG1 X221\nG1 X222 F600\nM5\n";
    let speeds: Vec<_> = actions(text)
        .into_iter()
        .filter(|action| matches!(action, Action::Command(_)))
        .collect();
    let wanted = [
        build::line_speed(200.0, 200.0).into(),
        build::path_speed(20.0, 100.0).into(),
        build::path_speed(10.0, 100.0).into(),
    ];
    assert_eq!(speeds, wanted);
    assert!(
        notes(text)
            .iter()
            .any(|note| note.contains("before it gives F: it begins at 20 mm/s"))
    );
}

#[test]
fn m4_and_m3_are_distinguished_per_step() {
    let text = "G0 X220 Y0 Z0\nM3 S100\nG1 X221 F600\nM4\nG1 X222\nG1 X223 F24000\nG0 X230\nM3\nG1 X231\nM5\n";
    let (plan, _) = try_read(text).expect("it is all right");
    let feeds: Vec<Option<f32>> = plan
        .steps
        .iter()
        .filter(|step| matches!(step.action, Action::Burn { .. }))
        .map(|step| step.feed)
        .collect();
    assert_eq!(feeds, [None, Some(10.0), Some(400.0), None, None]);
}
