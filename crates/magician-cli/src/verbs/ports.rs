use clap::Args;
use serde::Serialize;

use crate::columns::{Columns, note};
use crate::context::Context;
use crate::failure::Failure;

/// List the serial ports of this computer
#[derive(Args, Debug)]
pub(crate) struct Ports {}

#[derive(Serialize)]
struct List {
    ports: Vec<Entry>,
}

#[derive(Serialize)]
struct Entry {
    path: String,
    likely_arm: bool,
    usb: Option<Usb>,
}

#[derive(Serialize)]
struct Usb {
    vendor: u16,
    product: u16,
    name: Option<String>,
    manufacturer: Option<String>,
    serial: Option<String>,
}

impl From<magician::Port> for Entry {
    fn from(port: magician::Port) -> Self {
        Self {
            likely_arm: port.likely_arm(),
            path: port.path,
            usb: port.usb.map(|usb| Usb {
                vendor: usb.vendor,
                product: usb.product,
                name: usb.name,
                manufacturer: usb.manufacturer,
                serial: usb.serial,
            }),
        }
    }
}

impl Ports {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let ports: Vec<Entry> = magician::ports()?.into_iter().map(Entry::from).collect();
        let list = List { ports };
        context.show(&list, |out| {
            let mut columns = Columns::default();
            for port in &list.ports {
                columns.row([port.path.as_str(), likely(port), &device(port)]);
            }
            columns.write(out)?;
            match list.ports.iter().filter(|port| port.likely_arm).count() {
                0 => note(&nobody(list.ports.is_empty()), out),
                _ => Ok(()),
            }
        })
    }
}

/// What a person without an arm may do.
fn nobody(no_ports: bool) -> String {
    let found = match no_ports {
        true => "no serial ports",
        false => "none of these looks like an arm",
    };
    format!(
        "{found}; is it switched on and plugged in? --port udp:HOST is an arm on Wi-Fi, --port sim a virtual one"
    )
}

fn likely(port: &Entry) -> &'static str {
    if port.likely_arm { "likely an arm" } else { "" }
}

fn device(port: &Entry) -> String {
    let Some(usb) = &port.usb else {
        return "not USB".to_owned();
    };
    let name = usb.name.as_deref().unwrap_or_default();
    let maker = usb.manufacturer.as_deref().unwrap_or_default();
    let text = format!("{:04x}:{:04x} {maker} {name}", usb.vendor, usb.product);
    text.trim_end().to_owned()
}
