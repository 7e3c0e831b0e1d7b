//! Firmware profiles: parsing, validation, and errors.

use magician_motion::{ArmModel, ToolBias};
use magician_sim::{Profile, ProfileError};

fn changed(from: &str, to: &str) -> Result<Profile, ProfileError> {
    let pattern = Profile::pattern();
    assert!(pattern.contains(from), "{from}");
    Profile::from_toml(&pattern.replacen(from, to, 1))
}

#[test]
fn the_pattern_and_an_empty_file_are_the_built_in_profile() {
    for text in [&Profile::pattern(), ""] {
        assert_eq!(Profile::from_toml(text).unwrap(), Profile::default());
    }
    assert_eq!(Profile::default().check().ok(), Some(()));
    assert_eq!(Profile::default().arm_model(), ArmModel::MAGICIAN);
}

/// Each value of the pattern alone is a valid profile, even if its section has several.
#[test]
fn a_profile_gives_what_differs() {
    let pattern = Profile::pattern();
    let (mut header, mut count) = ("", 0);
    for line in pattern.lines() {
        match line.split_once(" = ") {
            _ if line.starts_with('[') => header = line,
            Some((key, value)) if !line.starts_with('#') && !value.starts_with("[\n") => {
                if value == "[" {
                    continue;
                }
                let text = format!("{header}\n{line}\n");
                assert_eq!(
                    Profile::from_toml(&text).ok(),
                    Some(Profile::default()),
                    "{key}: {text}"
                );
                count += 1;
            }
            _ => {}
        }
    }
    assert!(count > 60, "{count}");
    let one = Profile::from_toml("[limits.guaranteed]\nj3 = [-5.0, 80.0]\n").unwrap();
    assert_eq!(one.limits.guaranteed.j3, [-5.0, 80.0].into());
    assert_eq!(one.limits.guaranteed.j2, [0.0, 85.0].into());
    assert_eq!(one.limits.controller, Profile::default().limits.controller);
}

#[test]
fn every_value_of_the_built_in_profile_says_whence_it_comes() {
    let mut commented = 0;
    let pattern = Profile::pattern();
    let mut above = "";
    for line in pattern.lines() {
        let follows_comment = std::mem::replace(&mut above, line).starts_with('#');
        if line.contains(" = ") && !line.trim_start().starts_with('#') && !line.ends_with('[') {
            assert!(line.contains('#') || follows_comment, "{line}");
            commented += 1;
        }
    }
    assert!(commented > 60);
}

#[test]
fn values_that_make_no_sense_are_refused_by_name() {
    for (from, to, name) in [
        ("depth = 32", "depth = 0", "queue.depth is 0"),
        ("depth = 32", "depth = 100000", "queue.depth"),
        ("first_index = 2", "first_index = 0", "queue.first_index"),
        (
            "j1 = [-135.0, 135.0]",
            "j1 = [135.0, -135.0]",
            "limits.controller",
        ),
        (
            "j1 = [-90.0, 90.0]",
            "j1 = [nan, 90.0]",
            "limits.guaranteed",
        ),
        (
            "force_factor = 2.0",
            "force_factor = -1.0",
            "stop.force_factor",
        ),
        ("search = 20.0", "search = 0.0", "home.search"),
        ("switch = -135.0", "switch = nan", "home.switch"),
        ("back_off = 0.5", "back_off = 0.0", "home.back_off"),
        ("creep = [1.0, 0.5]", "creep = [1.0, -0.5]", "home.creep"),
        ("length = 1000.0", "length = 0.0", "rail.length"),
        (
            "home_velocity = 100.0",
            "home_velocity = nan",
            "rail.home_velocity",
        ),
        (
            "home_acceleration = 100.0",
            "home_acceleration = -1.0",
            "rail.home_acceleration",
        ),
        (
            "vacuum_delay = 0.3",
            "vacuum_delay = nan",
            "tools.vacuum_delay",
        ),
        (
            "jump_height = 20.0",
            "jump_height = nan",
            "defaults.ptp.jump_height",
        ),
        (
            "threshold = 5.0",
            "threshold = inf",
            "defaults.lost_step.threshold",
        ),
        (
            "tool = \"suction\"",
            "tool = [0.0, nan, 0.0]",
            "power_up.tool",
        ),
        (
            "plan_acceleration = 100.0",
            "plan_acceleration = 0.0",
            "defaults.cp.plan_acceleration",
        ),
        (
            "joints = [0.0, 45.0, 45.0, 0.0]",
            "joints = [inf, 45.0, 45.0, 0.0]",
            "power_up.joints",
        ),
        (
            "linear_velocity = 300.0",
            "linear_velocity = 0.0",
            "ceilings.linear_velocity",
        ),
        (
            "name = \"Dobot 2.0\"",
            "name = \"a\\u0000b\"",
            "identity.name",
        ),
        ("    \"DO\",        # 2 ", "    # 2 ", "io.pins is 19"),
    ] {
        let error = changed(from, to).expect_err(to).to_string();
        assert!(error.contains(name), "{to}: {error}");
    }
}

#[test]
fn the_tool_at_power_up_has_a_name_or_a_bias() {
    let tool =
        |text: &str| changed("tool = \"suction\"", text).map(|profile| profile.power_up.tool);
    assert_eq!(Profile::default().power_up.tool, ToolBias::SUCTION);
    for (text, bias) in [
        ("tool = \"none\"", ToolBias::NONE),
        ("tool = \"Pen\"", ToolBias::PEN),
        ("tool = \"61,0,5\"", ToolBias::new(61.0, 0.0, 5.0)),
        ("tool = [70, 1.5, 0]", ToolBias::new(70.0, 1.5, 0.0)),
    ] {
        assert_eq!(tool(text).unwrap(), bias, "{text}");
    }
    for text in [
        "tool = \"hammer\"",
        "tool = [1, 2]",
        "tool = [1, 2, 3, 4]",
        "tool = 5",
    ] {
        let error = tool(text).expect_err(text).to_string();
        assert!(
            error.contains("none, suction, gripper, pen or laser"),
            "{text}: {error}"
        );
    }
}

#[test]
fn what_is_unknown_or_misspelt_is_refused_with_its_place() {
    for (from, to, message) in [
        ("depth = 32", "depth = 32\ndeep = 1", "unknown field `deep`"),
        (
            "use = \"controller\"",
            "use = \"wide\"",
            "unknown variant `wide`",
        ),
        ("\"DO PWM\"", "\"DO PWN\"", "not PWN"),
        ("[stop]", "[stop", "line"),
    ] {
        let error = changed(from, to).expect_err(to).to_string();
        assert!(error.contains(message), "{to}: {error}");
    }
}
