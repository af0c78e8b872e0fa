//! Programming as a user means it: these values shall count, all of them or none [R79..R81, C38].
//!
//! 1. Everything is read, and judged as the data check will judge it; what it would refuse is not begun. Only reads
//!    are sent.
//! 2. If an error is pending, a data check comes next and everything is read anew, so that later errors can be seen.
//! 3. What differs is written, in the order of the services.
//! 4. One data check makes it count.
//! 5. Everything is read back and compared, and the position is looked at.
//!
//! A data check also makes values count that were programmed earlier and never checked: the position may jump. So it is
//! a step of its own ([`Prepared::check`], [`Prepared::run`], [`Prepared::run_checked`]) for which a user is asked, and
//! where nothing differs none is run unless it is asked for.
//!
//! If a step fails, the old values are written back and checked in the same way. The report says in any case what
//! every parameter holds now, or that it is not known.

use core::fmt;

use encoring_words::change::ParameterChange;
use encoring_words::model::{Effect, Sensor, SensorKind};
use encoring_words::number::{Base, TypedValue};
use encoring_words::parameter::{Code, CountingDirection, PARAMETERS, ParameterSet};
use encoring_words::word::{DATA_MAX, In};
use encoring_words::{Duration, ErrorStatus, InWord, Model, Parameter};

use crate::preset::position;
use crate::request::Request;
use crate::service::{Check, Failure, Refusal, Services, check, read, write};
use crate::session::Fate;

/// So often a position that the values do not allow is looked at.
const LOOKS: u32 = 3;

/// The time between two of these looks.
const BETWEEN_LOOKS: Duration = Duration::from_millis(20);

/// What to program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Program {
    model: Model,
    sensor: Sensor,
    wanted: [Option<ParameterChange>; PARAMETERS.len()],
}

/// How it went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report<E> {
    /// One row for each parameter of the model.
    pub rows: [Option<ParameterRow>; PARAMETERS.len()],
    /// What IN showed before.
    pub shown_before: Option<InWord>,
    /// What IN shows now.
    pub shown_after: Option<InWord>,
    /// Errors of before, as the data check told them.
    pub earlier: ErrorStatus,
    /// A data check has found the values good and made them count.
    pub checked: bool,
    /// What became of the old values if a step failed.
    pub back: Back,
    /// `Ok` if everything was done and verified.
    pub result: Result<(), Stopped<E>>,
}

/// One parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterRow {
    /// Which.
    pub parameter: Parameter,
    /// What it held before; `None` if it was not read.
    pub before: Option<u32>,
    /// What it shall hold, as the encoder stores it; `None` if it was to stay, and if that depends on what was not
    /// read.
    pub wanted: Option<u32>,
    /// What it holds now; `None` if that is not known.
    pub now: Option<u32>,
    /// The base in which it was typed.
    pub base: Base,
}

/// A number above the measuring length that stands beside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AboveLength {
    /// Which.
    pub parameter: Parameter,
    /// The number, in the base in which it was typed.
    pub value: TypedValue,
    /// The measuring length.
    pub length: u32,
}

impl fmt::Display for AboveLength {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { parameter, value, length } = *self;
        write!(f, "{} {value} is above the measuring length {}", parameter.key(), value.like(length))
    }
}

/// What became of the old values after a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Back {
    /// There was nothing to take back: nothing had been written.
    NothingWritten,
    /// Nothing failed.
    NotNeeded,
    /// They were written back, checked and read back.
    Restored,
    /// They could not be written back completely: the rows say what is known. Which values the position is computed
    /// with is not known.
    Failed,
}

/// Why programming stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopped<E> {
    /// A service failed.
    Service(Failure<E>),
    /// The data check would refuse the values; nothing was written.
    WouldBeRefused(ErrorStatus),
    /// The data check refused them.
    NotAccepted(Check),
    /// A parameter holds another value than the one that was acknowledged.
    NotStored {
        /// Which.
        parameter: Parameter,
        /// What was written.
        wanted: u32,
        /// What was read back.
        read: u32,
    },
    /// A part of a parameter would be stored as something else, because of its other parts; nothing was written.
    Overruled {
        /// Which.
        parameter: Parameter,
        /// What was to be stored.
        asked: u32,
        /// What would be.
        stored: u32,
    },
    /// A parameter cannot be read: with an error pending that remains, a 0 may also be a record that cannot be read.
    Unreadable {
        /// Which.
        parameter: Parameter,
    },
    /// With the new values accepted, IN shows what they do not allow.
    Position {
        /// The word.
        shown: InWord,
        /// The largest position that they allow.
        length: u32,
    },
}

