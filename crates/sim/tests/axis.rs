//! `host::axis` beside encoders on a simulated ring, in virtual time: one call a cycle.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test may panic")]

use std::path::Path;

use encoring_host::axis::{AxisCycle, JudgedAxis};
use encoring_host::referee::{LineSeen, ORDER, Observed, Referee, Vantage};
use encoring_host::session::Fate;
use encoring_host::validity::{Expectation, Limits, Position, Stop, Why};
use encoring_host::{Outcome, Request, Seen, Timing};
use encoring_ring::Verdict;
use encoring_sim::{Scenario, World};
use encoring_words::model::Sensor;
use encoring_words::{Duration, InWord, Instant, Model, OutWord, Parameter, ParameterSet, Written};

const SHAFT: Sensor = Sensor::Rotary { steps_per_turn: 4096 };
const ROD: Sensor = Sensor::Linear { rod_um: 500_000 };

/// The encoders, with a motion that their data sheets allow.
const ENCODERS: [(Model, Sensor, &str); 3] = [
    (Model::La66, ROD, "{ kind = \"sine\", center = 250_000, amplitude = 200_000, period_s = 8.0 }"),
    (Model::Ce100M, SHAFT, "{ kind = \"speed\", rpm = 60.0, start = 1000 }"),
    (Model::Ce65M, SHAFT, "{ kind = \"speed\", rpm = 60.0, start = 1000 }"),
];

/// A controller with one axis.
struct Machine {
    world: World,
    axis: JudgedAxis,
    now: Instant,
    stops: Vec<Stop>,
    /// Looks at what the axis writes.
    referee: Referee,
    written: OutWord,
}

impl Machine {
    fn new((model, sensor, motion): (Model, Sensor, &str), events: &str) -> Self {
        let text = format!(
            "version = 1\n[[device]]\nposition = 0\nmodel = \"{}\"\nmotion = {motion}\n{events}",
            model.name()
        );
        let scenario = Scenario::parse("test", &text, Path::new("")).unwrap();
        let expectation = Expectation::new(model, sensor, &ParameterSet::factory(model, sensor)).unwrap();
        let limits = Limits::of(model, scenario.cycle_time.of_encoders(1));
        let axis = JudgedAxis::new(Timing::DIRECT, OutWord(0), expectation, limits);
        let mut world = World::new(&scenario).unwrap();
        // A device shows its position from the second cycle on.
        world.cycle(&[axis.out()], &mut [InWord(0)]);
        let referee = Referee::new(Vantage::Writes, Some(model));
        Self { world, axis, now: Instant::ZERO, stops: Vec::new(), referee, written: OutWord(0) }
    }

    fn cycle(&mut self) -> AxisCycle {
        let mut input = [InWord(0)];
        let out = self.axis.out();
        if std::mem::replace(&mut self.written, out) != out {
            let (at, written) = (self.now, Written::Both(out));
            self.referee.observe(Observed::Write { at, client: 1, written });
        }
        let cycled = self.world.cycle(&[out], &mut input);
        self.now = cycled.at;
        let line = if cycled.verdict == Verdict::Good { LineSeen::Good } else { LineSeen::Bad };
        self.referee.observe(Observed::Cycle { at: self.now, out, input: Some(input[0]), line });
        let seen = (cycled.verdict == Verdict::Good).then_some(Seen { input: input[0], age: Duration::ZERO });
        self.axis.cycle(self.now, seen, &mut |stop| self.stops.push(stop))
    }

    /// The first position.
    fn begin(&mut self) -> u32 {
        self.cycle().position.valid().unwrap()
    }

    /// The outcome of the service under way, the positions up to it and that of the same cycle.
    fn outcome(&mut self) -> (Outcome, Vec<Position>) {
        let mut positions = Vec::new();
        loop {
            let AxisCycle { position, outcome, .. } = self.cycle();
            positions.push(position);
            if let Some(outcome) = outcome {
                self.judge(outcome);
                return (outcome, positions);
            }
            assert!(positions.len() < 5_000, "no outcome: {positions:?}");
        }
    }

    /// Whoever gets what was asked for has kept the handshake.
    fn judge(&self, outcome: Outcome) {
        let Outcome::Done { .. } = outcome else { return };
        let broken = self.referee.findings().find(|finding| ORDER.contains(&finding.rule));
        assert!(broken.is_none() && self.referee.services() > 0, "{broken:?}");
    }

    fn serves(&mut self, request: Request) -> (Outcome, Vec<Position>) {
        self.axis.start(self.now, request).unwrap();
        self.outcome()
    }
}

