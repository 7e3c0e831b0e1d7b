//! `alarms`: shows, explains and clears the alarms of the arm.

use clap::Args;
use magician::report::AlarmReport;
use magician_protocol::Alarm;

use crate::columns::note;
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;
use crate::output::Output;

/// Show the alarms with cause and remedy, or clear them
#[derive(Args, Debug)]
pub(crate) struct Alarms {
    /// Clear the alarms and release the queue
    #[arg(long)]
    clear: bool,
}

impl Alarms {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        if self.clear {
            context.permit_queue()?;
        }
        let (list, homed) = context.arm(StopPolicy::order_if(self.clear), async |arm, _| {
            let mut homed = true;
            if self.clear {
                // Alarm 0x00 is the only sign of an unhomed arm. Clearing removes it, so the state
                // is read before.
                homed = arm.is_virtual() || arm.homing().is_homed().await? != Some(false);
                arm.clear_alarms().await?;
            }
            Ok((AlarmReport::read(arm).await?, homed))
        })?;
        context.show(&list, |out| {
            write(&list, self.clear, out)?;
            if homed {
                Ok(())
            } else {
                note("the arm is still not homed: `magician home` homes it", out)
            }
        })
    }
}

fn write(list: &AlarmReport, cleared: bool, out: &mut Output) -> Result<(), Failure> {
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
        if let (Some(cause), Some(remedy)) = (alarm.cause, alarm.remedy) {
            out.line(format_args!("     cause: {cause}"))?;
            out.line(format_args!("     remedy: {remedy}"))?;
        }
    }
    if list.tool_unknown {
        note(Alarm::TOOL_UNKNOWN, out)?;
    }
    if !cleared {
        let only_reset = alarms
            .iter()
            .all(|alarm| alarm.code == Alarm::ResetOccurred);
        let remedy = if only_reset {
            "`magician home` homes the arm, which clears it"
        } else {
            "`magician alarms --clear` clears them"
        };
        note(remedy, out)?;
    }
    Ok(())
}
