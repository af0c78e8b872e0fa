//! The view, drawn into a buffer.

use encoring_bus::BusError;
use encoring_bus::Cause;
use encoring_bus::watch::Sight;
use encoring_bus::{Judge, Judgement, Tolerance};
use encoring_host::validity::Why;
use encoring_station::view::LampsView;
use encoring_words::model::Sensor;
use encoring_words::parameter::Parameter;
use encoring_words::{Duration, ErrorStatus, InWord, Instant, Model, OutWord};
use ratatui::Terminal;
use ratatui::backend::TestBackend;

use super::screen::{Screen, Update, Way};
use super::seen::Seen;
use super::{About, line};
use crate::news::News;

const STALE: Tolerance = Tolerance::of_sheet(Duration::from_millis(100));
const SENSOR: Sensor = Sensor::Rotary { steps_per_turn: 4096 };
const GATEWAY: &str = "modbus-tcp://192.168.1.10";

/// What is seen of an encoder of which all is known, or nothing.
fn sight(position: usize, out: u32, input: u32, verdict: Judgement) -> Sight {
    Sight {
        position,
        at: Instant(12_345_678_900),
        input: Some(InWord(input)),
        age: Some(Duration::from_micros(20_340)),
        out: Some(OutWord(out)),
        verdict,
        stop: None,
    }
}

/// An encoder of a real ring.
fn real(sight: &Sight, judge: &Judge) -> Seen {
    Seen::new(sight, judge, None)
}

fn known() -> Judge {
    let values = [
        (Parameter::CountingDirection, 0),
        (Parameter::MeasuringLength, 9_999),
        (Parameter::Numerator, 10),
        (Parameter::Denominator, 1),
    ];
    Judge::new(Model::Ce65M, Some(SENSOR), &values, STALE).unwrap()
}

fn unknown(model: Model) -> Judge {
    Judge::new(model, None, &[], STALE).unwrap()
}

fn screen(address: &str, seen: Vec<Seen>, news: Vec<News>) -> Screen {
    let about = About {
        address: address.to_owned(),
        simulated: address == "sim",
        poll: Duration::from_millis(10),
        every: Duration::from_millis(200),
    };
    let mut screen = Screen::new(about);
    screen.take(Update { polls: 42, seen, news });
    screen
}

fn drawn(screen: &mut Screen, (width, height): (u16, u16)) -> String {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    terminal.draw(|frame| screen.draw(frame, Duration::from_millis(70))).unwrap();
    terminal.backend().to_string()
}

const SMALL: (u16, u16) = (80, 24);
const LARGE: (u16, u16) = (120, 40);

fn link(event: &'static str, text: &str) -> News {
    News {
        event,
        time_ns: 1_500_000_000,
        date: "2026-11-27T18:40:00Z".to_owned(),
        position: None,
        text: text.to_owned(),
        diagnosis: None,
        found: None,
        lasting: true,
        advice: None,
    }
}

fn all_fine() -> Vec<Seen> {
    (0..3)
        .map(|position| {
            let value = 1_234 * (position as u32 + 1);
            let sight = sight(position, 0, value, Judgement::Valid(value));
            let lamps = LampsView { u: true, ba: true, rc: true, rd: position == 2 };
            Seen::new(&sight, &known(), Some(lamps))
        })
        .collect()
}

#[test]
fn a_simulated_ring_on_which_all_is_well() {
    insta::assert_snapshot!("all_fine_80x24", drawn(&mut screen("sim", all_fine(), vec![]), SMALL));
    insta::assert_snapshot!("all_fine_120x40", drawn(&mut screen("sim", all_fine(), vec![]), LARGE));
}

fn troubled() -> Vec<Seen> {
    let status = ErrorStatus::LENGTH_TOO_LARGE | ErrorStatus::UNKNOWN_COMMAND;
    vec![
        real(&sight(0, 0, 0x2000_04D2, Judgement::Faulty(None)), &unknown(Model::La66)),
        real(&sight(1, 0, 0x2000_04D2, Judgement::Faulty(Some(status))), &unknown(Model::Ce100M)),
        real(&sight(2, 0, 0x04D2, Judgement::Unchecked(0x04D2)), &unknown(Model::Ce65M)),
    ]
}

#[test]
fn errors_are_told_with_what_is_known_of_them() {
    let error = || News { position: Some(0), ..link("error", "the error bit is set") };
    let news = || vec![link("link_up", "connected"), error()];
    insta::assert_snapshot!("error_80x24", drawn(&mut screen(GATEWAY, troubled(), news()), SMALL));
    insta::assert_snapshot!("error_120x40", drawn(&mut screen(GATEWAY, troubled(), news()), LARGE));
}

fn in_service() -> Vec<Seen> {
    let implausible = Judgement::Implausible(Why::Range { value: 10_000, measuring_length: 9_999 });
    vec![
        real(&sight(0, 0xC200_270F, 0xC200_270F, Judgement::InService), &known()),
        real(&sight(1, 0xC200_270F, 1_234, Judgement::Valid(1_234)), &known()),
        real(&sight(2, 0, 0x0000_2710, implausible), &known()),
    ]
}

#[test]
fn a_service_is_seen_with_its_step_of_the_handshake() {
    insta::assert_snapshot!("in_service_80x24", drawn(&mut screen(GATEWAY, in_service(), vec![]), SMALL));
    insta::assert_snapshot!("in_service_120x40", drawn(&mut screen(GATEWAY, in_service(), vec![]), LARGE));
}

