//! A virtual arm for other programs: `serve [--pty PATH] [--udp HOST[:PORT]] [--tcp HOST:PORT]
//! [--speed X|max] [--baud N] [--turnaround-ms N] [--trace FILE]`. Prints `ready` when all of them
//! accept; Ctrl-C ends it.

use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;

use magician::serve::Server;
use magician_sim::{Controller, LineTiming, Profile, Speed};

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn std::error::Error>> {
    let mut server = Server::new(Controller::new(Profile::default()));
    let (mut speed, mut line) = (Speed::default(), LineTiming::default());
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let value = words
            .next()
            .ok_or_else(|| format!("{word} wants a value"))?;
        match word.as_str() {
            #[cfg(unix)]
            "--pty" => server = server.pty(value),
            "--udp" => server = server.udp(value),
            "--tcp" => server = server.tcp(value),
            "--speed" => speed = value.parse::<Speed>()?,
            "--baud" => line.baud = Some(value.parse()?),
            "--turnaround-ms" => line.turnaround = Duration::from_millis(value.parse()?),
            #[cfg(feature = "trace")]
            "--trace" => server = server.trace(magician::files::WholeFile::grow(value.as_ref())?),
            _ => return Err(format!("{word} is not known").into()),
        }
    }
    let server = server
        .speed(speed)
        .line(line)
        .on_ready(|endpoints| {
            for endpoint in endpoints {
                eprintln!("{endpoint}");
            }
            println!("ready");
            let _ = std::io::stdout().flush();
        })
        .on_notice(|notice| eprintln!("{notice:?}"));
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    Ok(runtime.block_on(server.serve_until(interrupted()))?)
}

/// Ready on Ctrl-C and, on systems that have it, SIGTERM.
async fn interrupted() {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        let (Ok(mut interrupt), Ok(mut terminate)) = (
            signal(SignalKind::interrupt()),
            signal(SignalKind::terminate()),
        ) else {
            return;
        };
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
        }
    }
    #[cfg(not(unix))]
    let _ = tokio::signal::ctrl_c().await;
}
