//! Trees of values.

use rand::RngExt;
use serde_json::{Value, json};

use super::{TEXTS, any, places};
use crate::input::Random;

/// The most copies of a value.
const MAX_COPIES: usize = 300;

/// The text of a tree that is changed at a few places.
pub(crate) fn mutated(value: &Value, random: &mut Random) -> String {
    let mut out = value.clone();
    for _ in 0..places(random) {
        let n = random.random_range(0..count(&out));
        if let Some(part) = nth(&mut out, n) {
            mutate(part, random);
        }
    }
    out.to_string()
}

fn count(value: &Value) -> usize {
    1 + match value {
        Value::Array(items) => items.iter().map(count).sum(),
        Value::Object(items) => items.values().map(count).sum(),
        _ => 0,
    }
}

/// The n-th value in the order of the text.
fn nth(value: &mut Value, mut n: usize) -> Option<&mut Value> {
    if n == 0 {
        return Some(value);
    }
    n -= 1;
    let parts: Vec<&mut Value> = match value {
        Value::Array(items) => items.iter_mut().collect(),
        Value::Object(items) => items.values_mut().collect(),
        _ => Vec::new(),
    };
    for part in parts {
        let size = count(part);
        if n < size {
            return nth(part, n);
        }
        n -= size;
    }
    None
}

fn mutate(value: &mut Value, random: &mut Random) {
    match value {
        Value::Array(items) if !items.is_empty() && random.random_range(0..4) > 0 => {
            let (i, j) = (
                random.random_range(0..items.len()),
                random.random_range(0..items.len()),
            );
            match random.random_range(0..5) {
                0 => drop(items.remove(i)),
                1 => items.swap(i, j),
                2 => items.insert(j, items[i].clone()),
                3 => items.truncate(i),
                _ => items.extend(vec![items[i].clone(); random.random_range(2..MAX_COPIES)]),
            }
        }
        Value::Object(items) if !items.is_empty() && random.random_range(0..4) > 0 => {
            let keys: Vec<String> = items.keys().cloned().collect();
            let key = &keys[random.random_range(0..keys.len())];
            let other = &keys[random.random_range(0..keys.len())];
            let own = items.remove(key).unwrap_or_default();
            match random.random_range(0..4) {
                0 => {}
                1 => drop(items.insert("other".into(), own)),
                _ => drop(items.insert(other.clone(), own)),
            }
        }
        _ => *value = any_value(random),
    }
}

fn any_value(random: &mut Random) -> Value {
    let numbers = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        1e308,
        -1e308,
        5e-324,
        1e17,
        4294967296.0,
    ];
    match random.random_range(0..8) {
        0 => Value::Null,
        1 => json!([]),
        2 => json!({}),
        3 => json!(true),
        4 => json!(u64::MAX),
        5 => json!(any(&TEXTS, random)),
        _ => json!(any(&numbers, random)),
    }
}
