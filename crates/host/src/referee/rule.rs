//! The rules: their names, how much each matters, what it rests on, from where it can be judged, what to do instead.

use encoring_words::Duration;

/// Where the observer stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vantage {
    /// Every write of a register, and every ring cycle.
    Writes,
    /// The master's image at every ring cycle.
    Cycles,
    /// The exchanges at the encoder: its chip has taken away a service bit that was left standing, the IN word of a
    /// row answers its OUT word, and cycles that failed are not there.
    Exchanges,
    /// The log of a controller or a gateway: what stood there when it looked.
    Log,
}

impl Vantage {
    /// Its letter in files and in JSON.
    #[must_use]
    pub const fn letter(self) -> &'static str {
        match self {
            Self::Writes => "w",
            Self::Cycles => "c",
            Self::Exchanges => "x",
            Self::Log => "p",
        }
    }
}

/// How sure a rule is from a vantage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RuleCertainty {
    /// What it names has happened.
    Certain,
    /// A right program could look the same.
    Suspected,
    /// It cannot be seen from there.
    NotJudged,
}

/// How much a break of a rule matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// A service may go wrong, or an error is not seen.
    Error,
    /// It works, and does harm in time.
    Warning,
    /// Worth knowing.
    Note,
}

/// The rules of the order of the handshake, which no master breaks that keeps it, whatever happens to the ring, to the encoder, or
/// to what it asks for.
pub const ORDER: [HandshakeRule; 7] = [
    HandshakeRule::DataWithServiceBit,
    HandshakeRule::TornWords,
    HandshakeRule::DataChangedInService,
    HandshakeRule::DroppedBeforeAcknowledgement,
    HandshakeRule::NeverDropped,
    HandshakeRule::NextBeforeEnd,
    HandshakeRule::ForeignReply,
];

impl Severity {
    /// Its name in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Note => "note",
        }
    }
}

/// A drop so long after the rise is a withdrawal and no break: whoever waits must give up some time.
pub const WITHDRAWAL: Duration = Duration::from_millis(1_000);
/// A request without a reply, or a reply without its end, is told after this time, or at the end of what is seen if it
/// has stood for [`WITHDRAWAL`].
pub const STANDS_LONG: Duration = Duration::from_secs(10);
/// After the last write the data check is expected within this time.
pub const CHECK_WITHIN: Duration = Duration::from_secs(10);
/// After a set error bit the error status is expected to be requested within this time.
pub const STATUS_WITHIN: Duration = Duration::from_millis(1_000);
/// An error bit in normal mode that stands for less than this when another service is requested may not have been seen
/// yet: two scans of 100 ms.
pub const ERROR_SEEN: Duration = Duration::from_millis(200);
/// The bus is reset after so long without a telegram, and a service bit that stands through it is no request [D1].
pub const BUS_RESET: Duration = Duration::from_millis(25);
/// So many in a row are "again and again".
pub const AGAIN: u32 = 10;
/// A pause of this length ends a row of writes: once in 10 minutes is 100,000 writes in two years.
pub const WRITE_PAUSE: Duration = Duration::from_secs(600);
/// A pause of this length ends a circle of reads.
pub const READ_PAUSE: Duration = Duration::from_secs(10);
/// A preset adjustment to the same value within this time is a repetition.
pub const PRESET_AGAIN: Duration = Duration::from_secs(10);
/// A position that has changed in this time before a preset adjustment is moving.
pub const MOVING: Duration = Duration::from_millis(100);

macro_rules! rules {
    ($($(#[$doc:meta])* $rule:ident $name:literal $severity:ident [$w:ident $c:ident $x:ident $p:ident]
        $statement:literal $advice:literal;)*) => {
        /// A rule, with what starts it, what ends it, and where it is not certain.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum HandshakeRule {
            $($(#[$doc])* $rule,)*
        }

        /// Every rule.
        pub const RULES: [HandshakeRule; [$($name),*].len()] = [$(HandshakeRule::$rule),*];

        impl HandshakeRule {
            /// Its name in files. The rule of equal writes shares that of changing ones.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$rule => $name,)* }
            }

            /// How much a break matters.
            #[must_use]
            pub const fn severity(self) -> Severity {
                match self { $(Self::$rule => Severity::$severity,)* }
            }

            /// How sure it is from a vantage, at best.
            #[must_use]
            pub const fn certainty(self, vantage: Vantage) -> RuleCertainty {
                use RuleCertainty::{Certain, NotJudged, Suspected};
                let [writes, cycles, exchanges, log] = match self { $(Self::$rule => [$w, $c, $x, $p],)* };
                match vantage {
                    Vantage::Writes => writes,
                    Vantage::Cycles => cycles,
                    Vantage::Exchanges => exchanges,
                    Vantage::Log => log,
                }
            }

            /// The statement of a manual, or the decision, that it rests on.
            #[must_use]
            pub const fn statement(self) -> &'static str {
                match self { $(Self::$rule => $statement,)* }
            }

            /// What a PLC program should do instead.
            #[must_use]
            pub const fn advice(self) -> &'static str {
                match self { $(Self::$rule => $advice,)* }
            }
        }
    };
}

