//! `SearchDobot`: lists ports and addresses.

use std::ffi::c_int;

use super::Registry;
use super::place::{PORT_VARIABLE, device_name};
use crate::notice;
use crate::pointer::Buffer;

impl Registry {
    /// `SearchDobot`: lists serial ports and the addresses of arms on Wi-Fi, separated by blanks.
    /// The port of `MAGICIAN_PORT` comes first. Names that do not fit the buffer are left out.
    ///
    /// Returns the number of names found, with or without a buffer, as the vendor's library does.
    pub fn search(&self, list: Buffer, size: u32) -> c_int {
        notice::host(
            "SearchDobot",
            || format!("size={size}"),
            || {
                let names = self.names();
                let text = join_fitting(&names, size as usize);
                list.put(text.as_bytes(), size as usize);
                c_int::try_from(names.len()).unwrap_or(c_int::MAX)
            },
        )
    }

    fn names(&self) -> Vec<String> {
        let configured = (self.environment.variable)(PORT_VARIABLE);
        let ports = self.environment.arm_ports();
        let ports = ports.iter().map(|path| device_name(path).to_owned());
        let arms = (self.environment.network)();
        let arms = arms.iter().map(ToString::to_string);
        let mut names = Vec::new();
        for name in configured.into_iter().chain(ports).chain(arms) {
            // Callers split the list at blanks.
            if name.contains(char::is_whitespace) {
                tracing::warn!("SearchDobot: a name with a space cannot be listed: {name}");
            } else if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }
}

/// Joins as many names as fit into `size` bytes together with a final NUL.
fn join_fitting(names: &[String], size: usize) -> String {
    let mut list = String::new();
    for name in names {
        let separator = usize::from(!list.is_empty());
        if list.len() + separator + name.len() < size {
            list.extend((separator > 0).then_some(' '));
            list.push_str(name);
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_do_not_fit_are_omitted() {
        let names = ["COM1", "COM30", "192.168.0.5", "C"].map(str::to_owned);
        assert_eq!(join_fitting(&names, 100), "COM1 COM30 192.168.0.5 C");
        assert_eq!(join_fitting(&names, 11), "COM1 COM30");
        assert_eq!(join_fitting(&names, 10), "COM1 C");
        assert_eq!(join_fitting(&names, 5), "COM1");
        assert_eq!(join_fitting(&names, 4), "C");
        for size in [0, 1] {
            assert_eq!(join_fitting(&names, size), "");
        }
        for size in 1..30 {
            assert!(join_fitting(&names, size).len() < size);
        }
    }
}
