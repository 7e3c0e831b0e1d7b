//! Which port: the one given, or the one arm that is plugged in.

use magician::measure::unbound_adapters;
use magician::{ErrorKind, Port, Target};

use super::{Finding, Report};
use crate::context::Context;
use crate::failure::Failure;

/// Where the arm is, with what was found on the way.
pub(super) fn target(context: &mut Context, report: &mut Report) -> Result<Target, Failure> {
    let given = context.port()?;
    let target = match given {
        Some(port) => port.parse()?,
        None => search(context, report)?,
    };
    report.port = Some(target.to_string());
    if let Target::Serial(path) = &target {
        let known = magician::ports().unwrap_or_default();
        let finding = match known.iter().find(|port| port.path == *path) {
            Some(port) => Finding::good("port", port.to_string()),
            None => Finding::note("port", format!("{path}, not in the system's list of ports")),
        };
        report.add(finding.value(path.as_str()), &mut context.out)?;
    }
    Ok(target)
}

/// The one arm that is plugged in.
fn search(context: &mut Context, report: &mut Report) -> Result<Target, Failure> {
    let ports = match magician::ports() {
        Ok(ports) => ports,
        Err(error) => return Err(report.end_with("port", error, &mut context.out)),
    };
    let arms: Vec<&Port> = ports.iter().filter(|port| port.likely_arm()).collect();
    let finding = match arms.as_slice() {
        [arm] => return Ok(Target::Serial(arm.path.clone())),
        [] => nobody(&ports),
        several => {
            let paths: Vec<_> = several.iter().map(|port| port.to_string()).collect();
            let text = format!("several ports could be the arm's: {}", paths.join("; "));
            Finding::bad("port", text).hint("choose one with --port")
        }
    };
    Err(report.end(finding, ErrorKind::Port, &mut context.out))
}

/// There is no port of an arm: why?
fn nobody(ports: &[Port]) -> Finding {
    if let [adapter, ..] = unbound_adapters().as_slice() {
        let (chip, module) = (adapter.chip, adapter.module);
        let text = format!("a {chip} adapter is plugged in, but the system has no port for it");
        let hint = match module {
            "ch341" => {
                "`sudo modprobe ch341` loads its driver; if the port goes away again at once, brltty takes it for a \
                 braille display: `sudo apt remove brltty`"
                    .to_owned()
            }
            module => format!("`sudo modprobe {module}` loads its driver; `sudo dmesg` shows what \
                happened to it"),
        };
        return Finding::bad("port", text).hint(hint);
    }
    let text = match ports {
        [] => "this computer has no serial port".to_owned(),
        others => {
            let all: Vec<_> = others.iter().map(Port::to_string).collect();
            format!("no port looks like an arm's; ports: {}", all.join("; "))
        }
    };
    Finding::bad("port", text).hint(
        "switch the arm on, and connect it with a USB cable that carries data (some only charge); \
            in a virtual machine or container, pass the device through; an arm on Wi-Fi is --port \
        udp:HOST, a virtual one --port sim",
    )
}
