//! Somebody who types what a page shows: in a folder of their own, with a terminal for the ring that stays.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::clients;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// The address that `sim` serves Modbus at if nothing else is said.
const MODBUS: &str = "127.0.0.1:5020";

/// Where the page listens unless told otherwise.
const WEB: &str = "127.0.0.1:8051";

/// A ring that runs until the reader ends.
struct Ring {
    program: Child,
    /// The addresses on the page, and those that it has got.
    addresses: Vec<(String, String)>,
}

impl Drop for Ring {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

pub(crate) struct Reader {
    folder: tempfile::TempDir,
    ring: Option<Ring>,
}

impl Reader {
    /// With the folders of the repository that pages name.
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        for name in ["crates", "vectors"] {
            symlink(Path::new(ROOT).join(name), folder.path().join(name)).unwrap();
        }
        std::fs::create_dir_all(folder.path().join("docs/ssi")).unwrap();
        Self { folder, ring: None }
    }

    /// Whether what was typed succeeded, and the lines that it printed.
    pub(crate) fn types(&mut self, command: &str) -> (bool, Vec<String>) {
        let command = command.replace("cargo run --release -- ", "encoring ");
        if stays(&command) {
            return (true, self.starts(&command));
        }
        if command.starts_with("mbpoll ") {
            return (true, clients::mbpoll(&command, |port| self.address(&format!("127.0.0.1:{port}"))));
        }
        let (ok, text) = match command.split_once(" | nc ") {
            Some((said, rest)) => self.nc(said, rest),
            None => self.run(&self.translated(&command)),
        };
        let text = self.addresses().fold(text, |text, (page, real)| text.replace(real, page));
        (ok, text.lines().map(str::to_owned).collect())
    }

    /// Ends the ring that stays, as Ctrl-C does, and says its exit code.
    #[allow(dead_code, reason = "the test of the help uses the reader too, and ends no ring")]
    pub(crate) fn ends_ring(&mut self) -> Option<i32> {
        let mut ring = self.ring.take()?;
        let pid = ring.program.id().to_string();
        // One that has ended by itself is gone.
        let _ = Command::new("kill").args(["-INT", &pid]).output().unwrap();
        ring.program.wait().unwrap().code()
    }

    fn addresses(&self) -> impl Iterator<Item = &(String, String)> {
        self.ring.iter().flat_map(|ring| &ring.addresses)
    }

    fn address(&self, page: &str) -> String {
        let found = self.addresses().find(|(address, _)| address == page);
        found.unwrap_or_else(|| panic!("nothing on this page serves {page}")).1.clone()
    }

    fn translated(&self, command: &str) -> String {
        self.addresses().fold(command.to_owned(), |text, (page, real)| text.replace(page, real))
    }

    fn command(&self, line: &str) -> Command {
        let folder = Path::new(env!("CARGO_BIN_EXE_encoring")).parent().unwrap();
        let path = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap());
        let mut command = Command::new("bash");
        command.args(["-c", line]).current_dir(self.folder.path()).env("PATH", path);
        command.env("HOME", self.folder.path()).env("XDG_STATE_HOME", self.folder.path().join("states"));
        command.stdin(Stdio::null());
        command
    }

    fn run(&self, line: &str) -> (bool, String) {
        let output = self.command(&format!("{{ {line}\n}} 2>&1")).output().unwrap();
        (output.status.success(), String::from_utf8(output.stdout).unwrap())
    }

    /// Sends what a command prints to a port of the ring, as `nc` does, and shows what `jq` would of the answer.
    fn nc(&self, said: &str, rest: &str) -> (bool, String) {
        let (target, filter) = rest.split_once(" | jq ").unwrap_or((rest, ""));
        let words: Vec<&str> = target.split(' ').collect();
        let ["-N", host, port] = words[..] else { panic!("nc {target}") };
        std::thread::sleep(clients::PAUSE);
        let mut stream = TcpStream::connect(self.address(&format!("{host}:{port}"))).unwrap();
        let (ok, said) = self.run(said);
        stream.write_all(said.as_bytes()).unwrap();
        stream.shutdown(Shutdown::Write).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        (ok, if filter.is_empty() { answer } else { clients::jq(filter, &answer) })
    }

    /// Starts the ring that stays; one that runs already is ended before.
    fn starts(&mut self, command: &str) -> Vec<String> {
        self.ring = None;
        let word_after = |option: &str| {
            let mut words = command.split(' ').skip_while(|word| *word != option);
            words.nth(1).map(str::to_owned)
        };
        let control = word_after("--control");
        let modbus = word_after("--modbus").unwrap_or_else(|| MODBUS.to_owned());
        // As fast as it can a ring has no page unless it is asked for.
        let usual = (!command.contains("--speed max")).then(|| WEB.to_owned());
        let web = word_after("--web").or(usual).filter(|page| page != "off");
        let mut line = command.to_owned();
        for address in [Some(&modbus), control.as_ref(), web.as_ref()]
            .into_iter()
            .flatten()
            .filter(|page| *page != "off")
        {
            line = line.replace(address.as_str(), "127.0.0.1:0");
        }
        if !line.contains("--modbus") {
            line.push_str(" --modbus 127.0.0.1:0");
        }
        if !line.contains("--web") {
            line.push_str(if web.is_some() { " --web 127.0.0.1:0" } else { " --web off" });
        }
        let mut program = self.command(&format!("exec {line} 2>&1")).stdout(Stdio::piped()).spawn().unwrap();
        let from = program.stdout.take().unwrap();
        let mut ring = Ring { program, addresses: Vec::new() };
        let last = match (&web, &control) {
            (Some(_), _) => "web ",
            (None, Some(_)) => "control ",
            (None, None) => "modbus ",
        };
        let mut printed = Vec::new();
        let mut lines = BufReader::new(from).lines();
        while let Some(Ok(line)) = lines.next() {
            let served = [("modbus ", Some(&modbus)), ("control ", control.as_ref()), ("web ", web.as_ref())];
            let page = served.into_iter().find_map(|(name, page)| Some((line.strip_prefix(name)?, page?)));
            if let Some((real, page)) = page {
                ring.addresses.push((page.clone(), real.to_owned()));
            }
            printed.push(page.map_or(line.clone(), |(real, page)| line.replace(real, page)));
            if line.starts_with(last) {
                break;
            }
        }
        // What else it says goes nowhere, and the pipe never fills.
        std::thread::spawn(move || lines.for_each(drop));
        self.ring = Some(ring);
        printed
    }
}

/// `true` for a ring that runs until somebody ends it.
pub(crate) fn stays(command: &str) -> bool {
    command.starts_with("encoring sim")
        && !["--for", "--example", "--help"].iter().any(|end| command.contains(end))
}
