//! What speaks for a cause, in sentences. The terminal has the English ones, the page those of its own language.

use encoring_texts::{Decimal, Hex, Said, texts};
use encoring_words::Duration;

texts! {
    "evidence";

    fn too_fast(speed: i64, rows: usize, limit: i64) =
        "{speed} steps a second over {rows} rows; {limit} are permissible";
    fn too_sudden(change: i64, rows: usize, limit: i64) =
        "the speed changes by {change} steps in {rows} rows; {limit} are permissible";
    fn too_sudden_between(change: i64, rows: i64, limit: i64) =
        "the speed changes by {change} steps a row in {rows} rows; {limit} are permissible";
    fn with_another(position: u8) = "position {position} has an event at the same time";
    fn alone() = "no other encoder of the recording has an event at that time";
    fn behind(word: Said, before: Said) = "{word} behind {before}";
    fn in_word(word: Hex<8>) = "IN {word}";
    fn bits_24(bits: Hex<6>) = "{bits}h";
    fn bits_16(bits: Hex<4>) = "{bits}h";
    fn steps(steps: i64) = "{steps}";
    fn nothing() = "nothing";
    fn as_gray(rows: usize) = "{rows} rows are where those around them lead, read as Gray code";
    fn as_binary(rows: usize) =
        "{rows} rows are where those around them lead, if they are what a reader of Gray code made of binary";
    fn as_exchanged(rows: usize) =
        "{rows} rows are where those around them lead, if their halves are exchanged and bits 31..24 were not kept";
    fn scatter(scatter: i64, quiet: i64) =
        "second differences of {scatter} steps, each taken back by the next; {quiet} in the quiet part";
    fn held(bit: u32) = "bit {bit} is the same in all these rows";
    fn beat() = "values stand twice, then a step of two: rows come faster than the refresh";
    fn exchanged(word: Hex<8>) = "with its halves exchanged IN {word} is where the rows around it lead";
    fn foreign_bit(word: Hex<8>, bit: u32) = "IN {word} has bit {bit}, which no encoder sets in a position";
    fn half_of_position(word: Hex<8>) =
        "the low half of IN {word} is that of a position, the high half is not";
    fn reply(word: Hex<8>, service: Hex<2>) = "IN {word} has bit 31: it is a reply to service {service}";
    fn asked(word: Hex<8>) = "OUT {word} asks for it";
    fn foreign_bits(word: Hex<8>) = "IN {word} has bits that no encoder sets";
    fn from_known(steps: i64) = "{steps} steps further from the known place than at the one before";
    fn pause(pause_ns: Duration) = "between both lies a pause of {pause_ns}";
    fn like_motion(rows: usize) = "the last {rows} words do not tell it from motion";
    fn torn(from: Hex<4>, to: Hex<4>) =
        "the high half goes from {from}h to {to}h here, and with the other of both it is where the rows around it lead";
    fn low_is_high() =
        "the low half is the high half of where the rows around it lead, and bits 15..8 are 0";
    fn data_of_reply(data: Hex<6>) = "OUT has the service bit in these rows: {data}h are the data of a reply";
    fn data_of_service(data: Hex<6>) = "{data}h are the data of a service";
    fn data_of_check() = "0 are the data of a data check without an error";
    fn one_bit(bit: u32) = "bit {bit} changed puts it where the rows around it lead";
    fn away_and_back(rows: usize) = "{rows} rows away, and back on the curve";
    fn shorter_way(positions: i64) = "the shorter way leads over the end of {positions} positions";
    fn end_to_end(positions: i64) = "from one end of {positions} positions to the other, at the same speed";
    fn stood(rows: usize, steps: i64) =
        "the same word in {rows} rows, then {steps} steps, which is the way at the speed before and behind";
    fn at_zero(steps: i64) = "{steps} steps at 0, against the motion, and on at the same speed";
    fn line(line: u64) = "line {line}";
    fn poll(line: u64) = "poll {line}";
    fn preset_at(value: Hex<6>, place: Said) = "service 06 with {value}h is at {place}";
    fn preset_off(steps: i64) = "the position is {steps} steps from that value now";
    fn scaling_written(place: Said) = "a scaling was written at {place}";
    fn direction_written(place: Said) = "service 01 was written at {place}";
    fn scaling_checked(place: Said) =
        "the data check made the scaling active that was written at {place}";
    fn direction_checked(place: Said) =
        "the data check made service 01 active that was written at {place}";
    fn other_way() = "the positions run as fast as before, and the other way";
    fn mirrored(steps: i64) = "the position is S minus the one before, within {steps} steps";
    fn ratio(ratio: Decimal) = "position and speed are both {ratio} times what they were";
    fn same_speed(steps: i64) = "{steps} steps, and on at the same speed";
    fn aimed(aim: i64) = "it went on from {aim}, which a preset may aim at";
    fn no_preset() = "OUT asks for no service, and the encoder has no preset input";
    fn other_speed(steps: i64, from: i64, to: i64) = "{steps} steps, from {from} to {to} steps a second";
    fn not_reached(from: Said, to: u64, rows: u64, master: Said) =
        "{from} to {to}, {rows} rows with the same word: {master}";
    fn master_says(status: Hex<4>, names: String) =
        "the master's status {status}h ({names}) says that no data cycle reaches the encoder";
    fn master_names(status: Hex<4>, names: String, parameter: Hex<4>) =
        "the master's status {status}h ({names}) and parameter {parameter}h says that no data cycle reaches the encoder";
    fn over_stop(steps: i64) =
        "{steps} steps lie between the positions before and behind; nothing tells how they were made";
    fn stuck(bit: u32, level: u8, rows: usize) =
        "bit {bit} stays {level} in {rows} rows; set free, the rows go on evenly";
    fn offset_differs(pause_ns: Duration, position: u8, steps: i64) =
        "behind a pause of {pause_ns} the offset to position {position} differs by {steps} steps";
    fn other_is_kept(position: u8) = "before, both moved together; position {position} is where it was";
    fn other_had_no_pause(position: u8) = "before, both moved together; position {position} had no pause";
    fn preset_seen(value: Hex<6>, place: Said) = "service 06 with {value}h at {place}";
    fn scaling_seen(place: Said) = "service 02, 03 or 09 written at {place}";
    fn direction_seen(place: Said) = "service 01 written at {place}";
    fn smoother(bits: Decimal, read_so: Decimal) =
        "second differences have {bits} bits as the rows are, and {read_so} read so";
}
