//! The page in the browser: where it listens, whether it is there at all, and what it may do.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, ToSocketAddrs};
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use encoring_dashboard::{ServedPage, WebOptions, WebToken};
use encoring_files::read_text;
use encoring_station::{Permission, ShownRing, Speed};

use crate::output::{Failure, bad_input, note};

/// Where the page listens unless told otherwise.
const WEB_DEFAULT: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 8051);

/// The longest file of a token.
const TOKEN_FILE_BYTES_MAX: u64 = 4_096;

/// Who reaches the page, and what they may do.
#[derive(Args, Debug)]
pub(crate) struct WebAccess {
    /// Further host name of the page, such as that of a proxy (repeatable)
    #[arg(long = "web-host", value_name = "NAME")]
    hosts: Vec<String>,
    /// File with the token that the page asks for; needed where others reach the page
    #[arg(long = "web-token-file", value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// Let the page change something where it only shows otherwise: on a real ring, and on an address that others reach
    #[arg(long)]
    pub(crate) allow_control: bool,
}

/// What the page shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Nature {
    /// Nothing of it can move a machine.
    Simulated,
    /// A ring with encoders.
    Real,
}

/// An address to listen on; `None` for `off`.
#[expect(clippy::disallowed_methods, reason = "a port, not a value of an encoder")]
pub(crate) fn listening_address(option: &str, text: &str) -> Result<Option<SocketAddr>, Failure> {
    if text == "off" {
        return Ok(None);
    }
    if let Ok(port) = text.parse::<u16>() {
        return Ok(Some(SocketAddr::from((Ipv4Addr::LOCALHOST, port))));
    }
    let found = text.to_socket_addrs().ok().and_then(|mut addresses| addresses.next());
    let wrong = || bad_input(format!("{option} {text}: no address; write HOST:PORT, PORT or off"));
    found.map(Some).ok_or_else(wrong)
}

impl WebAccess {
    /// What the server allows that listens there.
    pub(crate) fn options(&self, address: Option<SocketAddr>, nature: Nature) -> Result<WebOptions, Failure> {
        let token = self.token()?;
        let is_local = address.is_none_or(|address| address.ip().to_canonical().is_loopback());
        if let (false, Some(address)) = (is_local, address) {
            if token.is_none() {
                return Err(bad_input(format!(
                    "--web: others reach {}, so the page must ask for a token; name its file with --web-token-file \
                     FILE, or name 127.0.0.1",
                    address.ip()
                )));
            }
            note(&format!(
                "note: web {address} can be reached from the network, and nothing is encrypted: whoever reads along can take \
                 the token"
            ));
        }
        let may_change = self.allow_control || nature == Nature::Simulated && is_local;
        let permission = if may_change { Permission::Change } else { Permission::Look };
        Ok(WebOptions { hosts: self.hosts.clone(), permission, token, ..WebOptions::default() })
    }

    #[expect(clippy::disallowed_methods, reason = "a token, not a value of an encoder")]
    fn token(&self) -> Result<Option<WebToken>, Failure> {
        let Some(file) = &self.token_file else { return Ok(None) };
        let wrong = |why: String| bad_input(format!("--web-token-file {}: {why}", file.display()));
        let text = read_text(file, TOKEN_FILE_BYTES_MAX).map_err(|error| wrong(error.to_string()))?;
        let token = text.trim_end_matches(['\r', '\n']).parse();
        token.map(Some).map_err(|error: encoring_dashboard::NotAToken| wrong(error.to_string()))
    }
}

/// The page's listener, if there is to be a page.
pub(crate) enum Page {
    /// There is to be none.
    Off,
    /// Nobody asked for one, and its usual port is taken.
    Taken,
    /// It is served here.
    On(TcpListener),
}

impl Page {
    /// That beside something else. Asked for by nobody it is left out where its port is taken, and where a ring runs as
    /// fast as it can.
    pub(crate) fn beside(asked: Option<&str>, speed: Speed) -> Result<Self, Failure> {
        match asked {
            Some(text) => Self::asked(text),
            None => Ok(match (speed, TcpListener::bind(WEB_DEFAULT)) {
                (Speed::Max, _) => Self::Off,
                (_, Ok(listener)) => Self::On(listener),
                (_, Err(_)) => Self::Taken,
            }),
        }
    }

    /// That for whose sake a command runs.
    pub(crate) fn alone(asked: Option<&str>) -> Result<Self, Failure> {
        match asked {
            Some("off") => Err(bad_input("--web off: without the page there is nothing to serve")),
            Some(text) => Self::asked(text),
            None => Self::bound(WEB_DEFAULT),
        }
    }

    fn asked(text: &str) -> Result<Self, Failure> {
        listening_address("--web", text)?.map_or(Ok(Self::Off), Self::bound)
    }

    fn bound(address: SocketAddr) -> Result<Self, Failure> {
        TcpListener::bind(address).map(Self::On).map_err(|cause| match cause.kind() {
            io::ErrorKind::AddrInUse => {
                bad_input(format!("--web {address}: the port is in use; choose another, or 0 for any"))
            }
            _ => bad_input(format!("--web {address}: {cause}")),
        })
    }

    /// Where it is served.
    pub(crate) fn address(&self) -> io::Result<Option<SocketAddr>> {
        match self {
            Self::On(listener) => listener.local_addr().map(Some),
            Self::Off | Self::Taken => Ok(None),
        }
    }

    /// Serves it until what this gives is dropped; says why there is none.
    pub(crate) fn serve(
        self,
        ring: Arc<dyn ShownRing>,
        options: &WebOptions,
    ) -> io::Result<Option<ServedPage>> {
        match self {
            Self::On(listener) => encoring_dashboard::start(listener, ring, options).map(Some),
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
