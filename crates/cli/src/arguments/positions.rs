//! Several ring positions in one argument, and what is said of the encoders there.

use crate::output::{Failure, bad_input};

/// Ring positions, each once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Positions(pub(crate) Vec<usize>);

impl Positions {
    /// What is given for each of these encoders: one value is meant for all.
    pub(crate) fn each<T: Copy>(&self, option: &str, given: &[T]) -> Result<Vec<Option<T>>, Failure> {
        let count = self.0.len();
        match given {
            [] => Ok(vec![None; count]),
            [all] => Ok(vec![Some(*all); count]),
            each if each.len() == count => Ok(each.iter().copied().map(Some).collect()),
            each => Err(bad_input(format!(
                "{option}: {} values for {count} encoders; give one, or one for each",
                each.len()
            ))),
        }
    }
}

/// Like `2`, `0,2` or `0-2`.
pub(crate) fn positions(text: &str) -> Result<Positions, String> {
    let number =
        |text: &str| super::position(text).map_err(|wrong| format!("{wrong}; write 2 or 0,2 or 0-2"));
    let mut positions = Vec::new();
    for part in text.split(',') {
        let (first, last) = match part.split_once('-') {
            Some((first, last)) => (number(first)?, number(last)?),
            None => (number(part)?, number(part)?),
        };
        if first > last {
            return Err(format!("{part}: the first position is the greater one"));
        }
        for position in first..=last {
            if positions.contains(&position) {
                return Err(format!("position {position} is there twice"));
            }
            positions.push(position);
        }
    }
    Ok(Positions(positions))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_value_is_for_all_encoders_and_several_are_one_for_each() {
        let at = positions("0-2").unwrap();
        assert_eq!(at.each::<u32>("--native", &[]).unwrap(), [None; 3]);
        assert_eq!(at.each("--native", &[4096]).unwrap(), [Some(4096); 3]);
        assert_eq!(at.each("--native", &[1, 2, 3]).unwrap(), [Some(1), Some(2), Some(3)]);
        assert!(at.each("--native", &[1, 2]).is_err());
    }

    #[test]
    fn positions_are_single_or_from_to() {
        for (text, found) in
            [("2", vec![2]), ("0,2", vec![0, 2]), ("0-2", vec![0, 1, 2]), ("3,0-1", vec![3, 0, 1])]
        {
            assert_eq!(positions(text), Ok(Positions(found)), "{text}");
        }
        assert_eq!(positions("0-127").unwrap().0.len(), 128);
        for wrong in
            ["", "-", "1-", "-1", "a", "2-1", "0,0", "0-2,1", "0,", "+1", "70000", "0-128", "0-65535"]
        {
            assert!(positions(wrong).is_err(), "{wrong}");
        }
    }
}
