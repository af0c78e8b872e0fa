//! The difference of two states, as a merge patch (RFC 7386).

use serde_json::{Map, Value};

/// What makes `is` of `was`; `None` if they are the same. Lists are replaced whole.
///
/// A key that is gone is `null` in a patch, so a `null` cannot be put in one: it stands for itself only where the key
/// was `null` before. States keep their keys, and the page reads a missing key as `null`.
pub(crate) fn difference(was: &Value, is: &Value) -> Option<Value> {
    if was == is {
        return None;
    }
    let (Value::Object(was), Value::Object(now)) = (was, is) else { return Some(is.clone()) };
    let gone = was.keys().filter(|key| !now.contains_key(*key)).map(|key| (key.clone(), Value::Null));
    let changed = now.iter().filter_map(|(key, value)| {
        let change = match was.get(key) {
            Some(before) => difference(before, value)?,
            None => value.clone(),
        };
        Some((key.clone(), change))
    });
    Some(Value::Object(gone.chain(changed).collect::<Map<_, _>>()))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// As the RFC has it.
    fn merged(target: Value, patch: Value) -> Value {
        let Value::Object(patch) = patch else { return patch };
        let mut target = match target {
            Value::Object(target) => target,
            _ => Map::new(),
        };
        for (key, value) in patch {
            match value {
                Value::Null => drop(target.remove(&key)),
                value => {
                    let before = target.remove(&key).unwrap_or_default();
                    target.insert(key, merged(before, value));
                }
            }
        }
        Value::Object(target)
    }

    #[test]
    fn a_patch_holds_what_has_changed_and_makes_one_of_the_other() {
        let was = json!({ "a": 1, "b": { "c": [1, 2], "d": "x" }, "gone": true, "same": { "e": 1 } });
        let is = json!({ "a": 1, "b": { "c": [1, 3], "d": "x" }, "new": { "f": 2 }, "same": { "e": 1 } });
        let patch = difference(&was, &is).unwrap();
        assert_eq!(patch, json!({ "b": { "c": [1, 3] }, "gone": null, "new": { "f": 2 } }));
        assert_eq!(merged(was.clone(), patch), is);
        assert_eq!(difference(&was, &was), None);
    }

    #[test]
    fn a_value_that_becomes_null_is_missing_afterwards() {
        let (was, is) = (json!({ "a": 1 }), json!({ "a": null }));
        let patch = difference(&was, &is).unwrap();
        assert_eq!(merged(was, patch), json!({}));
    }
}
