//! The page in the browser: where it listens, and whether it is there at all.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};

use encoring_dashboard::{ServedPage, WebOptions};
use encoring_station::{Controlled, Speed};

use super::address;
use crate::output::{Failure, bad_input, note};

/// Where the page listens unless told otherwise.
const WEB_DEFAULT: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 8051);

/// The page's listener, if there shall be a page.
pub(super) enum Page {
    /// There shall be none.
    Off,
    /// Nobody asked for one, and its usual port is taken.
    Taken,
    /// It is served here.
    On(TcpListener),
}

/// The page's listener. Asked for by nobody it is left out where its port is taken, and where a ring runs as fast as
/// it can.
pub(super) fn listen(asked: Option<&str>, speed: Speed) -> Result<Page, Failure> {
    let Some(text) = asked else {
        return Ok(match (speed, TcpListener::bind(WEB_DEFAULT)) {
            (Speed::Max, _) => Page::Off,
            (_, Ok(listener)) => Page::On(listener),
            (_, Err(_)) => Page::Taken,
        });
    };
    let Some(address) = address("--web", text)? else { return Ok(Page::Off) };
    if !address.ip().to_canonical().is_loopback() {
        return Err(bad_input(format!(
            "--web {address}: the page asks nobody for a password, so it is served to this machine only; name 127.0.0.1"
        )));
    }
    TcpListener::bind(address).map(Page::On).map_err(|cause| match cause.kind() {
        io::ErrorKind::AddrInUse => {
            bad_input(format!("--web {address}: the port is in use; choose another, or 0 for any"))
        }
        _ => bad_input(format!("--web {address}: {cause}")),
    })
}

impl Page {
    /// Where it is served.
    pub(super) fn local_addr(&self) -> Option<io::Result<SocketAddr>> {
        match self {
            Self::On(listener) => Some(listener.local_addr()),
            Self::Off | Self::Taken => None,
        }
    }

    /// Serves it until what this gives is dropped; says why there is none.
    pub(super) fn serve(self, controlled: Controlled, hosts: &[String]) -> io::Result<Option<ServedPage>> {
        match self {
            Self::On(listener) => {
                let options = WebOptions { hosts: hosts.to_vec(), ..WebOptions::default() };
                encoring_dashboard::start(listener, controlled, &options).map(Some)
            }
            Self::Off => Ok(None),
            Self::Taken => {
                note(&format!(
                    "note: no page in the browser: {WEB_DEFAULT} is in use; --web PORT names another, --web off none"
                ));
                Ok(None)
            }
        }
    }
}
