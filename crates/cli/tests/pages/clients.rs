//! As much of `mbpoll` and `jq` as pages use, so that the tests need no foreign program. The scripts in `.ci/foreign`
//! run the real `mbpoll`.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// Nobody types faster: a cycle of the ring and a service are over by then.
pub(crate) const PAUSE: Duration = Duration::from_millis(200);

/// The registers that are read, as `mbpoll` prints them; nothing for a write.
pub(crate) fn mbpoll(command: &str, address: impl Fn(&str) -> String) -> Vec<String> {
    let words: Vec<&str> = command.split_whitespace().skip(1).collect();
    let option = |name: &str| words.iter().position(|word| *word == name).map(|at| words[at + 1]);
    let host = words.iter().position(|word| *word == "127.0.0.1").expect("a host");
    let first: u16 = option("-r").expect("-r").parse().unwrap();
    let values: Vec<u16> =
        words[host + 1..].iter().map(|word| u16::from_str_radix(&word[2..], 16).unwrap()).collect();
    std::thread::sleep(PAUSE);
    let mut stream = TcpStream::connect(address(option("-p").expect("-p"))).unwrap();
    let (from, count) = ((first - 1).to_be_bytes(), option("-c").unwrap_or("1").parse::<u16>().unwrap());
    if !values.is_empty() {
        let size = u8::try_from(values.len()).unwrap();
        let mut request = vec![16, from[0], from[1], 0, size, 2 * size];
        request.extend(values.iter().flat_map(|value| value.to_be_bytes()));
        assert_eq!(asked(&mut stream, &request)[0], 16, "{command}");
        return Vec::new();
    }
    let function = if option("-t").expect("-t").starts_with('3') { 4 } else { 3 };
    let [high, low] = count.to_be_bytes();
    let answer = asked(&mut stream, &[function, from[0], from[1], high, low]);
    assert_eq!(answer[0], function, "{command}");
    let registers = answer[2..].chunks(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]]));
    (first..).zip(registers).map(|(number, value)| format!("[{number}]: \t0x{value:04X}")).collect()
}

/// Function and data of the answer to a request.
fn asked(stream: &mut TcpStream, request: &[u8]) -> Vec<u8> {
    let mut frame = vec![0, 1, 0, 0, 0, u8::try_from(request.len() + 1).unwrap(), 1];
    frame.extend(request);
    stream.write_all(&frame).unwrap();
    let mut head = [0; 7];
    stream.read_exact(&mut head).unwrap();
    let mut answer = vec![0; usize::from(head[5]) - 1];
    stream.read_exact(&mut answer).unwrap();
    answer
}

/// What `jq` shows of one object: paths, several with commas between them, all below one that stands before a `|`.
pub(crate) fn jq(filter: &str, answer: &str) -> String {
    let object: serde_json::Value = serde_json::from_str(answer).unwrap();
    let filter = filter.strip_prefix("-c ").unwrap_or(filter).trim_matches('\'');
    let (below, paths) = filter.split_once(" | ").unwrap_or(("", filter));
    let shown = paths.split(", ").map(|path| {
        let pointer = format!("{below}{path}").replace('[', ".").replace(']', "").replace('.', "/");
        format!("{}\n", object.pointer(&pointer).unwrap_or(&serde_json::Value::Null))
    });
    shown.collect()
}
