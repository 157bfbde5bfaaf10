//! Invalid numbers and ids are refused where they are given, with a message that names them.

mod actuators;
mod contact;
mod descriptions;
mod robots;
mod scratch;
mod sizes;

use std::panic::{AssertUnwindSafe, catch_unwind};

const NAN: f64 = f64::NAN;
const INFINITY: f64 = f64::INFINITY;

/// A parameter of a `T`, and invalid values of it.
struct Senseless<T> {
    /// The words that the message must have, with `{}` in place of the value.
    said: &'static str,
    set: fn(&mut T, f64),
    values: &'static [f64],
}

impl<T: Clone> Senseless<T> {
    /// The words for each value, and a function that sets it in a copy of a valid object.
    fn cases<'a>(&'a self, good: &'a T) -> impl Iterator<Item = (String, impl Fn() -> T + 'a)> {
        self.values.iter().map(move |&x| {
            let said = self.said.replace("{}", &x.to_string());
            let set = move || {
                let mut bad = good.clone();
                (self.set)(&mut bad, x);
                bad
            };
            (said, set)
        })
    }
}

/// Copies of a valid object with each invalid value in turn, and the words of the message.
fn spoiled<T: Clone>(good: &T, numbers: &[Senseless<T>]) -> Vec<(T, String)> {
    let cases = numbers.iter().flat_map(|number| number.cases(good));
    cases.map(|(said, set)| (set(), said)).collect()
}

/// Asserts that an invalid value is refused.
#[track_caller]
fn assert_not_set<T: Clone>(good: &T, numbers: &[Senseless<T>]) {
    for (said, set) in numbers.iter().flat_map(|number| number.cases(good)) {
        refused(&said, set);
    }
}

/// Runs work that must panic, and compares its message.
#[track_caller]
fn refused<R>(message: &str, work: impl FnOnce() -> R) {
    let caught = catch_unwind(AssertUnwindSafe(work)).err();
    let said = caught.expect(message);
    let said = said
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| said.downcast_ref::<&str>().copied())
        .expect("a message");
    assert!(said.contains(message), "\"{said}\" has no \"{message}\"");
}
