//! Recordings of the line: a decoder written here, beside the ring's own, finds the same words in them.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use std::collections::BTreeMap;
use std::io::Cursor;

use common::{Ring, SERVICE_BIT, line, scenario, set, three};
use encoring_ring::Verdict;
use encoring_sim::{Shown, Waveform};
use encoring_trace::wave::Format;
use encoring_trace::{Input, Row};

/// A signal's changes: when, and to what.
type Changes = Vec<(u64, String)>;

/// A ring with a recording under way.
struct Bench {
    ring: Ring,
    waveform: Waveform<Cursor<Vec<u8>>>,
}

impl Bench {
    fn new(text: &str, format: Format) -> Self {
        Self::showing(text, format, Shown::Lines)
    }

    fn showing(text: &str, format: Format, shown: Shown) -> Self {
        let mut ring = Ring::of(&scenario(text));
        let sink = Cursor::new(Vec::new());
        let waveform = Waveform::new(format, sink, "tests", &mut ring.world, shown).unwrap();
        Self { ring, waveform }
    }

    fn cycle(&mut self) -> Verdict {
        let cycled = self.ring.cycle();
        self.waveform.cycled(&mut self.ring.world, &cycled).unwrap();
        cycled.verdict
    }

    fn run_to_ms(&mut self, ms: f64) {
        while (self.ring.world.now().as_nanos() as f64) < ms * 1e6 {
            self.cycle();
        }
    }

    /// Every exchange, and what a foreign reader finds in the file.
    fn end(self) -> (Vec<Row>, BTreeMap<String, Changes>) {
        (self.ring.rows, read(self.waveform.finish().unwrap().into_inner()))
    }
}

fn read(file: Vec<u8>) -> BTreeMap<String, Changes> {
    let mut wave = wellen::simple::read_from_reader(Cursor::new(file)).unwrap();
    let hierarchy = wave.hierarchy();
    let vars: Vec<_> = hierarchy
        .all_vars()
        .map(|var| (hierarchy[var].full_name(hierarchy), hierarchy[var].signal_ref()))
        .collect();
    wave.load_signals(&vars.iter().map(|(_, id)| *id).collect::<Vec<_>>());
    let changes = |id| {
        let signal = wave.get_signal(id).unwrap();
        let at = |index| wave.time_table()[index as usize];
        signal.iter_changes().map(|(index, value)| (at(index), value.to_bit_string().unwrap())).collect()
    };
    vars.iter().map(|(name, id)| (name.strip_prefix("encoring.").unwrap().to_owned(), changes(*id))).collect()
}

/// What a signal shows at `at`.
fn shown(changes: &Changes, at: u64) -> &str {
    &changes[changes.partition_point(|change| change.0 <= at) - 1].1
}

fn number(text: &str) -> u32 {
    u32::from_str_radix(text, 2).unwrap()
}

/// A frame as it stands on a segment.
struct Frame {
    began: u64,
    is_id: bool,
    data: Vec<u8>,
    /// Check word and end word; nothing if the master broke the frame off.
    check: Vec<u8>,
}

/// Reads a line as docs/assumptions.md has it: start 0, SL, CR, FL; with FL = 1 eight bits, the highest first; stop 1.
fn frames(line: &Changes, bit: u64) -> Vec<Frame> {
    let end = line.last().unwrap().0;
    let (mut frames, mut open) = (Vec::new(), None::<(u64, bool, Vec<(bool, u8)>)>);
    let mut at = 0;
    while at < end {
        // A receiver looks at the middle of a bit.
        let level = |k: u64| shown(line, at + k * bit + bit / 2) == "1";
        if level(0) {
            at = line[line.partition_point(|change| change.0 <= at + bit / 2)].0;
            continue;
        }
        let (sl, cr, fl) = (level(1), level(2), level(3));
        if fl {
            let byte = (4..12).fold(0, |byte, k| byte << 1 | u8::from(level(k)));
            assert!(level(12), "no stop bit at {at}");
            open.get_or_insert((at, sl, Vec::new())).2.push((cr, byte));
            at += 13 * bit;
        } else {
            assert!(!sl && !cr && level(4), "no status telegram at {at}");
            if let Some((began, is_id, bytes)) = open.take() {
                let part = |check| bytes.iter().filter(move |byte| byte.0 == check).map(|byte| byte.1);
                frames.push(Frame { began, is_id, data: part(false).collect(), check: part(true).collect() });
            }
            at += 5 * bit;
        }
    }
    frames
}

/// x^16 + x^12 + x^5 + 1 from FFFF, bit by bit.
fn crc(bytes: &[u8]) -> [u8; 2] {
    let mut crc = 0xFFFF_u16;
    for byte in bytes {
        crc ^= u16::from(*byte) << 8;
        for _ in 0..8 {
            crc = if crc & 0x8000 == 0 { crc << 1 } else { crc << 1 ^ 0x1021 };
        }
    }
    crc.to_be_bytes()
}