// [R150, R151, R152, R153]
#[test]
fn a_step_that_no_shaft_makes_is_told_with_the_causes_and_remedies_of_the_manual() {
    let step = || Judgement::Implausible(Why::Speed { from: 5, to: 9_000, within: Duration::from_millis(1) });
    let told = real(&sight(2, 0, 9_000, step()), &known());
    let causes: Vec<String> = told.causes.iter().map(ToString::to_string).collect();
    assert_eq!(causes.len(), 4);
    for (told, (cause, remedy)) in causes.iter().zip([
        ("loose contacts", "check all cables"),
        ("severe vibration", "shock modules"),
        ("electrical disturbance", "insulating flanges"),
        ("a sampling defect", "plastic couplings"),
    ]) {
        assert!(told.contains(cause) && told.contains(remedy), "{told}");
    }
    insta::assert_snapshot!("step_120x40", drawn(&mut screen(GATEWAY, vec![told], vec![]), LARGE));
    let range = Judgement::Implausible(Why::Range { value: 10_000, measuring_length: 9_999 });
    assert!(real(&sight(2, 0, 10_000, range), &known()).causes.is_empty());
}

fn lost(verdict: Judgement) -> Seen {
    let sight = sight(1, 0, 0, verdict);
    real(&Sight { input: None, age: None, out: None, ..sight }, &known())
}

#[test]
fn a_link_that_is_down_leaves_the_last_position_as_history() {
    let before = [
        real(&sight(0, 0, 0x0000_04D2, Judgement::Valid(1_234)), &known()),
        real(&sight(1, 0, 0x0000_04D2, Judgement::Valid(1_234)), &known()),
    ];
    let cause = BusError::NoConnection(Cause::System(std::io::ErrorKind::ConnectionRefused));
    for (size, name) in [(SMALL, "link_down_80x24"), (LARGE, "link_down_120x40")] {
        let before = before.iter().map(|seen| real(&seen.sight, &known())).collect();
        let mut screen = screen(GATEWAY, before, vec![link("link_up", "connected")]);
        let stale = Judgement::Stale { age: Duration::from_millis(1_250) };
        let seen =
            vec![real(&sight(0, 0, 0x0000_04D2, stale), &known()), lost(Judgement::NoAnswer(cause.clone()))];
        let failed = || link("link_failed", "no connection: connection refused; next attempt in 200 ms");
        let down = link("link_down", "connection lost after 1.4 s: no answer within 1 s");
        screen.take(Update { polls: 43, seen, news: vec![down, failed(), failed()] });
        insta::assert_snapshot!(name, drawn(&mut screen, size));
    }
}

fn full_ring() -> Vec<Seen> {
    let verdict = |position: u32| match position {
        3 => (0x2000_0000, Judgement::Faulty(None)),
        5 => (0x8800_0000, Judgement::InService),
        _ => (position * 70, Judgement::Valid(position * 70)),
    };
    (0..128).map(|k| real(&sight(k, 0, verdict(k as u32).0, verdict(k as u32).1), &known())).collect()
}

#[test]
fn a_full_ring_is_a_list_that_scrolls() {
    let mut screen = screen(GATEWAY, full_ring(), vec![]);
    insta::assert_snapshot!("full_ring_80x24", drawn(&mut screen, SMALL));
    screen.scroll(Way::PageDown);
    let page = drawn(&mut screen, SMALL);
    assert!(page.contains("22-42 of 128 encoders") && page.contains(" 21  ce-65-m"), "{page}");
    screen.scroll(Way::End);
    let page = drawn(&mut screen, SMALL);
    assert!(page.contains("108-128 of 128 encoders"), "{page}");
    screen.scroll(Way::Up);
    assert!(drawn(&mut screen, SMALL).contains("107-127 of 128 encoders"));
    screen.scroll(Way::Begin);
    insta::assert_snapshot!("full_ring_120x40", drawn(&mut screen, LARGE));
}

#[test]
fn the_blocks_of_a_full_ring_scroll_too() {
    let mut screen = screen(GATEWAY, full_ring(), vec![]);
    screen.change_view();
    assert!(drawn(&mut screen, SMALL).contains("1-3 of 128 encoders"));
    for (way, shown) in [
        (Way::Down, "2-4 of 128"),
        (Way::PageDown, "5-7 of 128"),
        (Way::End, "126-128 of 128"),
        (Way::Down, "126-128 of 128"),
        (Way::Begin, "1-3 of 128"),
        (Way::Up, "1-3 of 128"),
    ] {
        screen.scroll(way);
        let page = drawn(&mut screen, SMALL);
        assert!(page.contains(shown), "{shown}: {page}");
    }
}

#[test]
fn no_size_of_the_terminal_is_too_small() {
    for seen in [all_fine, troubled, in_service, full_ring, Vec::new] {
        for width in [1, 2, 3, 10, 40, 80, 300] {
            for height in [1, 2, 3, 4, 7, 19, 20, 60] {
                let mut screen = screen(GATEWAY, seen(), vec![link("link_up", "connected")]);
                drawn(&mut screen, (width, height));
                screen.change_view();
                drawn(&mut screen, (width, height));
            }
        }
    }
}

#[test]
fn a_line_has_the_same_in_short() {
    assert_eq!(
        line(&all_fine()[2]),
        "    12.345   2  ce-65-m          3702  valid              00000000  00000E76  normal"
    );
    assert_eq!(
        line(&troubled()[0]),
        "    12.345   0  la-66               -  faulty             00000000  200004D2  normal; an error is pending: \
         make the machine safe first; its status is not known until a data check tells it: `encoring check`"
    );
}
