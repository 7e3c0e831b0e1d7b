use clap::Args;
use magician_protocol::{Alarm, AlarmSet};
use serde::Serialize;

use crate::columns::note;
use crate::context::Context;
use crate::failure::Failure;
use crate::output::Output;

/// Show the alarms that stand, with cause and cure, or clear them
#[derive(Args, Debug)]
pub(crate) struct Alarms {
    /// Clear them, and with them the hold on the queue
    #[arg(long)]
    clear: bool,
}

#[derive(Serialize)]
struct List {
    alarms: Vec<Entry>,
}

#[derive(Serialize)]
struct Entry {
    code: u8,
    name: Option<&'static str>,
    cause: Option<&'static str>,
    cure: Option<&'static str>,
    holds_queue: bool,
}

impl Alarms {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        if self.clear {
            context.permit_queue()?;
        }
        let alarms = context.with_arm(async |arm, _| {
            if self.clear {
                arm.clear_alarms().await?;
            }
            Ok(arm.alarms().await?)
        })?;
        let list = List {
            alarms: entries(&alarms),
        };
        context.show(&list, |out| write(&list.alarms, self.clear, out))
    }
}

fn entries(alarms: &AlarmSet) -> Vec<Entry> {
    let entry = |code| {
        let alarm = Alarm::with_code(code);
        Entry {
            code,
            name: alarm.map(|alarm| alarm.name),
            cause: alarm.map(|alarm| alarm.cause),
            cure: alarm.map(|alarm| alarm.cure),
            holds_queue: Alarm::blocks(code),
        }
    };
    alarms.codes().map(entry).collect()
}

fn write(alarms: &[Entry], cleared: bool, out: &mut Output) -> Result<(), Failure> {
    if alarms.is_empty() {
        return out.line(if cleared {
            "cleared, no alarms"
        } else {
            "no alarms"
        });
    }
    let paint = out.paint;
    for alarm in alarms {
        let name = alarm.name.unwrap_or("unknown to this program");
        let title = format!("{:#04x} {name}", alarm.code);
        let holds = if alarm.holds_queue {
            "  holds the queue"
        } else {
            ""
        };
        out.line(format_args!("{}{holds}", paint.name(title)))?;
        if let (Some(cause), Some(cure)) = (alarm.cause, alarm.cure) {
            out.line(format_args!("     cause: {cause}"))?;
            out.line(format_args!("     cure:  {cure}"))?;
        }
    }
    if !cleared {
        note("`magician alarms --clear` clears them", out)?;
    }
    Ok(())
}