#[test]
fn every_cycle_has_a_judged_position_and_a_service_runs_beside_them() {
    for encoder in ENCODERS {
        let mut machine = Machine::new(encoder, "");
        machine.begin();
        assert!((0..200).all(|_| machine.cycle().position.valid().is_some()), "{encoder:?}");
        let (outcome, positions) =
            machine.serves(Request::read(encoder.0, Parameter::MeasuringLength).unwrap());
        let Outcome::Done { reply, .. } = outcome else { panic!("{encoder:?}: {outcome:?}") };
        let factory = ParameterSet::factory(encoder.0, encoder.1);
        assert_eq!(reply.data, factory.value(Parameter::MeasuringLength));
        assert!(positions.contains(&Position::InService), "{positions:?}");
        assert!(positions.last().unwrap().valid().is_some(), "{positions:?}");
        assert_eq!(machine.stops, [], "{encoder:?}");
        assert!(machine.axis.is_resting());
    }
}

#[test]
fn a_preset_adjustment_moves_the_zero_and_nothing_is_stopped_for_it() {
    for encoder in ENCODERS {
        let mut machine = Machine::new(encoder, "");
        let before = machine.begin();
        let (outcome, positions) = machine.serves(Request::preset(encoder.0, 9_000, 10_000).unwrap());
        assert!(matches!(outcome, Outcome::Done { .. }), "{outcome:?}");
        let after = positions.last().unwrap().valid().unwrap();
        assert!(after.abs_diff(9_000) < 500 && after.abs_diff(before) > 500, "{before}, {after}");
        assert!((0..100).all(|_| machine.cycle().position.valid().is_some()), "{encoder:?}");
        assert_eq!(machine.stops, [], "{encoder:?}");
    }
}

/// 1000 steps a turn: what a CE-65-M shows after its data check is another position.
fn programmed() -> (Machine, Expectation) {
    let mut machine = Machine::new(ENCODERS[2], "");
    machine.begin();
    let mut set = ParameterSet::factory(Model::Ce65M, SHAFT);
    for (parameter, value) in [(Parameter::MeasuringLength, 9_999), (Parameter::Numerator, 10)] {
        let (outcome, _) = machine.serves(Request::write(Model::Ce65M, parameter, value).unwrap());
        assert!(matches!(outcome, Outcome::Done { reply, .. } if !reply.error), "{outcome:?}");
        set.set(parameter, value);
    }
    (machine, Expectation::new(Model::Ce65M, SHAFT, &set).unwrap())
}

#[test]
fn positions_are_judged_by_the_new_values_from_the_data_check_on() {
    let (mut machine, becomes) = programmed();
    (0..3_000).for_each(|_| _ = machine.cycle());
    machine.axis.start_check(machine.now, becomes).unwrap();
    let (outcome, positions) = machine.outcome();
    assert!(matches!(outcome, Outcome::Done { .. }), "{outcome:?}");
    assert!(positions.last().unwrap().valid().is_some(), "{positions:?}");
    assert!((0..100).all(|_| machine.cycle().position.valid().is_some()));
    assert_eq!(machine.stops, []);
}

#[test]
fn a_data_check_that_tells_no_new_values_leaves_a_jump() {
    let (mut machine, _) = programmed();
    (0..3_000).for_each(|_| _ = machine.cycle());
    let (_, positions) = machine.serves(Request::data_check());
    assert!(matches!(positions.last(), Some(Position::Implausible(Why::Speed { .. }))), "{positions:?}");
    assert!(matches!(machine.stops[..], [Stop::Implausible(_)]), "{:?}", machine.stops);
}

#[test]
fn a_broken_ring_stops_the_machine_once_and_a_service_tells_that_it_ran_out_of_time() {
    let broken = "[[event]]\nat_s = 0.1\nsegment = 0\nline = \"silent\"\n";
    let mut machine = Machine::new(ENCODERS[2], broken);
    machine.begin();
    while machine.now < Instant(200_000_000) {
        machine.cycle();
    }
    let (outcome, positions) = machine.serves(Request::read(Model::Ce65M, Parameter::Numerator).unwrap());
    assert!(matches!(outcome, Outcome::TimedOut(told) if told.fate == Fate::NotSent), "{outcome:?}");
    assert!(
        matches!(positions.last(), Some(Position::Stale { last: Some(_), .. })),
        "{:?}",
        positions.last()
    );
    assert!(matches!(machine.stops[..], [Stop::Stale { .. }]), "{:?}", machine.stops);
}

#[test]
fn one_service_at_a_time_and_what_is_given_up_says_what_is_known() {
    let mut machine = Machine::new(ENCODERS[1], "");
    machine.begin();
    let request = Request::read(Model::Ce100M, Parameter::Numerator).unwrap();
    machine.axis.start(machine.now, request).unwrap();
    assert!(machine.axis.start(machine.now, request).is_err());
    assert!(machine.axis.give_up(machine.now));
    let (outcome, _) = machine.outcome();
    assert!(matches!(outcome, Outcome::GivenUp(told) if told.fate == Fate::NotSent), "{outcome:?}");
    assert!(machine.axis.is_resting() && !machine.axis.out().service_bit());
}
