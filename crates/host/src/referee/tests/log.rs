//! What the rows of a log can have overlooked.

use super::*;

/// A log of services of these words with a row each 10 ms: `shown` says in how many rows each is seen prepared.
fn logged(services: &[(u32, u32)]) -> (Vec<HandshakeRule>, Vec<HandshakeRule>) {
    let mut referee = Referee::new(Vantage::Log, Some(Model::Ce65M));
    let mut rows = std::vec![(0, 0x64); 20];
    for &(word, shown) in services {
        let rest = word & 0x7FFF_FFFF;
        rows.extend(std::vec![(rest, 0x64); shown as usize]);
        rows.extend([(word, 0x64), (word, word), (0, word), (0, 0x64), (0, 0x64)]);
    }
    for (k, (out, input)) in (1..).zip(rows) {
        let (out, input) = (OutWord(out), Some(InWord(input)));
        referee.observe(Observed::Cycle { at: Instant(k * 10_000_000), out, input, line: LineSeen::Untold });
    }
    referee.finish();
    (referee.findings().map(|finding| finding.rule).collect(), referee.not_judged().collect())
}

// [R33]
#[test]
fn a_log_that_overlooks_preparations_suspects_nobody_of_leaving_them_out() {
    const RULE: HandshakeRule = HandshakeRule::DataWithServiceBit;
    let [write, preset] = [0xC200_270F, 0xC600_0005];
    for (services, suspected, is_judged) in [
        // Never prepared, alone or beside others that are.
        (&[(write, 0)][..], true, true),
        (&[(preset, 1), (write, 0), (preset, 1), (write, 0)], true, true),
        // Now and then: a row may lie between, whichever comes first.
        (&[(write, 1), (write, 0)], false, false),
        (&[(write, 0), (write, 1)], false, false),
        (&[(write, 0), (write, 1), (preset, 0)], false, false),
        // It takes longer than from row to row, so a row would have shown it.
        (&[(write, 3), (write, 0)], true, true),
        (&[(write, 3), (write, 3)], false, true),
    ] {
        let (found, not_judged) = logged(services);
        assert_eq!(found.contains(&RULE), suspected, "{services:X?}: {found:?}");
        assert_eq!(!not_judged.contains(&RULE), is_judged, "{services:X?}: {not_judged:?}");
    }
}

// [R38]
#[test]
fn a_log_suspects_no_drop_of_a_bit_that_one_row_shows_or_beside_the_reply() {
    const RULE: HandshakeRule = HandshakeRule::DroppedBeforeAcknowledgement;
    let rest = (0x0200_0000, 0x64);
    let judged = |rows: &[(u32, u32)]| {
        let mut referee = Referee::new(Vantage::Log, Some(Model::Ce65M));
        for (k, (out, input)) in (1..).zip([&[rest][..], rows, &[rest, rest]].concat()) {
            let (out, input) = (OutWord(out), Some(InWord(input)));
            referee.observe(Observed::Cycle {
                at: Instant(k * 10_000_000),
                out,
                input,
                line: LineSeen::Untold,
            });
        }
        referee.finish();
        let found: Vec<_> = referee.findings().map(|finding| finding.rule).collect();
        let not_judged: Vec<_> = referee.not_judged().collect();
        (found, not_judged.contains(&RULE))
    };
    let asked = (0x8200_0000, 0x64);
    assert_eq!(judged(&[asked]), (std::vec![], true));
    assert_eq!(judged(&[asked, asked]), (std::vec![RULE], false));
    assert_eq!(judged(&[asked, asked, (0x0200_0000, 0x8200_270F)]), (std::vec![], false));
}