rules! {
    /// The service bit rises with the high half of a word, and the low half follows before the reply [R34]. A write of
    /// the low half alone, by the client that wrote the high half, ends it. Ring cycles do not show single writes, so
    /// it is judged from the writes only.
    TornWords "torn_words" Error [Certain NotJudged NotJudged NotJudged]
        "R34" "write both halves in one request, or the low half first and the half with the service bit last";
    /// Number or data change in the same step in which the service bit rises [R33]. Of a read only bits 30 and 27..24
    /// count [R35]. Certain where single writes are seen: a right program may write twice between two ring cycles or two
    /// rows of a log.
    DataWithServiceBit "data_with_service_bit" Error [Certain Suspected Suspected Suspected]
        "R33" "put out number and data with service bit 0, and raise the bit one PLC cycle later";
    /// Number or data change between the rise of the service bit and the reply [R34]. Behind the reply everything is
    /// allowed [R41]. In a log the reply may have come between two rows.
    DataChangedInService "data_changed_in_service" Error [Certain Certain Certain Suspected]
        "R34" "leave number and data as they are until the reply is there";
    /// The service bit falls less than a second after its rise, and no reply was seen [R38, R40]. A fall while the ring
    /// is stopped is right. Suspected in exchanges if the word falls to 0: so it does too in a reset of the bus.
    DroppedBeforeAcknowledgement "dropped_before_acknowledgement" Error [Certain Certain Certain Suspected]
        "R38" "wait for IN bit 31 before the service bit is taken back";
    /// The same a second or more after the rise: whoever waits must give up some time. The encoder may have carried the
    /// service out [C42].
    Withdrawn "withdrawn" Note [Certain Certain Certain Suspected]
        "R38" "find out why the encoder did not answer; read the value before the service is repeated";
    /// The reply has stood for 10 s and the service bit with it, or for 1 s at the end of what is seen [R38]. A log may
    /// have missed the falls of a service that is requested again and again.
    NeverDropped "never_dropped" Error [Certain Certain Certain Suspected]
        "R38" "take the service bit back as soon as the reply was read: until then there is no position";
    /// The service bit rises while the reply to the service before is still shown [R39, R40]. Seen by the IN word of the
    /// image, so not in exchanges, where IN answers OUT in the same row, and not in a log.
    NextBeforeEnd "next_before_end" Error [Certain Certain NotJudged NotJudged]
        "R39" "wait for IN bit 31 = 0 before the next request";
    /// The service bit falls after a reply that is not that of the request, and its own was not seen [R25, R26]. In
    /// exchanges the reply stands a cycle before the controller can see it, and a log may have missed the right one.
    ForeignReply "foreign_reply" Error [Certain Certain Suspected Suspected]
        "R26" "compare bits 30 and 27..24 of the reply with the request, and for a write the data too";
    /// A request has stood for 10 s without its reply, or for 1 s at the end of what is seen [R36].
    NeverAcknowledged "never_acknowledged" Warning [Certain Certain Certain Suspected]
        "R36" "watch the time of a service, and take the bit back after a second";
    /// Programmed values were not followed by a data check within 10 s, or by none before a preset adjustment [R79,
    /// R80]. Encoders that take every value over at once need none. A log may have missed it; without the model it is
    /// suspected where only some models need it.
    NoDataCheck "no_data_check" Warning [Certain Certain Certain Suspected]
        "R79" "request the data check (08) after the last value: before it the encoder works with the old ones";
    /// A reply had bit 29, and within 1 s the error status (08) was not requested [R82].
    StatusNotRead "status_not_read" Warning [Certain Certain Certain Suspected]
        "R82" "request 08 after a reply with bit 29: it tells the error and resets it";
    /// Bit 29 stood in normal mode for 1 s without a request of 08, or another service was requested first [R83, R143].
    /// If it was in no reply and stood for less than 200 ms, it may not have been seen. Whether the axis was stopped is
    /// not on the bus.
    ErrorIgnored "error_ignored" Error [Certain Certain Certain Suspected]
        "R143" "look at bit 29 in every cycle, stop the axis, and request 08";
    /// A write of a value that the model refuses, or that is an error as long as it stands [R54, R57, R58, R74, R75,
    /// R115]. A preset adjustment above the measuring length is judged once that length was seen.
    OutOfRange "out_of_range" Error [Certain Certain Certain Certain]
        "R75" "keep the value within the range of the manual";
    /// A request of a service that the model does not list [R89]; without the model, that no model lists.
    UnknownService "unknown_service" Error [Certain Certain Certain Certain]
        "R89" "correct the service number";
    /// A write of 08, or a read of 06 [R87, R88].
    WrongDirection "wrong_direction" Error [Certain Certain Certain Certain]
        "R155" "08 is read with bit 30 = 0, 06 is written with bit 30 = 1";
    /// The same parameter was written with another value ten times, never more than 10 minutes apart [R97]. That a cell
    /// stands 100,000 writes is assumed.
    MemoryWear "memory_wear" Warning [Certain Certain Certain Certain]
        "R97" "program values once, not in a circle: every change is written to the EEPROM";
    /// The same with equal values: they do not wear the simulated memory, which is a decision of this project.
    EqualWrites "memory_wear" Note [Certain Certain Certain Certain]
        "R97" "program values once: whether a real encoder writes equal values to its EEPROM is not known";
    /// The same value was read ten times, never more than 10 s apart: while a service is shown there is no position
    /// [R26].
    Polled "polled" Note [Certain Certain Certain Certain]
        "R26" "read a parameter once: as long as a reply is shown there is no position";
    /// A preset adjustment to the same value within 10 s of the one before [R73].
    PresetRepeated "preset_repeated" Warning [Certain Certain Certain Certain]
        "R73" "do not repeat a preset adjustment: if the shaft has moved, the zero moves with it";
    /// The position changed within 100 ms before a preset adjustment, or until its reply [R73].
    PresetWhileMoving "preset_while_moving" Warning [Certain Certain Certain Suspected]
        "R73" "stop the axis before a preset adjustment";
    /// The service bit stands in the first good cycle after the ring stopped for 25 ms or more [D1]. Needs to be told of
    /// the line, or in a log of the master's status.
    StaleServiceBit "stale_service_bit" Error [Certain Certain NotJudged Suspected]
        "D1" "take the service bit back when the ring has stopped, and request the service anew";
}
