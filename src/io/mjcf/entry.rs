//! An element with the defaults of its class: its values.

use super::defaults::{ClassId, Classes};
use super::tree::Node;
use crate::error::LoadError;
use crate::io::values::parse;

/// An element with its class.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry<'t, 'c> {
    pub(super) node: Node<'t>,
    pub(super) classes: &'c Classes<'t>,
    pub(super) class: ClassId,
    /// Tags of elements whose defaults count: its own first.
    pub(super) tags: &'static [&'static str],
}

/// A truth value that may be left to be decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Choice {
    Yes,
    No,
    Auto,
}

impl<'t, 'c> Entry<'t, 'c> {
    /// An element with the class that it names, or else that of its parent.
    pub(super) fn new(
        node: Node<'t>,
        classes: &'c Classes<'t>,
        around: ClassId,
        tags: &'static [&'static str],
    ) -> Result<Self, LoadError> {
        let class = classes.of(node.read(), "class")?.unwrap_or(around);
        Ok(Self {
            node,
            classes,
            class,
            tags,
        })
    }

    /// An element without a class.
    pub(super) fn plain(node: Node<'t>, classes: &'c Classes<'t>) -> Self {
        Self {
            node: node.read(),
            classes,
            class: 0,
            tags: &[],
        }
    }

    /// A value and the element that states it: this one, or one of the defaults.
    pub(super) fn value(&self, name: &'static str) -> Option<(Node<'t>, &'t str)> {
        for tag in self.tags {
            self.node.ask(tag, name);
        }
        let own = self.node.attribute(name).map(|text| (self.node, text));
        own.or_else(|| self.classes.find(self.class, self.tags, name))
    }

    /// A text that is not empty.
    pub(super) fn text(&self, name: &'static str) -> Option<&'t str> {
        let text = self.value(name).map(|(_, text)| text.trim());
        text.filter(|text| !text.is_empty())
    }

    /// `true` if the element itself has an attribute.
    pub(super) fn has_own(&self, name: &'static str) -> bool {
        self.node.attribute(name).is_some()
    }

    /// N finite numbers.
    pub(super) fn numbers<const N: usize>(
        &self,
        name: &'static str,
    ) -> Result<Option<[f64; N]>, LoadError> {
        let Some((node, text)) = self.value(name) else {
            return Ok(None);
        };
        let malformed = |reason| node.place().malformed(name, text, reason);
        let numbers: [f64; N] = parse(text).map_err(malformed)?;
        if numbers.iter().all(|x| x.is_finite()) {
            return Ok(Some(numbers));
        }
        Err(node.place().non_finite(name))
    }

    /// A finite number.
    pub(super) fn number(&self, name: &'static str) -> Result<Option<f64>, LoadError> {
        Ok(self.numbers::<1>(name)?.map(|[x]| x))
    }

    /// Up to N finite numbers over the default values.
    pub(super) fn some_numbers<const N: usize>(
        &self,
        name: &'static str,
        otherwise: [f64; N],
    ) -> Result<[f64; N], LoadError> {
        let mut out = otherwise;
        let numbers = self.list(name, N)?.unwrap_or_default();
        out[..numbers.len()].copy_from_slice(&numbers);
        Ok(out)
    }

    /// The first N of any number of finite numbers, over the default values.
    pub(super) fn some_numbers_of_many<const N: usize>(
        &self,
        name: &'static str,
        otherwise: [f64; N],
    ) -> Result<[f64; N], LoadError> {
        /// Parameters that an actuator can have.
        const MOST: usize = 1000;
        let mut out = otherwise;
        let numbers = self.list(name, MOST)?.unwrap_or_default();
        let given = out.iter_mut().zip(numbers);
        given.for_each(|(out, x)| *out = x);
        Ok(out)
    }

    /// Finite numbers, at most so many; `None` if there is no such attribute.
    pub(super) fn list(
        &self,
        name: &'static str,
        at_most: usize,
    ) -> Result<Option<Vec<f64>>, LoadError> {
        let Some((node, text)) = self.value(name) else {
            return Ok(None);
        };
        let malformed = |reason: String| node.place().malformed(name, text, reason);
        let mut numbers = Vec::new();
        for token in text.split_whitespace() {
            let [x] = parse(token).map_err(malformed)?;
            if !x.is_finite() {
                return Err(node.place().non_finite(name));
            }
            numbers.push(x);
            if numbers.len() > at_most {
                return Err(malformed(format!("expected at most {at_most} numbers")));
            }
        }
        Ok(Some(numbers))
    }

    /// One of some words.
    pub(super) fn word<T: Copy>(
        &self,
        name: &'static str,
        table: &[(&str, T)],
    ) -> Result<Option<T>, LoadError> {
        let Some((node, text)) = self.value(name) else {
            return Ok(None);
        };
        let found = table.iter().find(|(word, _)| *word == text.trim());
        let unknown = || {
            let words: Vec<&str> = table.iter().map(|(word, _)| *word).collect();
            let reason = format!("expected one of {}", words.join(", "));
            node.place().malformed(name, text, reason)
        };
        found
            .map(|&(_, meaning)| meaning)
            .ok_or_else(unknown)
            .map(Some)
    }

    /// A whole number of 32 bits.
    pub(super) fn integer(&self, name: &'static str) -> Result<Option<i32>, LoadError> {
        let number = self.text(name).map(str::parse).transpose();
        number.map_err(|_| self.malformed(name, "expected a whole number"))
    }

    /// `true` or `false`.
    pub(super) fn flag(&self, name: &'static str, otherwise: bool) -> Result<bool, LoadError> {
        let table = [("true", true), ("false", false)];
        Ok(self.word(name, &table)?.unwrap_or(otherwise))
    }

    /// `true`, `false` or `auto`.
    pub(super) fn choice(&self, name: &'static str) -> Result<Choice, LoadError> {
        let table = [
            ("true", Choice::Yes),
            ("false", Choice::No),
            ("auto", Choice::Auto),
        ];
        Ok(self.word(name, &table)?.unwrap_or(Choice::Auto))
    }

    /// Error for a value that cannot be.
    pub(super) fn malformed(&self, name: &'static str, reason: &str) -> LoadError {
        let (node, text) = self.value(name).unwrap_or((self.node, ""));
        node.place().malformed(name, text, reason)
    }

    /// Error for a value that must be there.
    pub(super) fn missing(&self, name: &str) -> LoadError {
        self.node.place().missing(&format!("attribute {name}"))
    }

    /// A range that limits, as `limited` and `autolimits` say.
    pub(super) fn range(
        &self,
        name: &'static str,
        limited: &'static str,
        autolimits: bool,
    ) -> Result<Option<[f64; 2]>, LoadError> {
        let range = self.numbers::<2>(name)?;
        let limits = match self.choice(limited)? {
            Choice::Yes => true,
            Choice::No => false,
            Choice::Auto => autolimits && range.is_some_and(|[lower, upper]| lower < upper),
        };
        match (limits, range) {
            (true, None) => Err(self.missing(name)),
            (true, Some([lower, upper])) if lower > upper => {
                Err(self.malformed(name, "the first number is above the second"))
            }
            (true, range) => Ok(range),
            (false, _) => Ok(None),
        }
    }
}
