//! The driver's list of adapters against what is installed and written of them.

use magician::measure::{of_arms, udev_rules};

const RULES: &str = include_str!("../../../packaging/70-magician.rules");
const TROUBLES: &str = include_str!("../../../docs/TROUBLESHOOTING.md");
const START: &str = include_str!("../../../docs/START.md");

#[test]
fn what_is_installed_and_written_names_each_adapter_of_the_list() {
    let rules: Vec<_> = RULES
        .lines()
        .filter(|line| !line.starts_with('#'))
        .collect();
    assert_eq!(rules, udev_rules().collect::<Vec<_>>());
    for (vendor, product, chip) in of_arms() {
        let ids = format!("{vendor:04x}:{product:04x}");
        assert!(TROUBLES.contains(&ids), "{ids}");
        assert!(START.contains(chip) && TROUBLES.contains(chip), "{chip}");
    }
}
