//! What was judged, and what could not be, in sentences.

use encoring_texts::{Said, texts};
use encoring_words::Duration;

texts! {
    "judged";

    fn half_line(line: &str) = "a half line at the end is left out: {line}";
    fn rows(position: u8, rows: u64, positions: u64, period_ns: Duration) =
        "position {position}: {rows} rows, {positions} of them positions, {period_ns} apart";
    fn rows_only(position: u8, rows: u64, positions: u64) =
        "position {position}: number of rows {rows}, of positions {positions}";
    fn given(position: u8, positions: i64) = "position {position}: {positions} positions, as given";
    fn given_until(position: u8, positions: i64, line: u64) =
        "position {position}: {positions} positions, as given, up to line {line}, where a data check made another scaling active";
    fn no_end(position: u8, most: i64) =
        "position {position}: S is at least {most}: no end of the range was seen";
    fn ends(position: u8, positions: i64, times: usize) =
        "position {position}: about {positions} positions: their end was seen {times} times";
    fn refresh(position: u8, refresh_ns: Duration) =
        "position {position}: refreshed every {refresh_ns}, measured: by the encoder, or by what carries its words";
    fn not_reached(position: u8, rows: u64, place: Said, master: Said) =
        "position {position}: {rows} rows hold no position, the first at {place}: {master}";
    fn few(position: u8) = "position {position}: fewer than three positions: nothing can be judged";
    fn any_jump(position: u8) =
        "position {position}: at this period no jump can be judged: half of the positions can be passed from row to row";
    fn small_jump(position: u8, steps: i64) =
        "position {position}: at this period no jump of up to {steps} steps can be judged";
    fn larger_jump(position: u8, steps: i64, motion: i64) =
        "position {position}: at this period no jump of up to {steps} steps can be judged; one of up to {motion} may be \
         motion within the data sheet";
    fn beyond_given(position: u8, positions: i64, last: i64, rows: u64, first: i64, line: u64) =
        "position {position}: {positions} positions are given, 0 to {last}, and {rows} rows have others, the first \
         {first} at line {line}: these are wrong, or another scaling was active";
    fn beyond_word(position: u8, last: u32, rows: u64, first: i64, line: u64) =
        "position {position}: no encoder shows positions outside 0 to {last}, and {rows} rows have others, the first \
         {first} at line {line}: these are wrong, or all are scaled by something else";
    fn scaled(position: u8) =
        "position {position}: S was not looked for: some positions are none that an encoder shows";
    fn known_missed(position: u8, steps: i64, time_ns: Duration) =
        "position {position}: the known place {steps} at {time_ns} was not compared: no row is near that time";
    fn other_end(position: u8, positions: i64, times: usize, seen: i64) =
        "position {position}: {positions} positions are given, and {times} times they begin again after about {seen}: \
         these are wrong, or another scaling was active";
    fn never_moved(position: u8) =
        "position {position}: it never moved: code, order of the halves, scaling, direction and held bits do not show";
    fn no_refresh(position: u8) =
        "position {position}: the refresh time is not visible at this period or speed";
    fn no_scale(position: u8) =
        "position {position}: N, D and the counting direction do not show in positions; speed and acceleration were \
         judged as steps only: give --parameters";
    fn no_out(position: u8) =
        "position {position}: without OUT in every row presets and scalings are seen only by their replies";
}
