use super::*;

const Q4096: Sensor = Sensor::Rotary { steps_per_turn: 4096 };

fn ce65(file: &[(Parameter, u32)]) -> KnownEncoder {
    KnownEncoder::new(Model::Ce65M, Some(Q4096), file)
}

/// Each reply, with the position between two of them.
fn saw(known: &mut KnownEncoder, replies: &[u32]) {
    for (k, reply) in replies.iter().enumerate() {
        known.saw(Instant(10 * k as u64), Some(OutWord(*reply)), InWord(*reply));
        known.saw(Instant(10 * k as u64 + 5), Some(OutWord(0)), InWord(1_000));
    }
}

/// Programmed, accepted and active value of a parameter.
fn values(known: &KnownEncoder, parameter: Parameter) -> [Option<(u32, KnownFrom)>; 3] {
    let number = parameter.service().number();
    let known = known.parameters().into_iter().find(|known| known.service == number).unwrap();
    [known.programmed, known.accepted, known.active].map(|known| known.map(|known| (known.value, known.from)))
}

const LENGTH: Parameter = Parameter::MeasuringLength;

#[test]
fn nothing_is_known_before_a_file_or_a_reply_tells_it() {
    assert_eq!(values(&ce65(&[]), LENGTH), [None; 3]);
    assert_eq!(values(&ce65(&[(LENGTH, 9_999)]), LENGTH), [None, None, Some((9_999, KnownFrom::File))]);
    let services = |model| KnownEncoder::new(model, None, &[]).parameters().len();
    assert_eq!((services(Model::Ce65M), services(Model::La66)), (5, 3));
}

#[test]
fn a_value_that_was_read_is_programmed_and_counts_from_a_good_data_check_on() {
    // [R79, C7]
    let mut known = ce65(&[]);
    saw(&mut known, &[0x8200_270F]);
    assert_eq!(values(&known, LENGTH), [Some((9_999, KnownFrom::Read)), None, None]);
    saw(&mut known, &[0xA800_4000]);
    assert_eq!(values(&known, LENGTH)[2], None, "the check found an error");
    saw(&mut known, &[0x8800_0000, 0xC200_0FFF]);
    let checked = Some((9_999, KnownFrom::Check));
    assert_eq!(values(&known, LENGTH), [Some((4_095, KnownFrom::Written)), checked, checked]);
}

#[test]
fn what_is_programmed_counts_at_once_on_an_la_66() {
    // [R77, C8]
    let mut known = KnownEncoder::new(Model::La66, None, &[]);
    saw(&mut known, &[0xC200_270F, 0x8800_0000]);
    let written = Some((9_999, KnownFrom::Written));
    assert_eq!(values(&known, LENGTH), [written, None, written]);
    assert_eq!(known.data_check(), Some(ErrorStatus::empty()));
}

#[test]
fn a_reply_with_the_error_bit_tells_no_zero_and_leaves_open_what_was_written() {
    let mut known = ce65(&[]);
    saw(&mut known, &[0xA200_0000]);
    assert_eq!(values(&known, LENGTH), [None; 3]);
    saw(&mut known, &[0xA200_270F]);
    assert_eq!(values(&known, LENGTH)[0], Some((9_999, KnownFrom::Read)));
    saw(&mut known, &[0xE200_0FFF]);
    assert_eq!(values(&known, LENGTH)[0], None);
}

#[test]
fn after_a_pause_only_what_programmed_and_active_values_agree_on_is_known_as_active() {
    // [R80]: a power-up makes programmed values count, and nobody has seen whether there was one.
    let mut known = ce65(&[(Parameter::Numerator, 4_096)]);
    saw(&mut known, &[0x8200_270F, 0x8900_0001, 0x8800_0000, 0xC200_0FFF]);
    known.lost();
    assert_eq!(values(&known, LENGTH), [Some((4_095, KnownFrom::Written)), None, None]);
    assert_eq!(values(&known, Parameter::Denominator)[2], Some((1, KnownFrom::Check)));
    assert_eq!(values(&known, Parameter::Numerator)[2], Some((4_096, KnownFrom::File)));
}

#[test]
fn what_a_data_check_would_say_is_told_when_all_programmed_values_are_known() {
    // [R90]
    let all = [0x8100_0000, 0x82FF_FFFF, 0x8300_1000, 0x8900_0001, 0x8D00_0018];
    let mut known = ce65(&[]);
    saw(&mut known, &all[..4]);
    assert_eq!(known.data_check(), None);
    saw(&mut known, &all[4..]);
    assert_eq!(known.data_check(), Some(ErrorStatus::empty()));
    saw(&mut known, &[0xC300_0001]);
    assert_eq!(known.data_check(), Some(ErrorStatus::LENGTH_TOO_LARGE));
}

#[test]
fn where_the_rating_plate_is_not_known_only_what_holds_for_each_of_them_is_told() {
    let mut known = KnownEncoder::new(Model::Ce65M, None, &[]);
    saw(&mut known, &[0x8100_0000, 0x82FF_FFFF, 0x8300_1000, 0x8900_0001, 0x8D00_0018]);
    assert_eq!(known.data_check(), Some(ErrorStatus::empty()));
    // 8191 steps over a turn: right with 8192 steps a turn, too many with 4096.
    saw(&mut known, &[0x8200_1FFF, 0x8300_0001]);
    assert_eq!(known.data_check(), None);
}

#[test]
fn what_nobody_asked_for_is_no_reply() {
    // A position of 1000000 whose halves a gateway exchanges looks like one at times.
    let mut known = ce65(&[]);
    for (out, input) in
        [(Some(OutWord(0)), 0x8200_00FF), (None, 0x8200_00FF), (Some(OutWord(0x8300_0000)), 0x8200_00FF)]
    {
        known.saw(Instant(0), out, InWord(input));
    }
    assert_eq!(values(&known, LENGTH), [None; 3]);
    // The bit falls before the reply goes.
    known.saw(Instant(0), Some(OutWord(0x0200_0000)), InWord(0x8200_00FF));
    assert_eq!(values(&known, LENGTH)[0], Some((255, KnownFrom::Read)));
}