#[test]
fn the_words_of_every_exchange_stand_on_the_segments() {
    for (ring, bit) in [("", 20), ("[ring]\nkbit_s = 2000\n", 5)] {
        let mut bench = Bench::new(&format!("{}{ring}", three([1_000, 2_000, 3_000])), Format::Vcd);
        for cycle in 0..200_u32 {
            // Services of all three, in turn.
            let request = if cycle % 20 < 10 { 0x8100_0000 | (cycle / 20 % 9) << 24 } else { 0 };
            bench.ring.out[cycle as usize / 20 % 3] = request | cycle & 0xFF;
            assert_eq!(bench.cycle(), Verdict::Good);
        }
        let (rows, found) = bench.end();
        let on = |segment: usize| frames(&found[&format!("line.segment_{segment}")], bit);
        let [out, first, second, home] = [0, 1, 2, 3].map(on);
        let out_of = |cycle: usize, position: usize| rows[3 * cycle + position].out.unwrap();
        let in_of = |cycle: usize, position: usize| match rows[3 * cycle + position].input {
            Some(Input::Word(word)) => word,
            _ => panic!("an encoder is off"),
        };
        assert_eq!([out.len(), first.len(), second.len(), home.len()], [200; 4]);
        let loopback = [0xE3, 0xA5];
        for cycle in 1..200 {
            let bytes = |word: u32| word.to_be_bytes().to_vec();
            let [o0, o1, o2] = [0, 1, 2].map(|position| bytes(out_of(cycle, position)));
            let [i0, i1, i2] = [0, 1, 2].map(|position| bytes(in_of(cycle - 1, position)));
            let expected = [
                [&loopback[..], &o2, &o1, &o0].concat(),
                [&i0[..], &loopback, &o2, &o1].concat(),
                [&i1[..], &i0, &loopback, &o2].concat(),
                [&i2[..], &i1, &i0, &loopback].concat(),
            ];
            for (segment, (frame, expected)) in [&out[cycle], &first[cycle], &second[cycle], &home[cycle]]
                .into_iter()
                .zip(expected)
                .enumerate()
            {
                assert_eq!(frame.data, expected, "segment {segment} in cycle {cycle}");
                let [high, low] = crc(&expected);
                assert_eq!((frame.is_id, &frame.check[..]), (false, &[high, low, 0, 0][..]));
                // Each device delays by two bits.
                assert_eq!(frame.began, out[cycle].began + 2 * bit * segment as u64);
            }
            // The words of the encoders' own signals: IN as it was loaded, OUT from the latch on.
            let (began, later) = (out[cycle].began, out[cycle].began + bit * 280);
            for position in 0..3 {
                let signal = |name: &str| &found[&format!("encoder_{position}.{name}")];
                assert_eq!(number(shown(signal("in"), began)), in_of(cycle - 1, position));
                assert_eq!(number(shown(signal("out"), later)), out_of(cycle, position));
                assert_eq!(
                    shown(signal("out_service"), later) == "1",
                    out_of(cycle, position) & SERVICE_BIT != 0
                );
                assert_eq!(
                    shown(signal("in_service"), began) == "1",
                    in_of(cycle - 1, position) & SERVICE_BIT != 0
                );
                let latches = signal("latch").iter().filter(|change| change.1 == "1");
                let here = latches.filter(|change| (began..later).contains(&change.0)).count();
                assert_eq!(here, 1, "position {position} in cycle {cycle}");
            }
        }
        for position in 0..3 {
            let states = &found[&format!("encoder_{position}.state")];
            let codes = states.iter().map(|change| number(&change.1)).skip_while(|code| *code == 4);
            assert_eq!(
                codes.take(8).collect::<Vec<_>>(),
                [6, 7, 8, 4, 6, 7, 8, 4],
                "data, check word, end word, pause"
            );
            assert_eq!(number(&found[&format!("encoder_{position}.position")][0].1), position);
        }
        assert!((0..=3).all(|segment| found[&format!("hit.segment_{segment}_hit")].len() == 1));
        assert_eq!(found["cycle.verdict"], [(0, "00".to_owned())]);
    }
}

