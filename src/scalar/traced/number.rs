//! The traced number.

use std::cell::RefCell;
use std::fmt;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};
use std::panic::Location;

use num_traits::{One, Zero};

use super::operation::{NodeId, Operation};
use super::recording::{Condition, Recording};
use crate::scalar::{MapEach, Scalar};

thread_local! {
    /// Recordings of this thread that go on, one within the other.
    static RECORDINGS: RefCell<Vec<Recording>> = const { RefCell::new(Vec::new()) };
}

/// A number that records its operations: a constant, or a node of the graph of [`trace`](super::trace).
///
/// See the [module](super). Two numbers are equal if they are the same constant or the same node; [`is_zero`](Zero::is_zero) is true for the constant 0 only.
///
/// A number belongs to its trace, on one thread; constants belong to all traces.
#[derive(Clone, Copy, PartialEq)]
pub struct Traced(Kind);

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Constant(f64),
    /// A node of the recording of an id.
    Node {
        recording: u32,
        node: NodeId,
    },
}

/// Takes the recording of a trace off the stack of this thread when the trace ends, also by a panic.
pub(super) struct Tracing(());

impl Tracing {
    /// Starts a recording on this thread.
    pub(super) fn start() -> Self {
        thread_local! {
            static NEXT: RefCell<u32> = const { RefCell::new(0) };
        }
        let id = NEXT.with_borrow_mut(|next| {
            *next += 1;
            *next
        });
        RECORDINGS.with_borrow_mut(|all| all.push(Recording::new(id)));
        Self(())
    }

    /// Ends it.
    pub(super) fn finish(self) -> Recording {
        let recording = RECORDINGS.with_borrow_mut(Vec::pop);
        std::mem::forget(self);
        recording.expect("the recording that was started")
    }
}

impl Drop for Tracing {
    fn drop(&mut self) {
        RECORDINGS.with_borrow_mut(Vec::pop);
    }
}

/// Runs `work` on the recording of the innermost trace.
fn record<R>(work: impl FnOnce(&mut Recording) -> R) -> R {
    RECORDINGS.with_borrow_mut(|all| match all.last_mut() {
        Some(recording) => work(recording),
        None => panic!("a traced number is used after its trace has ended, or on another thread"),
    })
}

/// The node of a number in a recording.
fn node_of(recording: &mut Recording, x: Traced) -> NodeId {
    match x.0 {
        Kind::Constant(x) => recording.constant(x),
        Kind::Node { recording: of, .. } if of != recording.id => {
            panic!("a traced number is used in another trace than its own")
        }
        Kind::Node { node, .. } => node,
    }
}

fn number_of(recording: &Recording, node: NodeId) -> Traced {
    Traced(match recording.number(node) {
        Some(x) => Kind::Constant(x),
        None => Kind::Node {
            recording: recording.id,
            node,
        },
    })
}

impl Traced {
    /// An entry of the inputs of the innermost trace.
    pub(super) fn input(index: usize) -> Self {
        record(|recording| {
            let index = u32::try_from(index).expect("less than 2³² inputs");
            let node = recording.input(index);
            number_of(recording, node)
        })
    }

    /// Its node in the innermost trace.
    pub(super) fn node(self) -> NodeId {
        record(|recording| node_of(recording, self))
    }

    /// The number, if it is a constant.
    pub(crate) fn constant_value(self) -> Option<f64> {
        match self.0 {
            Kind::Constant(x) => Some(x),
            Kind::Node { .. } => None,
        }
    }

    fn unary(
        self,
        fold: fn(f64) -> f64,
        work: impl FnOnce(&mut Recording, NodeId) -> NodeId,
    ) -> Self {
        if let Kind::Constant(x) = self.0 {
            return Self(Kind::Constant(fold(x)));
        }
        record(|recording| {
            let a = node_of(recording, self);
            let out = work(recording, a);
            number_of(recording, out)
        })
    }

    fn binary(
        self,
        other: Self,
        fold: fn(f64, f64) -> f64,
        work: impl FnOnce(&mut Recording, NodeId, NodeId) -> NodeId,
    ) -> Self {
        if let (Kind::Constant(x), Kind::Constant(y)) = (self.0, other.0) {
            return Self(Kind::Constant(fold(x, y)));
        }
        record(|recording| {
            let (a, b) = (node_of(recording, self), node_of(recording, other));
            let out = work(recording, a, b);
            number_of(recording, out)
        })
    }
}

impl fmt::Debug for Traced {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Kind::Constant(x) => write!(f, "{x:?}"),
            Kind::Node { node, .. } => write!(f, "node {}", node.0),
        }
    }
}

impl Default for Traced {
    fn default() -> Self {
        Self::zero()
    }
}

impl From<f64> for Traced {
    #[inline]
    fn from(x: f64) -> Self {
        Self(Kind::Constant(x))
    }
}