impl ParameterRow {
    /// `true` if it is to get another value than it has.
    #[must_use]
    pub fn changes(&self) -> bool {
        self.wanted.is_some() && self.wanted != self.before
    }

    fn asked(&self) -> Option<u32> {
        self.wanted.or(self.before)
    }

    /// What a data check finds above the measuring length [R70, R90] when these rows are as they shall be.
    pub fn above_length<'a>(
        rows: impl Iterator<Item = &'a Self> + Clone,
        model: Model,
    ) -> impl Iterator<Item = AboveLength> {
        let length = rows.clone().find(|row| row.parameter == Parameter::MeasuringLength);
        let length = length.and_then(Self::asked).unwrap_or(DATA_MAX);
        rows.filter_map(move |row| {
            let number = row.asked()?;
            let takes = model.lists(row.parameter.service())?.takes;
            let refused = takes.invalid_beside(number, length) != takes.invalid(number);
            let value = TypedValue { number, base: row.base };
            refused.then_some(AboveLength { parameter: row.parameter, value, length })
        })
    }
}

impl<E> From<Failure<E>> for Stopped<E> {
    fn from(failure: Failure<E>) -> Self {
        Self::Service(failure)
    }
}

impl Program {
    /// Nothing to program yet. `steps_per_turn` is that of the rating plate; without it, it is taken to be the largest
    /// that the model can have. A rod has none.
    #[must_use]
    pub const fn new(model: Model, steps_per_turn: Option<u32>) -> Self {
        let sensor = match (model.sensor_kind(), steps_per_turn) {
            (SensorKind::Rotary, Some(steps_per_turn)) => Sensor::Rotary { steps_per_turn },
            _ => model.finest_sensor(),
        };
        Self { model, sensor, wanted: [None; PARAMETERS.len()] }
    }

    /// Adds a value, or what shall become of a part of one.
    ///
    /// # Errors
    /// [`crate::RequestError`] if the encoder would refuse it.
    pub fn set(
        &mut self,
        parameter: Parameter,
        change: impl Into<ParameterChange>,
    ) -> Result<(), crate::RequestError> {
        let change = change.into();
        // The parts that stay are legal, whatever they are.
        let others = ParameterSet::factory(self.model, self.sensor).value(parameter);
        Request::write(self.model, parameter, change.of(others))?;
        if let Some(wanted) = self.wanted.get_mut(parameter as usize) {
            *wanted = Some(change);
        }
        Ok(())
    }

    fn change(&self, parameter: Parameter) -> Option<ParameterChange> {
        self.wanted.get(parameter as usize).copied().flatten()
    }

    /// The value that a parameter is to get, as the encoder stores it; `None` also if what it held is needed for that
    /// and not known.
    #[must_use]
    pub fn wanted(&self, parameter: Parameter, before: Option<u32>) -> Option<u32> {
        let change = self.change(parameter)?;
        let old = if change.is_whole() { Some(0) } else { before };
        let asked = change.of(old?).number;
        // A legal value has a normalised form.
        let normalised = parameter.normalise(self.model, asked);
        debug_assert!(normalised.is_ok(), "{parameter:?}: {normalised:?}");
        Some(normalised.unwrap_or(asked))
    }

    /// The model.
    #[must_use]
    pub const fn model(&self) -> Model {
        self.model
    }

    /// What the data check will say of `set` with the wanted values in it.
    #[must_use]
    pub fn judge(&self, mut set: ParameterSet) -> ErrorStatus {
        for parameter in PARAMETERS {
            if let Some(wanted) = self.wanted(parameter, Some(set.value(parameter))) {
                set.set(parameter, wanted);
            }
        }
        set.validity(self.model, self.sensor)
    }

    /// Reads everything and judges it. Only reads are sent.
    pub fn prepare<S: Services>(self, services: &mut S) -> Prepared<S::Error> {
        let mut prepared = Prepared::new(self);
        prepared.stopped = prepared.read(services, Doubts::Stay).err();
        prepared
    }

    /// Programs, checks and verifies, with a data check first if an error is pending.
    pub fn run<S: Services>(self, services: &mut S) -> Report<S::Error> {
        let prepared = self.prepare(services);
        if prepared.error_pending() { prepared.check(services).run(services) } else { prepared.run(services) }
    }
}

