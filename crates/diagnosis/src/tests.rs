use encoring_ring::diagnostics::Diagnosis;
use encoring_words::{Model, Parameter, ParameterSet, gray};

use crate::{ActiveValues, Conclusion, Detector, JumpCause, KnownPlace, Options, Sample, Sighting};

/// What is concluded of words that came each millisecond.
fn concluded(words: impl IntoIterator<Item = u32>) -> Conclusion {
    let mut detector = Detector::new(Options::default());
    for (k, word) in (0_u64..).zip(words) {
        let reading = Sighting::Word(word);
        detector.sample(Sample { line: k + 2, time_ns: k * 1_000_000, position: 0, out: None, reading });
    }
    detector.finish()
}

fn causes(words: impl IntoIterator<Item = u32>) -> Vec<(u64, JumpCause)> {
    concluded(words).episodes.iter().map(|episode| (episode.line, episode.cause)).collect()
}

#[test]
fn a_shaft_that_turns_evenly_has_no_step_change() {
    assert_eq!(causes((0..30_000).map(|k| k * 100)), []);
}

#[test]
fn one_wrong_bit_is_found_in_every_row_and_beyond_a_window() {
    for at in [3, 100, 8_190, 8_200, 19_990] {
        let words = (0..20_000).map(|k| (k * 100 + 7) ^ if k == at { 1 << 19 } else { 0 });
        assert_eq!(causes(words), [(u64::from(at) + 2, JumpCause::SingleBit)], "{at}");
    }
}

#[test]
fn each_position_is_counted_once_however_many_windows_look_at_it() {
    for rows in [100, 8_191, 8_192, 8_193, 15_361, 50_000] {
        let words = (0..rows).map(|k| if k % 10 == 9 { 0x8200_270F } else { 5_000 });
        let judged = concluded(words).judged;
        let counted = format!("position 0: {rows} rows, {} of them positions,", rows - rows / 10);
        assert!(judged[0].text().starts_with(&counted), "{judged:?}");
    }
}

#[test]
fn positions_beyond_those_that_are_given_are_told_and_counted_once() {
    let limits = |length: u32| {
        let model = Model::Ce65M;
        let sensor = model.sensor(None, None).unwrap();
        let mut parameters = ParameterSet::factory(model, sensor);
        parameters.set(Parameter::MeasuringLength, length);
        let active = Some(ActiveValues { model, sensor, parameters });
        let mut detector = Detector::new(Options { active, ..Options::default() });
        for k in 0..30_000_u64 {
            let reading = Sighting::Word((k % 20_000) as u32);
            detector.sample(Sample { line: k + 2, time_ns: k * 1_000_000, position: 0, out: None, reading });
        }
        detector.finish().limits
    };
    let told = "position 0: 16000 positions are given, 0 to 15999, and 4000 rows have others, the first 16000 at line 16002: \
                these are wrong, or another scaling was active";
    assert!(limits(15_999).iter().any(|limit| limit.text() == told), "{:?}", limits(15_999));
    assert!(!limits(19_999).iter().any(|limit| limit.text().contains("given, 0 to")), "{:?}", limits(19_999));
}

#[test]
fn a_reply_is_told_by_its_bit_31() {
    let words = (0..100).map(|k| if (50..53).contains(&k) { 0x8200_270F } else { 500 });
    assert_eq!(causes(words), [(52, JumpCause::ReplyAsPosition)]);
}

#[test]
fn a_reply_that_is_asked_for_is_one_also_where_the_axis_may_be_anywhere() {
    // So seldom that the range can be passed in between; exchanged halves would be positions near 0.
    let mut detector = Detector::new(Options::default());
    for (row, word) in (0_u64..).zip([0, 0, 0x8800_0000, 0, 0, 0xC200_0001, 0, 0]) {
        let reading = Sighting::Word(word);
        let out = Some(if word == 0xC200_0001 { word } else { 0x8800_0000 });
        let time_ns = row * 20_000_000;
        detector.sample(Sample { line: row + 2, time_ns, position: 0, out, reading });
    }
    let causes: Vec<_> = detector.finish().episodes.iter().map(|episode| episode.cause).collect();
    assert!(causes.contains(&JumpCause::ReplyAsPosition), "{causes:?}");
    assert!(!causes.contains(&JumpCause::HalvesExchanged), "{causes:?}");
}

#[test]
fn positions_that_begin_again_are_a_wrap() {
    let words = (0..300).map(|k| k * 100 % 10_000);
    assert_eq!(causes(words), [(102, JumpCause::Wrap), (202, JumpCause::Wrap)]);
}

#[test]
fn a_zero_that_was_lost_shows_by_a_known_place_before_a_pause_and_one_behind_it() {
    let known = [(100, 1_000), (900, 1_000)]
        .map(|(ms, steps)| KnownPlace { time_ns: ms * 1_000_000, steps })
        .to_vec();
    let mut detector = Detector::new(Options { known, ..Options::default() });
    for k in 0..1_000_u64 {
        if (400..600).contains(&k) {
            continue;
        }
        let reading = Sighting::Word(if k < 500 { 1_000 } else { 5_000 });
        detector.sample(Sample { line: k + 2, time_ns: k * 1_000_000, position: 0, out: None, reading });
    }
    let found = detector.finish().episodes;
    assert_eq!((found[0].line, found[0].cause), (602, JumpCause::ZeroLost), "{found:?}");
}

