//! Choice of the port: the given one, or that of the only arm plugged in.

use magician::{ErrorKind, Port, Setting, SettingValue, Target, unbound_adapters};

use super::{Diagnosis, DiagnosisObserver, Finding, Part, system};

impl Diagnosis {
    /// Determines the target: the given port, or that of the only arm plugged in. Adds what it
    /// finds.
    ///
    /// # Errors
    /// An invalid port, and [`NoArm`](super::NoArm).
    pub fn find<A: DiagnosisObserver>(
        &mut self,
        given: Option<&str>,
        to: &mut A,
    ) -> Result<Target, A::Failure> {
        let target = match given {
            Some(port) => port.parse()?,
            None => self.search(to)?,
        };
        self.port = Some(target.to_string());
        if let Target::Serial(path) = &target {
            // The list only describes the port; opening it decides if it can be used.
            let known = magician::ports().unwrap_or_default();
            let finding = match known.iter().find(|port| port.path == *path) {
                Some(port) => Finding::good("port", port.to_string()),
                // A pseudo-terminal is in no list, so this is no fault.
                None => Finding::note("port", format!("{path}, not in the system's list of ports")),
            };
            self.add(finding.value(path.as_str()), to)?;
        }
        Ok(target)
    }

    /// Finds the only arm that is plugged in.
    fn search<A: DiagnosisObserver>(&mut self, to: &mut A) -> Result<Target, A::Failure> {
        let ports = match magician::ports() {
            Ok(ports) => ports,
            Err(error) => return Err(self.end_with("port", error, to)),
        };
        let arms: Vec<&Port> = ports.iter().filter(|port| port.likely_arm()).collect();
        let finding = match arms.as_slice() {
            [arm] => return Ok(Target::Serial(arm.path.clone())),
            [] => no_arm_found(&ports),
            several => {
                let paths: Vec<_> = several.iter().map(|port| port.to_string()).collect();
                let text = format!("several ports could be the arm's: {}", paths.join("; "));
                let advice = [Part::from("choose one with "), Setting::Port.into()];
                Finding::bad("port", text).advise(advice)
            }
        };
        Err(self.end(finding, ErrorKind::Port, to))
    }
}

/// Returns the finding for a computer without a port of an arm.
fn no_arm_found(ports: &[Port]) -> Finding {
    if let [adapter, ..] = unbound_adapters().as_slice() {
        let (chip, module) = (adapter.chip, adapter.module);
        let text = format!("a {chip} adapter is plugged in, but the system has no port for it");
        let load = system(format!("sudo modprobe {module}"));
        let finding = Finding::bad("port", text);
        return match module {
            // brltty takes the USB ids of this chip for those of a braille display.
            "ch341" => finding.advise([
                load,
                " loads its driver; if the port goes away again at once, brltty takes it for a braille display: "
                    .into(),
                system("sudo apt remove brltty"),
            ]),
            _ => finding.advise([
                load,
                " loads its driver; ".into(),
                system("sudo dmesg"),
                " shows what happened to it".into(),
            ]),
        };
    }
    let text = match ports {
        [] => "this computer has no serial port".to_owned(),
        others => {
            let all: Vec<_> = others.iter().map(Port::to_string).collect();
            format!("no port looks like an arm's; ports: {}", all.join("; "))
        }
    };
    Finding::bad("port", text).advise([
        Part::Text(
        "switch the arm on, and connect it with a USB cable that carries data (some only charge); in a virtual \
         machine or container, pass the device through; an arm on Wi-Fi is "
            .into()),
        (Setting::Port, SettingValue::Word("udp:HOST")).into(),
        ", a virtual one ".into(),
        (Setting::Port, SettingValue::Word("sim")).into(),
    ])
}
