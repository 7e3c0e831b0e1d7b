use clap::Args;
use magician_protocol::{Alarm, AlarmSet};
use serde::Serialize;

use crate::columns::note;
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::output::Output;

/// Show the alarms with cause and remedy, or clear them
#[derive(Args, Debug)]
pub(crate) struct Alarms {
    /// Clear the alarms, which also releases the queue
    #[arg(long)]
    clear: bool,
}

#[derive(Serialize)]
struct List {
    alarms: Vec<Entry>,
    /// A pose was out of reach, and the arm was never told of a tool.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    tool_unknown: bool,
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
        let (alarms, tool_unknown) =
            context.arm(StopPolicy::order_if(self.clear), async |arm, _| {
                if self.clear {
                    arm.clear_alarms().await?;
                }
                let alarms = arm.alarms().await?;
                let tool_unknown = arm.tool_is_unknown(&alarms).await?;
                Ok((alarms, tool_unknown))
            })?;
        let list = List {
            alarms: entries(&alarms),
            tool_unknown,
        };
        context.show(&list, |out| write(&list, self.clear, out))
    }
}

fn entries(alarms: &AlarmSet) -> Vec<Entry> {
    let entry = |code| {
        let alarm = Alarm::with_code(code);
        Entry {
            code,
            name: alarm.map(|alarm| alarm.name),
            cause: alarm.map(|alarm| alarm.cause),
            cure: alarm.map(|alarm| alarm.remedy),
            holds_queue: Alarm::blocks(code),
        }
    };
    alarms.codes().map(entry).collect()
}

fn write(list: &List, cleared: bool, out: &mut Output) -> Result<(), Failure> {
    let alarms = &list.alarms;
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
            out.line(format_args!("     remedy: {cure}"))?;
        }
    }
    if list.tool_unknown {
        note(Alarm::TOOL_UNKNOWN, out)?;
    }
    if !cleared {
        note("`magician alarms --clear` clears them", out)?;
    }
    Ok(())
}