mod any {
    use super::*;
    use proptest::prelude::*;

    fn reading() -> impl Strategy<Value = Sighting> {
        prop_oneof![
            any::<u32>().prop_map(Sighting::Word),
            (0..2_000_u32).prop_map(Sighting::Word),
            any::<i64>().prop_map(Sighting::Steps),
            any::<u16>().prop_map(Sighting::Bits16),
            Just(Sighting::Nothing),
            any::<(u16, u16, Option<i64>)>().prop_map(|(status, parameter, stands)| Sighting::Unreached {
                said: Diagnosis { status: Some(status), parameter: Some(parameter) },
                stands,
            }),
        ]
    }

    proptest! {
        #[test]
        fn no_rows_at_all_make_it_panic(
            rows in proptest::collection::vec((any::<u64>(), reading(), any::<Option<u32>>()), 0..200),
            sorted: bool,
        ) {
            let mut rows = rows;
            if sorted {
                rows.sort_by_key(|row| row.0);
            }
            let mut detector = Detector::new(Options::default());
            for (line, (time_ns, reading, out)) in (2..).zip(rows) {
                detector.sample(Sample { line, time_ns, position: 0, out, reading });
            }
            let found = detector.finish();
            prop_assert!(found.episodes.iter().all(|episode| episode.line <= episode.to_line && episode.count > 0));
        }
    }
}

#[test]
fn a_measuring_length_that_a_service_wrote_ends_the_range() {
    // C2h with 19 999; the range of 20 000 positions ends in row 300.
    let words = (0..600_u32).map(|k| if k == 100 { 0xC200_4E1F } else { (17_000 + 10 * k) % 20_000 });
    let found = causes(words);
    assert!(found.contains(&(302, JumpCause::Wrap)), "{found:?}");
}

#[test]
fn a_position_beyond_the_range_is_a_jump_and_no_way_round() {
    let mut detector = Detector::new(Options {
        model: Some(Model::Ce65M),
        measuring_length: Some(4_095),
        ..Options::default()
    });
    for k in 0..200_u32 {
        let word = (10 * k) % 4_096;
        let reading = Sighting::Word(if k == 100 { word ^ 1 << 14 } else { word });
        detector.sample(Sample {
            line: u64::from(k) + 2,
            time_ns: u64::from(k) * 1_000_000,
            position: 0,
            out: None,
            reading,
        });
    }
    let found = detector.finish().episodes;
    assert_eq!(
        found.iter().map(|one| (one.line, one.cause)).collect::<Vec<_>>(),
        [(102, JumpCause::SingleBit)]
    );
}

#[test]
fn rows_that_are_in_another_code_for_a_while_are_followed_to_where_they_are_back() {
    let right = |k: u32| 100_000 + 3 * k;
    let words = (0..900).map(|k| if (300..340).contains(&k) { gray::decode(right(k)) } else { right(k) });
    let found = causes(words);
    assert_eq!(
        found.iter().map(|(_, cause)| *cause).collect::<Vec<_>>(),
        [JumpCause::BinaryAsGray],
        "{found:?}"
    );
}

#[test]
fn a_known_place_at_the_end_of_all_times_is_told_as_one_that_no_row_is_near() {
    let known = vec![KnownPlace { time_ns: u64::MAX, steps: i64::MAX }];
    let mut detector = Detector::new(Options { known, ..Options::default() });
    for k in 0..100_u64 {
        let reading = Sighting::Word(1_000);
        detector.sample(Sample { line: k + 2, time_ns: k * 1_000_000, position: 0, out: None, reading });
    }
    let limits = detector.finish().limits;
    assert!(limits.iter().any(|limit| limit.text().contains("was not compared")), "{limits:?}");
}

/// Rows of 10 ms: positions of each row's number, and services that stand for two rows without and two with their reply, at
/// the numbers of rows where they begin.
fn served(
    positions: impl Fn(u32) -> u32,
    services: &[(u32, u32)],
    rows: u32,
    options: Options,
) -> Conclusion {
    let mut detector = Detector::new(options);
    for k in 0..rows {
        let service = services.iter().find(|(at, _)| (*at..at + 4).contains(&k));
        let (out, word) = match service {
            Some((at, service)) if k >= at + 2 => (*service, *service),
            Some((_, service)) => (*service, positions(k)),
            None => (0, positions(k)),
        };
        let (line, time_ns) = (u64::from(k) + 2, u64::from(k) * 10_000_000);
        detector.sample(Sample { line, time_ns, position: 0, out: Some(out), reading: Sighting::Word(word) });
    }
    detector.finish()
}

