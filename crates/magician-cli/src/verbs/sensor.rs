//! `sensor`: reads the colour sensor and the infrared sensor at the arm's connectors.

use std::time::Duration;

use clap::{Args, ValueEnum};
use magician::Arm;
use magician::build::{self, Color, Sensed};
use magician::commands::{ColorSensor, IrSwitch};
use magician_protocol::{Port, SensorVersion};
use serde::Serialize;
use tokio::time::{MissedTickBehavior, interval};

use super::pose::rate;
use crate::context::{Context, StopPolicy};
use crate::failure::Failure;

/// Switch a sensor on and read it
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician sensor color gp2
  magician sensor infrared gp4 --watch
Levels and voltages of pins: `magician io`.")]
pub(crate) struct Sensor {
    /// Kind of sensor
    kind: SensorKind,
    /// Connector that the sensor is plugged into
    connector: Connector,
    /// Read the sensor continuously until Ctrl-C
    #[arg(long)]
    watch: bool,
    /// With --watch: readings per second, 0.01 to 1000
    #[arg(long, value_name = "HZ", default_value_t = 5.0, requires = "watch", value_parser = rate)]
    rate: f64,
    /// Switch the sensor off instead of reading it
    #[arg(long, conflicts_with = "watch")]
    off: bool,
    /// Generation of the sensor, 1 or 2
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=2))]
    version: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SensorKind {
    /// Distinguishes red, green and blue
    #[value(alias = "colour")]
    Color,
    /// Detects an object in front of it
    #[value(alias = "ir")]
    Infrared,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "UPPERCASE")]
enum Connector {
    /// At the base
    Gp1,
    /// At the base
    Gp2,
    /// On the forearm
    Gp4,
    /// On the forearm
    Gp5,
}

impl From<Connector> for Port {
    fn from(connector: Connector) -> Self {
        match connector {
            Connector::Gp1 => Self::Gp1,
            Connector::Gp2 => Self::Gp2,
            Connector::Gp4 => Self::Gp4,
            Connector::Gp5 => Self::Gp5,
        }
    }
}

/// Reading of a sensor.
#[derive(Serialize)]
#[serde(untagged)]
enum SensorReading {
    Color {
        port: Connector,
        r: u8,
        g: u8,
        b: u8,
        color: Option<&'static str>,
    },
    Infrared {
        port: Connector,
        blocked: bool,
    },
    Off {
        port: Connector,
        on: bool,
    },
}

impl Sensor {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let json = context.global.json;
        context.arm(StopPolicy::Order, async |arm, out| {
            self.switch(arm).await?;
            let mut ticks = interval(Duration::from_secs_f64(1.0 / self.rate));
            ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
            loop {
                ticks.tick().await;
                let seen = self.read_sensor(arm).await?;
                if json {
                    out.json(&seen)?;
                } else {
                    out.line(seen.line())?;
                }
                out.flush()?;
                if !self.watch {
                    return Ok(());
                }
            }
        })
    }

    async fn switch(&self, arm: &Arm) -> Result<(), Failure> {
        let version = SensorVersion::from(self.version.saturating_sub(1));
        let (port, on) = (self.connector.into(), !self.off);
        let command = match self.kind {
            SensorKind::Color => build::color_sensor(port, on, version),
            SensorKind::Infrared => build::infrared(port, on, version),
        };
        Ok(arm.set_any(&command).await?)
    }

    async fn read_sensor(&self, arm: &Arm) -> Result<SensorReading, Failure> {
        let port = self.connector;
        if self.off {
            return Ok(SensorReading::Off { port, on: false });
        }
        Ok(match self.kind {
            SensorKind::Color => {
                let query = build::color_at(port.into());
                let seen = arm.get_with::<ColorSensor>(&query).await?;
                let color = seen.sensed().map(|color| match color {
                    Color::Red => "red",
                    Color::Green => "green",
                    Color::Blue => "blue",
                });
                let ColorSensor { r, g, b } = seen;
                SensorReading::Color {
                    port,
                    r,
                    g,
                    b,
                    color,
                }
            }
            SensorKind::Infrared => {
                let query = build::infrared_at(port.into());
                let blocked = arm.get_with::<IrSwitch>(&query).await?.sensed();
                SensorReading::Infrared { port, blocked }
            }
        })
    }
}

impl SensorReading {
    fn line(&self) -> String {
        match self {
            Self::Color { r, g, b, color, .. } => {
                let color = color.unwrap_or("no dominant colour");
                format!("{color} (red {r}, green {g}, blue {b})")
            }
            Self::Infrared { blocked: true, .. } => "object detected".to_owned(),
            Self::Infrared { blocked: false, .. } => "no object".to_owned(),
            Self::Off { .. } => "switched off".to_owned(),
        }
    }
}