/// A program that has looked at its encoder and written nothing yet.
#[derive(Clone, Copy, Debug)]
pub struct Prepared<E> {
    program: Program,
    rows: [Option<ParameterRow>; PARAMETERS.len()],
    shown_before: Option<InWord>,
    earlier: ErrorStatus,
    /// A value may have been written, so that the encoder may differ from what it was.
    written: bool,
    checked: bool,
    /// Why it cannot be run.
    stopped: Option<Stopped<E>>,
}

impl<E> Prepared<E> {
    fn new(program: Program) -> Self {
        let rows = PARAMETERS.map(|parameter| {
            let known = parameter.service().known_to(program.model);
            known.then_some(ParameterRow {
                parameter,
                before: None,
                wanted: program.wanted(parameter, None),
                now: None,
                base: program.change(parameter).map_or(Base::Decimal, |change| change.of(0).base),
            })
        });
        let earlier = ErrorStatus::empty();
        Self { program, rows, shown_before: None, earlier, written: false, checked: false, stopped: None }
    }

    /// The model.
    #[must_use]
    pub const fn model(&self) -> Model {
        self.program.model
    }

    /// What the encoder holds, and what it is to hold.
    pub fn rows(&self) -> impl Iterator<Item = &ParameterRow> + Clone {
        self.rows.iter().flatten()
    }

    /// Why it cannot be run: [`Prepared::run`] will say the same and write nothing.
    #[must_use]
    pub const fn stopped(&self) -> Option<&Stopped<E>> {
        self.stopped.as_ref()
    }

    /// What IN showed.
    #[must_use]
    pub const fn shown(&self) -> Option<InWord> {
        self.shown_before
    }

    /// `true` if an error was pending when this was prepared: what reads as 0 may then be a record that cannot be read.
    #[must_use]
    pub const fn error_pending(&self) -> bool {
        matches!(self.shown_before, Some(shown) if shown.error_bit())
    }

    /// `true` if everything that is to be programmed is known to be there already.
    #[must_use]
    pub fn is_programmed(&self) -> bool {
        self.stopped.is_none() && !self.changes()
    }

    /// Errors that were pending, as the data check told them.
    #[must_use]
    pub const fn earlier(&self) -> ErrorStatus {
        self.earlier
    }

    /// `true` if some value will be written.
    #[must_use]
    pub fn changes(&self) -> bool {
        self.rows().any(ParameterRow::changes)
    }

    /// `true` if the same place will have another position afterwards: direction, code or scaling change.
    #[must_use]
    pub fn moves_the_position(&self) -> bool {
        self.rows().any(|row| {
            let moves = !matches!(
                row.parameter,
                Parameter::PresetValue1 | Parameter::PresetValue2 | Parameter::SsiValues
            );
            moves && row.changes()
        })
    }

    /// Runs the data check, so that later errors can be seen, and reads everything anew: what the position was computed
    /// with may have changed.
    pub fn check<S: Services<Error = E>>(self, services: &mut S) -> Self {
        let mut again = Self::new(self.program);
        again.stopped = match check_once_more(services) {
            Ok(check) => {
                again.earlier = check.status;
                again.read(services, Doubts::EndWithCheck).err()
            }
            Err(failure) => Some(failure.into()),
        };
        again
    }

    /// Programs, checks and verifies. If nothing differs only reads are sent, and nothing is checked.
    pub fn run<S: Services<Error = E>>(mut self, services: &mut S) -> Report<E> {
        let result = match self.stopped.take() {
            Some(stopped) => Err(stopped),
            None if self.changes() => self.forward(services),
            None => Ok(()),
        };
        self.report(services, result)
    }

    /// The same with a data check in any case.
    pub fn run_checked<S: Services<Error = E>>(mut self, services: &mut S) -> Report<E> {
        let result = match self.stopped.take() {
            Some(stopped) => Err(stopped),
            None => self.forward(services),
        };
        self.report(services, result)
    }

    fn report<S: Services<Error = E>>(
        mut self,
        services: &mut S,
        result: Result<(), Stopped<E>>,
    ) -> Report<E> {
        let back = match result {
            Ok(()) => Back::NotNeeded,
            Err(_) if !self.written => Back::NothingWritten,
            Err(_) => self.back(services),
        };
        Report {
            rows: self.rows,
            shown_before: self.shown_before,
            shown_after: services.look().ok(),
            earlier: self.earlier,
            checked: self.checked && result.is_ok(),
            back,
            result,
        }
    }