fn ce_65_with(parameters: &[(Parameter, u32)]) -> Options {
    let model = Model::Ce65M;
    let sensor = model.sensor(None, None).unwrap();
    let mut values = ParameterSet::factory(model, sensor);
    parameters.iter().for_each(|(parameter, value)| values.set(*parameter, *value));
    Options { active: Some(ActiveValues { model, sensor, parameters: values }), ..Options::default() }
}

#[test]
fn behind_a_scaling_that_the_rows_show_what_was_given_holds_no_more() {
    let positions = |k: u32| if k < 112 { 0xFF_F000 + 20 * k } else { (4_000 + 20 * (k - 112)) % 10_000 };
    let services = [(96, 0xC200_270F), (102, 0xC300_000A), (108, 0x8800_0000)];
    let said = served(positions, &services, 1_000, ce_65_with(&[]));
    let causes: Vec<_> = said.episodes.iter().map(|episode| episode.cause).collect();
    assert!(causes.contains(&JumpCause::Rescaled) && causes.contains(&JumpCause::Wrap), "{causes:?}");
    assert!(!causes.contains(&JumpCause::OverAcceleration), "{:?}", said.episodes);
    let told = "position 0: 16777216 positions, as given, up to line 110, where a data check made another scaling active";
    assert!(said.judged.iter().any(|judged| judged.text() == told), "{:?}", said.judged);
}

#[test]
fn a_service_that_changes_nothing_is_no_cause() {
    let causes = |services: &[(u32, u32)], steps: u32, options: Options| -> Vec<_> {
        let said = served(|k| 9_000 + steps * k, services, 400, options);
        said.episodes
            .iter()
            .map(|episode| episode.cause)
            .filter(|cause| *cause != JumpCause::ReplyAsPosition)
            .collect()
    };
    for steps in [0, 20] {
        // The values that were active, those without a data check, and the same direction with another code.
        for services in [
            &[(200, 0xC2FF_FFFF), (206, 0x8800_0000)][..],
            &[(200, 0xC200_270F)],
            &[(200, 0xC100_0000), (206, 0x8800_0000)],
            &[(200, 0xC100_0001)],
        ] {
            assert_eq!(causes(services, steps, Options::default()), [], "{services:X?}, {steps}");
            assert_eq!(causes(services, steps, ce_65_with(&[])), [], "{services:X?}, {steps}");
        }
    }
}

/// What is concluded of numbers that came each 10 ms.
fn of_numbers(options: Options, numbers: impl IntoIterator<Item = i64>) -> Conclusion {
    let mut detector = Detector::new(options);
    for (k, number) in (0_u64..).zip(numbers) {
        let reading = Sighting::Steps(number);
        detector.sample(Sample { line: k + 2, time_ns: k * 10_000_000, position: 0, out: None, reading });
    }
    detector.finish()
}

fn says(said: &[encoring_texts::Said], told: &str) -> bool {
    said.iter().any(|said| said.to_string().contains(told))
}

#[test]
fn numbers_that_no_encoder_shows_are_told_with_their_line_and_give_no_measuring_length() {
    let even = |k: i64| 5 * k;
    for (other, at) in [(99_999_999_999, 150), (16_777_216, 299), (-1, 0)] {
        let conclusion =
            of_numbers(Options::default(), (0..300).map(|k| if k == at { other } else { even(k) }));
        let told =
            format!("outside 0 to 16777215, and 1 rows have others, the first {other} at line {}", at + 2);
        assert!(says(&conclusion.limits, &told), "{:?}", conclusion.limits);
        assert!(says(&conclusion.judged, "S was not looked for"), "{:?}", conclusion.judged);
    }
    let below = of_numbers(Options::default(), (0..300).map(|k| even(k) - 500));
    assert!(says(&below.limits, "and 100 rows have others, the first -500 at line 2"), "{:?}", below.limits);
    let all = of_numbers(Options::default(), (0..300).map(|k| 16_775_720 + even(k)));
    assert!(!says(&all.limits, "no encoder shows"), "{:?}", all.limits);
    assert!(says(&all.judged, "S is at least 16777215"), "{:?}", all.judged);
}

#[test]
fn too_few_positions_and_positions_that_can_be_anywhere_are_not_judged() {
    for rows in 0..3 {
        let few = of_numbers(Options::default(), 0..rows);
        assert!(!few.is_judged && !says(&few.judged, "1 ns"), "{rows}: {:?}", few.judged);
    }
    assert!(of_numbers(Options::default(), 0..3).is_judged);
    let options = Options { measuring_length: Some(9_999), ..Options::default() };
    let mut chance = 7_u64;
    let anywhere = of_numbers(
        options,
        (0..300).map(|_| {
            chance = chance.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (chance >> 33) as i64 % 10_000
        }),
    );
    assert!(!anywhere.is_judged && says(&anywhere.limits, "no jump can be judged"), "{:?}", anywhere.limits);
    assert!(anywhere.episodes.iter().all(|episode| !says(&episode.evidence, "the same speed")));
}