#[test]
fn a_search_can_be_watched() {
    let text = format!("{}{}", three([1_000, 2_000, 3_000]), line(20.0, 2, "silent", 100.0));
    let mut bench = Bench::new(&text, Format::Vcd);
    bench.run_to_ms(400.0);
    let (_, found) = bench.end();
    let ms = |at: u64| at * 10_000;
    // The segment stands still where it is broken, and every 0 on it is a hit.
    assert_eq!(shown(&found["line.segment_2"], ms(60)), "1");
    assert!(found["hit.segment_2_hit"].len() > 10);
    assert_eq!(found["hit.segment_1_hit"].len(), 1);
    assert_eq!(shown(&found["master.search"], ms(60)), "1");
    assert_eq!(number(shown(&found["master.state"], ms(60))), 0);
    // Five faulty cycles, then silence until every chip is in reset, then identification.
    let states = |position: usize| -> Vec<u32> {
        found[&format!("encoder_{position}.state")].iter().map(|change| number(&change.1)).collect()
    };
    for position in 0..3 {
        assert!(states(position).contains(&2), "reset at {position}");
        assert!(states(position).contains(&5), "identification at {position}");
        let lamp = |name: &str| &found[&format!("encoder_{position}.lamp_{name}")];
        assert_eq!(lamp("u"), &[(0, "1".to_owned())]);
        assert!(lamp("rc").iter().any(|change| change.1 == "0"));
    }
    let positions = &found["encoder_2.position"];
    assert_eq!(positions.iter().filter(|change| change.1.contains('x')).count(), 1, "{positions:?}");
    assert!(found["encoder_1.outgoing"].iter().any(|change| change.1 == "1"));
    let ids: Vec<Frame> =
        frames(&found["line.segment_0"], 20).into_iter().filter(|frame| frame.is_id).collect();
    assert!(ids.len() > 5 && ids[0].data[..2] == [0xE3, 0xA5]);
    // In the end it runs.
    assert_eq!(number(shown(&found["master.status"], ms(399))), 0x00E0);
    assert_eq!(number(shown(&found["master.devices"], ms(399))), 3);
    assert_eq!(shown(&found["cycle.verdict"], ms(399)), "00");
    assert_eq!(shown(&found["master.search"], ms(399)), "0");
}

#[test]
fn a_recording_changes_nothing_and_both_formats_hold_the_same() {
    let events = [
        line(10.0, 1, "bad", 5.0),
        set(20.0, 1, "supply_v = 0.0"),
        set(60.0, 1, "supply_v = 24.0"),
        set(100.0, 0, "chip_held = true"),
        set(150.0, 0, "chip_held = false"),
    ]
    .concat();
    let text = format!("{}{events}", three([1_000, 2_000, 3_000]));
    let mut unseen = Ring::of(&scenario(&text));
    unseen.run_to_ms(400.0);
    let [vcd, fst] = [Format::Vcd, Format::Fst].map(|format| {
        let mut bench = Bench::new(&text, format);
        bench.run_to_ms(400.0);
        let (rows, found) = bench.end();
        assert!(rows == unseen.rows);
        found
    });
    for (name, changes) in &vcd {
        assert!(changes == &fst[name], "{name}");
    }
    assert_eq!(vcd.len(), fst.len());
    let states: Vec<u32> = vcd["encoder_1.state"].iter().map(|change| number(&change.1)).collect();
    assert!(states.contains(&0));
    assert!(vcd["encoder_0.state"].iter().any(|change| number(&change.1) == 1));
    assert!(vcd["encoder_1.in"].iter().any(|change| change.1.contains('x')));
}

#[test]
fn without_lines_a_recording_holds_words_verdicts_lamps_and_the_master() {
    let text = format!("{}{}", three([1_000, 2_000, 3_000]), line(10.0, 1, "silent", 60.0));
    let mut bench = Bench::showing(&text, Format::Vcd, Shown::Words);
    bench.ring.out = vec![7; 3];
    bench.run_to_ms(200.0);
    let (_, found) = bench.end();
    let scopes = ["cycle.", "master.", "encoder_"];
    assert!(found.keys().all(|name| scopes.iter().any(|scope| name.starts_with(scope))));
    assert!(!found.contains_key("encoder_0.state"));
    assert_eq!(number(shown(&found["cycle.verdict"], 115_000)), 2);
    assert_eq!(number(shown(&found["cycle.segment"], 115_000)), 1);
    let words: Vec<u32> = found["encoder_2.out"].iter().map(|change| number(&change.1)).collect();
    assert_eq!(words, [0, 7, 0, 7], "a device behind a silent line sees 0");
    assert_eq!(number(&found["encoder_1.in"].last().unwrap().1), 2_000);
    assert_eq!(
        ["encoder_0", "encoder_1"].map(|at| shown(&found[&format!("{at}.lamp_rc")], 360_000)),
        ["1", "0"]
    );
}

#[test]
fn a_ring_of_128_is_recorded_whole() {
    let devices: String = (0..128).map(|position| common::device(position, "ce-65-m", "")).collect();
    let mut bench = Bench::new(&format!("version = 1\n{devices}"), Format::Vcd);
    for _ in 0..3 {
        bench.cycle();
    }
    let (rows, found) = bench.end();
    let home = frames(&found["line.segment_128"], 20);
    assert_eq!((home.len(), home[2].data.len(), rows.len()), (3, 514, 384));
}
