use std::sync::atomic::Ordering;
use std::thread;

use encoring_bus::{Judge, Tolerance};
use encoring_sim::{Scenario, World};
use serde_json::json;

use super::*;
use crate::answer::LineFate;
use crate::history::ServiceStep;
use crate::pace::Speed;
use crate::simulated::Simulated;

/// Looks until it is told to end.
struct Until(Arc<AtomicBool>);

impl Onlooker for Until {
    fn insight(&self, _position: usize) -> Option<Insight> {
        None
    }

    fn lamps(&self, _position: usize) -> Option<LampsView> {
        None
    }

    fn is_over(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    fn serving(&self, _position: usize, _left: LeftBit) {}

    fn happened(&mut self, _events: &[RingEvent]) -> io::Result<()> {
        Ok(())
    }
}

/// The built-in ring, looked at while `ask` has it.
fn looked_at<T>(ask: impl FnOnce(&PolledRing) -> T) -> (T, Simulated) {
    let world = World::new(&Scenario::built_in().unwrap()).unwrap();
    let mut bus = Simulated::new(world, Speed::Max);
    let models: Vec<Model> =
        bus.world().with(|world| world.places().iter().map(|place| place.node().unit().model()).collect());
    let tolerance = Tolerance::of_sheet(Duration::from_millis(100));
    let subject = |(position, model): (usize, &Model)| Subject {
        position,
        judge: Judge::new(*model, None, &[], tolerance).unwrap(),
    };
    let polled = Polled::new(PollOptions {
        bus: "sim".to_owned(),
        simulated: true,
        subjects: models.iter().enumerate().map(subject).collect(),
        files: Vec::new(),
        plan: Plan { every: Duration::from_millis(10), lasting: None },
        patience: Duration::from_secs(2),
    });
    let (ring, over) = (polled.ring().clone(), Arc::<AtomicBool>::default());
    let mut onlooker = Until(Arc::clone(&over));
    let looking = thread::spawn(move || {
        assert!(polled.run(&mut bus, &Arc::default(), &mut onlooker).unwrap().answered);
        bus
    });
    while ring.seen().unwrap()["polls"] == 0 {}
    let asked = ask(&ring);
    over.store(true, Ordering::Relaxed);
    let bus = looking.join().unwrap();
    assert_eq!(ring.seen(), Err(RingStopped));
    (asked, bus)
}

#[test]
fn nothing_is_written_unless_it_is_asked_for_and_whoever_may_only_look_is_refused() {
    let ((), mut bus) = looked_at(|ring| {
        for line in [
            r#"{"verb":"out","position":1,"word":"4200270F"}"#,
            r#"{"verb":"service","position":1,"service":2,"value":9999}"#,
        ] {
            let told = ring.told(line, Permission::Look);
            assert_eq!(told.fate, LineFate::Forbidden, "{}", told.line);
        }
        for line in [
            r#"{"verb":"set","position":1,"set":{"supply_v":0}}"#,
            r#"{"verb":"line","segment":0,"fault":"silent"}"#,
        ] {
            let told = ring.told(line, Permission::Change);
            assert_eq!(told.fate, LineFate::Refused);
            assert!(
                told.line.contains("the verbs are out, service, acknowledge, view, help"),
                "{}",
                told.line
            );
        }
        let view = ring.told(r#"{"verb":"view"}"#, Permission::Look);
        assert_eq!(view.fate, LineFate::Done);
        let before = ring.seen().unwrap()["polls"].as_u64();
        while ring.seen().unwrap()["polls"].as_u64() < before.map(|polls| polls + 20) {}
    });
    for position in 0..3 {
        assert_eq!(bus.out(position), Ok(OutWord(0)));
    }
}

#[test]
fn a_service_is_carried_out_and_each_of_its_looks_is_kept() {
    // [R31..R40]
    let (changes, _) = looked_at(|ring| {
        let told =
            ring.told(r#"{"verb":"service","position":1,"service":2,"value":9999}"#, Permission::Change);
        let answer: Value = serde_json::from_str(&told.line).unwrap();
        assert_eq!(
            answer["reply"],
            json!({ "data": 9999, "error": false, "error_before": false }),
            "{told:?}"
        );
        ring.history().since(1, 0, 100).unwrap().changes
    });
    let steps = changes.iter().flat_map(|change| [change.out_step, change.in_step]).flatten();
    let steps: Vec<u8> = steps.map(ServiceStep::number).collect();
    assert_eq!(steps, [1, 2, 3, 4, 5]);
    assert!(changes.iter().all(|change| change.unseen.is_empty()), "{changes:?}");
}

#[test]
fn a_position_that_is_not_looked_at_is_refused_with_those_that_are() {
    let (line, _) = looked_at(|ring| {
        ring.told(r#"{"verb":"out","position":7,"word":"4200270F"}"#, Permission::Change).line
    });
    assert_eq!(
        line,
        r#"{"ok":false,"error":"position 7; the encoders are at 0, 1, 2","said":{"code":"refused.position","values":{"position":7,"known":"0, 1, 2"}}}"#
    );
}