    fn read<S: Services<Error = E>>(&mut self, services: &mut S, doubts: Doubts) -> Result<(), Stopped<E>> {
        self.shown_before = Some(services.look().map_err(Failure::Bus)?);
        find_out(services, self.program.model, &mut self.rows, doubts, |_| true)?;
        for row in self.rows.iter_mut().flatten() {
            row.before = row.now;
            row.wanted = self.program.wanted(row.parameter, row.before);
        }
        self.overruled()?;
        // Where nothing is written, or no data check looks at the values together, the others do not matter.
        let together = self.changes() && self.program.model.effect() == Effect::AtDataCheck;
        let mut unreadable = self.rows().filter(|row| row.before.is_none());
        if let Some(row) =
            unreadable.clone().find(|row| together || self.program.change(row.parameter).is_some())
        {
            return Err(Stopped::Unreadable { parameter: row.parameter });
        }
        if unreadable.next().is_some() && !together {
            return Ok(());
        }
        // A parameter that the model lacks stays as the factory leaves it.
        let mut set = ParameterSet::factory(self.program.model, self.program.sensor);
        for row in self.rows() {
            if let Some(value) = row.before {
                set.set(row.parameter, value);
            }
        }
        let refused = self.program.judge(set);
        if refused.is_empty() { Ok(()) } else { Err(Stopped::WouldBeRefused(refused)) }
    }

    /// A part that the encoder would store as something else because of the parts that stay [R119].
    fn overruled(&self) -> Result<(), Stopped<E>> {
        for row in self.rows() {
            if let (Some(change), Some(stored)) = (self.program.change(row.parameter), row.wanted)
                && !change.is_whole()
                && change.of(stored).number != stored
            {
                let asked = change.of(stored).number;
                return Err(Stopped::Overruled { parameter: row.parameter, asked, stored });
            }
        }
        Ok(())
    }

    fn forward<S: Services<Error = E>>(&mut self, services: &mut S) -> Result<(), Stopped<E>> {
        for row in self.rows.iter_mut().flatten().filter(|row| row.changes()) {
            if let Some(wanted) = row.wanted {
                let stored = store(services, self.program.model, row, wanted);
                let as_before = stored.as_ref().is_err_and(Failure::is_not_sent) && row.now == row.before;
                self.written |= !as_before;
                stored?;
            }
        }
        self.accept(services)?;
        let (model, rows) = (self.program.model, &mut self.rows);
        explained(services, |services| {
            find_out(services, model, rows, Doubts::EndWithCheck, |row| row.wanted.is_some())
        })?;
        for row in self.rows.iter().flatten() {
            match (row.wanted, row.now) {
                (Some(wanted), Some(read)) if read != wanted => {
                    return Err(Stopped::NotStored { parameter: row.parameter, wanted, read });
                }
                (Some(_), None) => return Err(Stopped::Unreadable { parameter: row.parameter }),
                _ => {}
            }
        }
        self.look(services)
    }

    /// One data check. What was pending before is told by it and over, so a second one must find nothing.
    fn accept<S: Services<Error = E>>(&mut self, services: &mut S) -> Result<(), Stopped<E>> {
        let mut checked = check_once_more(services)?;
        if !checked.remains && !checked.status.is_empty() {
            self.earlier |= checked.status;
            checked = check_once_more(services)?;
        }
        // A magnet that is away says nothing of the values [R95].
        let magnet = checked.status == ErrorStatus::OUTSIDE_RANGE;
        self.checked = checked.is_good() || magnet;
        if self.checked { Ok(()) } else { Err(Stopped::NotAccepted(checked)) }
    }

    /// No position may lie above the largest, and no error be pending, unless the magnet of a rod can be away.
    /// A gateway may spoil a word, so it is looked several times before that is said.
    fn look<S: Services<Error = E>>(&self, services: &mut S) -> Result<(), Stopped<E>> {
        let mut looked = self.look_once(services);
        for _ in 1..LOOKS {
            if !matches!(looked, Err(Stopped::Position { .. })) {
                break;
            }
            services.wait(BETWEEN_LOOKS);
            looked = self.look_once(services);
        }
        looked
    }

    fn look_once<S: Services<Error = E>>(&self, services: &mut S) -> Result<(), Stopped<E>> {
        let shown = services.look().map_err(Failure::Bus)?;
        let now = |parameter| self.rows.iter().flatten().find(|row| row.parameter == parameter)?.now;
        let length = now(Parameter::MeasuringLength).unwrap_or(DATA_MAX);
        let model = self.program.model;
        let code = match now(Parameter::CountingDirection) {
            Some(value) if model.position_may_be_gray() => CountingDirection::from_data(value).code,
            _ => Code::Binary,
        };
        let legal = position(shown, code).is_some_and(|value| value <= model.largest_position(length));
        let magnet = model.status_mask().contains(ErrorStatus::OUTSIDE_RANGE);
        let faulty = matches!(shown.decode(), In::Position { error: true, .. }) && !magnet;
        if legal && !faulty { Ok(()) } else { Err(Stopped::Position { shown, length }) }
    }

