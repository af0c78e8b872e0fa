//! What is told of a whole ring: `scan` and `ring cycle-time`.

use std::io::{Read, Write};
use std::net::TcpListener;

use super::{Run, encoring, refused};

fn run(arguments: &str) -> Run {
    encoring(&arguments.split(' ').collect::<Vec<_>>(), b"")
}

fn json(arguments: &str, code: i32) -> serde_json::Value {
    let Run { code: ended, out, err } = run(&format!("{arguments} --format json"));
    assert_eq!(ended, Some(code), "{arguments}: {out}{err}");
    serde_json::from_str(&out).unwrap()
}

/// A coupler that answers function 3 with these registers from 1400 on, once; its address.
fn coupler(directory: &'static [u16]) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    std::thread::spawn(move || {
        let (mut peer, _) = listener.accept().unwrap();
        let mut request = [0; 12];
        while peer.read_exact(&mut request).is_ok() {
            assert_eq!(request[7], 3, "only read");
            let first = usize::from(u16::from_be_bytes([request[8], request[9]])) - 1400;
            let count = usize::from(u16::from_be_bytes([request[10], request[11]]));
            let data: Vec<u8> =
                (first..first + count).flat_map(|k| directory.get(k).unwrap_or(&0).to_be_bytes()).collect();
            let mut answer = request[..4].to_vec();
            answer.extend((data.len() as u16 + 3).to_be_bytes());
            answer.extend([request[6], 3, data.len() as u8]);
            answer.extend(data);
            peer.write_all(&answer).unwrap();
        }
    });
    format!("modbus-tcp://{address}?layout=inline")
}

// [R2]
#[test]
fn a_whole_ring_is_listed_with_idents_addresses_and_lamps() {
    let found = run("scan --bus sim");
    assert_eq!((found.code, found.err.as_str()), (Some(0), ""));
    insta::assert_snapshot!(found.out);
}

#[test]
fn a_ring_that_ends_early_is_told_with_place_and_registers() {
    for (name, fault) in [
        ("jumper_missing", "jumper:1"),
        ("another_device", "ident=0303:2"),
        ("without_supply", "supply:1"),
        ("bad_segment", "bad:1"),
    ] {
        let found = run(&format!("scan --bus sim --fault {fault}"));
        assert_eq!((found.code, found.err.as_str()), (Some(1), ""), "{fault}");
        insta::assert_snapshot!(format!("scan_{name}"), found.out);
    }
    let nobody = json("scan --bus sim --fault silent:0", 3);
    assert_eq!(nobody["result"], "no_answer");
    assert_eq!(nobody["master"]["parameter_hex"], "0BE1");
    assert_eq!(nobody["warnings"].as_array().unwrap().len(), 0);
}

#[test]
fn a_coupler_lists_its_directory() {
    // The count, a digital output of one word, an encoder, two bits in.
    let bus = coupler(&[3, 0x0101, 0x0233, 0x0D02]);
    let found = json(&format!("scan --bus {bus}"), 0);
    assert_eq!((found["result"].as_str(), found["found"].as_u64()), (Some("directory"), Some(3)));
    let devices = &found["devices"];
    assert_eq!(devices[0]["ident"]["meaning"], "digital, OUT");
    assert_eq!(devices[1]["ident"]["code"], 51);
    // One word of digital input takes none before it; OUT data follow all IN data.
    assert_eq!(devices[1]["in"], serde_json::json!([8000, 8001]));
    assert_eq!(devices[1]["out"], serde_json::json!([8004, 8005]));
    assert_eq!((&devices[2]["ident"]["bits"], &devices[2]["ident"]["words"]), (&2.into(), &1.into()));
    assert!(found["master"].is_null() && found["configured"].is_null());
    assert!(found["warnings"][0].as_str().unwrap().starts_with("ident code 51 (33h)"));
}

#[test]
fn a_plain_gateway_does_not_tell_and_points_to_probe() {
    let bus = "modbus-tcp://127.0.0.1:1?unit=3";
    let Run { code, out, err } = run(&format!("scan --bus {bus}"));
    assert_eq!((code, out.as_str()), (Some(3), ""));
    assert!(err.contains("`encoring probe modbus-tcp://127.0.0.1:1`"), "{err}");
    let gone = run("scan --bus modbus-tcp://127.0.0.1:1?layout=inline");
    assert_eq!((gone.code, gone.out.as_str()), (Some(3), ""), "{}", gone.err);
}

#[test]
fn a_scan_that_cannot_be_made_is_refused() {
    refused(
        &["scan", "--bus", "ring"],
        b"",
        "error: --bus ring: bus address, column 1: \"ring\" begins with none of modbus-tcp://, modbus-rtu: and modbus-rtu-tcp://; or sim, or \
         sim:SCENARIO.toml",
    );
    refused(
        &["scan", "--bus", "modbus-tcp://127.0.0.1:1", "--fault", "bad"],
        b"",
        "error: --fault works on a simulated ring only; leave it out",
    );
    refused(
        &["scan", "--bus", "sim", "--fault", "jumper:3"],
        b"",
        "error: --fault jumper:3: position 3; the positions are 0 to 2",
    );
}

#[test]
fn the_worked_cycles_are_computed() {
    for (size, nanos) in [
        ("--encoders 1", 463_000),
        ("--bytes 4 --devices 1 --kbit 2000", 265_750),
        ("--encoders 2", 570_000),
        ("--encoders 3", 677_000),
        ("--bytes 40 --devices 10", 1_426_000),
        ("--encoders 10 --cable-m 1000", 1_442_000),
        ("--encoders 128", 14_052_000),
        ("--encoders 1 --software-us 0", 263_000),
    ] {
        assert_eq!(json(&format!("ring cycle-time {size}"), 0)["cycle_ns"], nanos, "{size}");
    }
    insta::assert_snapshot!(run("ring cycle-time --encoders 10 --cable-m 1000 --kbit 2000").out);
}

#[test]
fn no_ring_is_larger_than_rings_are() {
    for (size, message) in [
        (
            "--encoders 129",
            "--encoders 129; allowed are 1 to 128: an encoder has 32 of the 4096 I/O points of a ring",
        ),
        (
            "--encoders 0",
            "--encoders 0; allowed are 1 to 128: an encoder has 32 of the 4096 I/O points of a ring",
        ),
        ("--bytes 513 --devices 1", "--bytes 513; allowed are 0 to 512: a ring has 4096 I/O points"),
        (
            "--bytes 4 --devices 255",
            "--devices 255; allowed are 1 to 254: a ring has 512 devices, 254 of them on the remote bus, and the \
             formula counts these",
        ),
        ("--encoders 1 --cable-m 12801", "--cable-m 12801; allowed are 0 to 12800: metres of remote bus"),
        (
            "--encoders 1 --software-us 1000001",
            "--software-us 1000001; allowed are 0 to 1000000: a second is no cycle any more",
        ),
        ("--bytes 4", "the size of the ring is missing: give --encoders N, or --bytes N with --devices M"),
    ] {
        let arguments: Vec<&str> = ["ring", "cycle-time"].into_iter().chain(size.split(' ')).collect();
        refused(&arguments, b"", &format!("error: {message}"));
    }
}
