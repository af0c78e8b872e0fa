use super::*;

const STANDS: (u16, u16) = (0x1094, 0x0300);
const SEARCHES: (u16, u16) = (0x1090, 0x0BDF);
const RUNS: (u16, u16) = (0x00E0, 0);

/// What is told of a master that says one after the other, 10 ms apart.
fn told(says: impl IntoIterator<Item = (u16, u16)>) -> Vec<(u64, String)> {
    let mut history = RingHistory::default();
    let polls = says.into_iter().zip(0_u64..).filter_map(|((status, parameter), k)| {
        let said = Ok(Diagnosis { status: Some(status), parameter: Some(parameter) });
        let news = history.take(Instant(k * 10_000_000), &said)?;
        Some((k * 10, news.to_string()))
    });
    polls.collect()
}

fn for_ms(ms: usize, says: (u16, u16)) -> impl Iterator<Item = (u16, u16)> {
    std::iter::repeat_n(says, ms / 10)
}

#[test]
fn a_stop_is_told_at_once_and_its_end_when_the_ring_has_run_for_a_second() {
    let says = for_ms(100, RUNS).chain(for_ms(20, SEARCHES)).chain(for_ms(2_980, STANDS));
    let told = told(says.chain(for_ms(2_000, RUNS)));
    let [stops, found, ends] = &told[..] else { panic!("{told:#?}") };
    assert_eq!((stops.0, found.0), (100, 120));
    assert!(stops.1.starts_with("the ring stands still: "), "{}", stops.1);
    assert!(found.1.contains("segment 2"), "{}", found.1);
    assert_eq!(
        *ends,
        (4_100, "the ring stood still for 3.0 s; now the ring runs (status 00E0, parameter 0000)".into())
    );
}

#[test]
fn a_loose_contact_that_stops_the_ring_many_times_a_second_is_one_trouble() {
    let stop = || [SEARCHES, STANDS, STANDS, STANDS, RUNS, RUNS];
    let flapping = (0..60_000).flat_map(|_| stop());
    let told = told(for_ms(100, RUNS).chain(flapping).chain(for_ms(1_500, RUNS)));
    let [stops, found, ends] = &told[..] else { panic!("{told:#?}") };
    assert_eq!((stops.0, found.0), (100, 110));
    assert!(
        ends.1.starts_with("the ring stood still 60000 times, for 2400.0 s in all; now the ring runs"),
        "{}",
        ends.1
    );
}

#[test]
fn a_stop_after_a_second_of_running_is_another_trouble() {
    let both =
        for_ms(50, STANDS).chain(for_ms(1_100, RUNS)).chain(for_ms(50, STANDS)).chain(for_ms(1_100, RUNS));
    let told = told(both);
    assert_eq!(told.len(), 4, "{told:#?}");
    assert!(told[1].1.starts_with("the ring stood still for 50 ms; "), "{told:#?}");
}