    /// Writes the old values back, has them checked, and finds out what is there.
    fn back<S: Services<Error = E>>(&mut self, services: &mut S) -> Back {
        let model = self.program.model;
        let mut restored = true;
        for row in self.rows.iter_mut().flatten() {
            if let (Some(before), Some(_)) = (row.before, row.wanted)
                && row.now != Some(before)
            {
                restored &= store(services, model, row, before).is_ok();
            }
        }
        let accepted = check_once_more(services);
        // Errors of the failure itself may be told once.
        let accepted = match accepted {
            Ok(checked) if !checked.remains && !checked.status.is_empty() => check_once_more(services),
            accepted => accepted,
        };
        restored &= accepted.is_ok_and(|checked| !checked.remains);
        for row in self.rows.iter_mut().flatten().filter(|row| row.wanted.is_some()) {
            // One by one, so that one that fails leaves the others known.
            let mut alone = [Some(ParameterRow { now: None, ..*row })];
            let _ = find_out(services, model, &mut alone, Doubts::EndWithCheck, |_| true);
            let [alone] = alone;
            row.now = alone.and_then(|row| row.now);
            restored &= row.now == row.before;
        }
        if restored { Back::Restored } else { Back::Failed }
    }
}

/// Writes one value. After a time-out the value is read back, and written once more if it is not there: writing the
/// same value twice does the same as writing it once.
fn store<S: Services>(
    services: &mut S,
    model: Model,
    row: &mut ParameterRow,
    value: u32,
) -> Result<(), Failure<S::Error>> {
    let request = Request::write(model, row.parameter, value).map_err(Failure::Request)?;
    let mut tried = write(services, request);
    if let Err(Failure::TimedOut { timed_out, .. }) = tried
        && !matches!(timed_out.fate, Fate::CarriedOut(_))
    {
        row.now = None;
        row.now = read(services, model, row.parameter)?.sure();
        if row.now == Some(value) {
            return Ok(());
        }
        tried = write(services, request);
    }
    match tried {
        Ok(_) => {
            row.now = Some(value);
            Ok(())
        }
        Err(failure) => {
            // A value that was refused or not sent leaves what is there; after anything else nobody knows.
            if !matches!(failure, Failure::Refused(_)) && !failure.is_not_sent() {
                row.now = None;
            }
            Err(failure)
        }
    }
}

/// The data check; if it gets no answer once more, which does no harm.
fn check_once_more<S: Services>(services: &mut S) -> Result<Check, Failure<S::Error>> {
    match check(services) {
        Err(Failure::TimedOut { .. }) => check(services),
        checked => checked,
    }
}

/// What becomes of a 0 that may be a record that cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Doubts {
    /// It stays unknown: only reads are sent.
    Stay,
    /// A data check tells: a record that could not be read has left its mark in the status; an LA-66 shows none [R95].
    EndWithCheck,
}

/// Reads what the picked rows hold now; what cannot be read is not known.
fn find_out<S: Services>(
    services: &mut S,
    model: Model,
    rows: &mut [Option<ParameterRow>],
    doubts: Doubts,
    pick: impl Fn(&ParameterRow) -> bool,
) -> Result<(), Failure<S::Error>> {
    let mut doubtful = false;
    for row in rows.iter_mut().flatten().filter(|row| pick(row)) {
        row.now = None;
        row.now = read(services, model, row.parameter)?.sure();
        doubtful |= row.now.is_none();
    }
    let marked = model.status_mask().contains(ErrorStatus::READING_DATA);
    if doubtful && doubts == Doubts::EndWithCheck && marked {
        let status = check_once_more(services)?.status;
        if !status.contains(ErrorStatus::READING_DATA) {
            for row in rows.iter_mut().flatten().filter(|row| pick(row)) {
                row.now.get_or_insert(0);
            }
        }
    }
    Ok(())
}

/// Has a data check tell why the encoder refused a read.
fn explained<S: Services>(
    services: &mut S,
    work: impl FnOnce(&mut S) -> Result<(), Failure<S::Error>>,
) -> Result<(), Failure<S::Error>> {
    match work(services) {
        Err(Failure::Refused(refusal @ Refusal { check: None, .. })) => {
            let check = Some(check_once_more(services)?);
            Err(Failure::Refused(Refusal { check, ..refusal }))
        }
        other => other,
    }
}