/// Operators between two numbers, and with `f64` on the right.
macro_rules! operators {
    ($($operator:ident $method:ident $assign:ident $assign_method:ident;)*) => {$(
        impl $operator for Traced {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.binary(other, |x, y| x.$method(y), Recording::$method)
            }
        }
        impl $operator<f64> for Traced {
            type Output = Self;
            fn $method(self, other: f64) -> Self {
                $operator::$method(self, Self::from(other))
            }
        }
        impl $assign for Traced {
            fn $assign_method(&mut self, other: Self) {
                *self = $operator::$method(*self, other);
            }
        }
    )*};
}
operators! {
    Add add AddAssign add_assign;
    Sub sub SubAssign sub_assign;
    Mul mul MulAssign mul_assign;
    Div div DivAssign div_assign;
}

impl Neg for Traced {
    type Output = Self;
    fn neg(self) -> Self {
        self.unary(f64::neg, Recording::neg)
    }
}

impl Zero for Traced {
    #[inline]
    fn zero() -> Self {
        Self::from(0.0)
    }

    fn is_zero(&self) -> bool {
        self.constant_value() == Some(0.0)
    }
}

impl One for Traced {
    #[inline]
    fn one() -> Self {
        Self::from(1.0)
    }
}

/// Functions of one number without rules of their own.
macro_rules! functions {
    ($($name:ident $operation:ident;)*) => {$(
        fn $name(self) -> Self {
            let record = |recording: &mut Recording, a| recording.function(Operation::$operation(a));
            self.unary(<f64 as Scalar>::$name, record)
        }
    )*};
}

impl Scalar for Traced {
    const HAS_VALUES: bool = false;

    functions! { sqrt Sqrt; exp Exp; ln Ln; asin Asin; acos Acos; tanh Tanh; }

    fn sin_cos(self) -> (Self, Self) {
        if let Kind::Constant(x) = self.0 {
            let (sin, cos) = Scalar::sin_cos(x);
            return (Self::from(sin), Self::from(cos));
        }
        record(|recording| {
            let angle = node_of(recording, self);
            let (sin, cos) = recording.sin_cos(angle);
            (number_of(recording, sin), number_of(recording, cos))
        })
    }

    fn atan2(self, x: Self) -> Self {
        let record = |r: &mut Recording, y, x| r.function(Operation::Atan2(y, x));
        self.binary(x, <f64 as Scalar>::atan2, record)
    }

    fn mul_add(self, factor: Self, term: Self) -> Self {
        if let [Kind::Constant(a), Kind::Constant(b), Kind::Constant(c)] =
            [self.0, factor.0, term.0]
        {
            return Self::from(Scalar::mul_add(a, b, c));
        }
        record(|recording| {
            let [a, b, c] = [self, factor, term].map_each(|x| node_of(recording, x));
            let out = recording.mul_add(a, b, c);
            number_of(recording, out)
        })
    }

    fn mul_add_real(self, factor: f64, term: Self) -> Self {
        self.mul_add(Self::from(factor), term)
    }

    fn scale_add<T: crate::scalar::Over<Self>>(self, x: T, term: T) -> T {
        // One of the number's own type, or a dual number over it, in which products with zero fold away.
        x.mul_add(T::from(self), term)
    }

    fn select_lt(self, other: Self, a: Self, b: Self) -> Self {
        if let (Kind::Constant(x), Kind::Constant(y)) = (self.0, other.0) {
            return if x < y { a } else { b };
        }
        if a == b {
            return b;
        }
        record(|recording| {
            let [x, y, a, b] = [self, other, a, b].map_each(|x| node_of(recording, x));
            let out = recording.select_lt(x, y, a, b);
            number_of(recording, out)
        })
    }

    /// # Panics
    /// If the number is not a constant: the message names the place that asked.
    #[track_caller]
    fn value(&self, lane: usize) -> f64 {
        assert_eq!(lane, 0, "there is one lane");
        let place = Location::caller();
        self.constant_value().unwrap_or_else(|| {
            panic!(
                "{place} decides on the value of a traced number, which is known only when its graph is evaluated; \
                 the documentation of `scalar::traced` lists what can be traced"
            )
        })
    }

    fn has_value(&self) -> bool {
        self.constant_value().is_some()
    }

    fn detached(self) -> Self {
        self
    }

    fn is_at_most(&self, limit: f64, condition: &str) -> bool {
        if let Some(x) = self.constant_value() {
            return x.is_nan() || x <= limit;
        }
        record(|recording| {
            let node = node_of(recording, *self);
            let condition = Condition {
                node,
                limit,
                condition: condition.to_owned(),
            };
            if !recording.conditions.contains(&condition) {
                recording.conditions.push(condition);
            }
        });
        true
    }
}

crate::differentiable! { [] Traced; }
