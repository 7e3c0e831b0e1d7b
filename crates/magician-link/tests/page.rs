//! Checks that docs/guide/LINK.md names every call without a row in the protocol's table under the answer
//! of a virtual arm.

use magician_link::methods;

#[test]
fn page_lists_every_call_without_a_row() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/guide/LINK.md");
    let page = std::fs::read_to_string(page).expect("docs/guide/LINK.md");
    let line = |begin: &str| {
        let line = page.lines().find(|line| line.starts_with(begin));
        let line = line.unwrap_or_else(|| panic!("no line `{begin}`"));
        let calls = line.rsplit('|').nth(1).unwrap_or_default();
        calls
            .split(',')
            .map(|call| call.trim().to_owned())
            .collect::<Vec<_>>()
    };
    let names = |which: &dyn Fn(&magician_link::Method) -> bool| {
        let beyond = methods().iter().filter(|method| method.command.is_none());
        let those = beyond.filter(|method| which(method));
        those.map(|method| method.name.clone()).collect::<Vec<_>>()
    };
    let sorted = |mut names: Vec<String>| {
        names.sort();
        names
    };
    for (begin, which) in [
        (
            "| answered by what the arm has",
            &(|method: &magician_link::Method| method.virtual_answer.is_some())
                as &dyn Fn(&magician_link::Method) -> bool,
        ),
        ("| not there (-32604)", &|method| {
            method.virtual_answer.is_none() && method.refused.is_none()
        }),
        ("| never (-32605)", &|method| method.refused.is_some()),
    ] {
        assert_eq!(sorted(line(begin)), sorted(names(which)), "{begin}");
    }
}
