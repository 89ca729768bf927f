//! Whether a viewer is there, and starting one.

use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, TcpStream, ToSocketAddrs};
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::Error;
use crate::input::Stop;

/// Where viewers listen unless they are told otherwise.
pub(super) const PORT: u16 = 9876;

/// How often, and how many times at most, a viewer that starts is asked whether it is there: half a minute.
const INTERVAL: Duration = Duration::from_millis(100);
const TIMES: usize = 300;

/// How long a viewer that runs may take to answer.
const ANSWER: Duration = Duration::from_secs(5);

/// Whether anybody listens there.
pub(super) fn reach(host: &str, port: u16) -> io::Result<()> {
    let mut outcome = Err(ErrorKind::AddrNotAvailable.into());
    for address in format!("{host}:{port}").to_socket_addrs()? {
        outcome = TcpStream::connect_timeout(&address, ANSWER).map(drop);
        if outcome.is_ok() {
            break;
        }
    }
    outcome
}

/// Starts the viewer `program` and waits until it listens at `port`. Where somebody listens there already, that is taken
/// for a viewer. It outlives this process, and an interrupt at the terminal does not reach it.
///
/// # Errors
/// `Content` where the program is not found or ends, `Interrupted`.
pub(super) fn start(program: &str, port: u16, stop: &Stop) -> Result<(), Error> {
    let fails = |reason: String| Error::Content { path: program.into(), reason };
    let listens = || reach(&Ipv4Addr::LOCALHOST.to_string(), port).is_ok();
    if listens() {
        return Ok(());
    }
    let mut command = Command::new(program);
    // Results go to stdout, they alone.
    command.args(["--port", &port.to_string(), "--expect-data-soon"]).stdin(Stdio::null()).stdout(Stdio::null());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let mut viewer = command.spawn().map_err(|cause| match cause.kind() {
        ErrorKind::NotFound => fails(
            "there is no such program among the commands (PATH): install the rerun viewer, or give the address of one \
             that runs, or a file that ends in .rrd"
                .to_owned(),
        ),
        _ => fails(format!("the viewer does not start: {cause}")),
    })?;
    for _ in 0..TIMES {
        if listens() {
            return Ok(());
        }
        if let Ok(Some(status)) = viewer.try_wait() {
            return Err(fails(format!("the viewer ended at once ({status}); its own words stand above")));
        }
        if stop.is_raised() {
            return Err(Error::Interrupted);
        }
        std::thread::sleep(INTERVAL);
    }
    Err(fails(format!("the viewer was started, but does not listen at port {port}")))
}

#[cfg(all(test, unix))]
mod tests {
    use std::net::TcpListener;

    use super::*;

    /// A port where nobody listens.
    fn free() -> u16 {
        TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap().local_addr().unwrap().port()
    }

    #[test]
    fn what_hinders_a_viewer_is_told() {
        let error = start("no-such-viewer", free(), &Stop::default()).unwrap_err();
        assert!(error.to_string().contains("no-such-viewer: there is no such program"), "{error}");
        // It ends with 1 whatever the arguments are.
        let error = start("false", free(), &Stop::default()).unwrap_err();
        assert!(error.to_string().contains("ended at once (exit status: 1)"), "{error}");
    }

    #[test]
    fn one_that_runs_is_enough() {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        start("no-such-viewer", listener.local_addr().unwrap().port(), &Stop::default()).unwrap();
    }
}
