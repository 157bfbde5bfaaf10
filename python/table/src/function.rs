//! An entry of the table.

use dualbody::Model;
use dualbody::scalar::Differentiable;

use crate::{Memory, Robot, Unknown};

/// A function of rows, whose arguments by name are known: robot, memory, rows, the row of the result.
pub type Prepared<T> = Box<dyn Fn(Robot<'_, T>, &mut Memory<T>, &[&[T]], &mut [T]) + Send + Sync>;

/// The lengths of up to three axes, without memory of its own.
#[derive(Clone, Copy)]
pub struct Shape {
    lengths: [usize; 3],
    axes: usize,
}

impl Shape {
    /// The shape of these lengths.
    pub fn new<const N: usize>(lengths: [usize; N]) -> Self {
        let mut all = [0; 3];
        all[..N].copy_from_slice(&lengths);
        Self {
            lengths: all,
            axes: N,
        }
    }
}

impl std::ops::Deref for Shape {
    type Target = [usize];

    fn deref(&self) -> &[usize] {
        &self.lengths[..self.axes]
    }
}

/// A [`Shape`] of lengths.
#[macro_export]
macro_rules! shape {
    ($($length:expr),*) => { $crate::Shape::new([$($length),*]) };
}

/// An argument that gives something by its name, and what it is if it is left out.
pub type Keyword = (&'static str, Option<&'static str>);

/// A function of a robot and vectors.
pub struct Function<T: Differentiable> {
    /// Its name.
    pub name: &'static str,
    /// Its vectors.
    pub arguments: &'static [&'static str],
    /// A vector that may be left out; it comes last.
    pub option: Option<&'static str>,
    /// Its keyword arguments.
    pub keywords: &'static [Keyword],
    /// Whether it is one of a simulator.
    pub is_of_simulator: bool,
    /// Shape of the result of one row.
    pub tail: fn(Robot<'_, f64>) -> Shape,
    /// The function for names of the keywords; `None` if it is not one on this scalar.
    pub prepare: Option<fn(&Model, &[&str]) -> Result<Prepared<T>, Unknown>>,
}

/// Shape of an argument with this name.
pub fn shape_of(robot: Robot<'_, f64>, name: &str) -> Shape {
    let m = robot.model();
    match name {
        "q" | "q0" | "q1" => shape![m.nq()],
        "external" => shape![m.n_bodies(), 6],
        "force" => shape![6],
        "mass_matrix" => shape![m.nv(), m.nv()],
        "u" => shape![robot.simulator().nu()],
        "contact" => shape![robot.simulator().n_contact() + robot.simulator().n_activation()],
        _ => shape![m.nv()],
    }
}

/// Whether an argument with this name is a configuration, which changes along its tangent.
pub fn is_configuration(name: &str) -> bool {
    matches!(name, "q" | "q0" | "q1")
}

/// The function on duals with a name.
pub fn on_duals(name: &str) -> Option<&'static Function<crate::Dual>> {
    let mut all = crate::functions::ON_DUALS.iter().copied().flatten();
    all.find(|function| function.name == name)
}

/// An entry of functions of a model or of a simulator on a scalar:
/// `model: Model, scalar; name [mark](vectors + option; keyword: kind = "default") -> shape of a row, |model, memory, rows, keywords, row of the result| …`.
///
/// The mark `lanes` is for functions that run on lanes too.
#[macro_export]
macro_rules! function {
    ($of:ident: $Of:ident, $T:ty; $name:ident $([$mark:ident])? ($($x:ident),* $(+ $option:ident)? $(; $($key:ident: $kind:ty $(= $default:literal)?),+)?) -> $tail:expr, $one:expr) => {
        $crate::Function::<$T> {
            name: stringify!($name),
            arguments: &[$(stringify!($x)),*],
            option: $crate::first!($(Some(stringify!($option)))? None),
            keywords: &[$($((stringify!($key), $crate::first!($(Some($default))? None))),+)?],
            is_of_simulator: matches!(stringify!($of).as_bytes(), b"simulator"),
            tail: |robot| {
                const TAIL: fn(&dualbody::$Of) -> $crate::Shape = $tail;
                TAIL(robot.$of())
            },
            prepare: Some(|_model, _names| {
                const ONE: fn(&dualbody::$Of<$T>, &mut $crate::Memory<$T>, &[&[$T]], $($($kind,)+)? &mut [$T]) = $one;
                let mut _names = _names.iter().copied();
                $($(let $key = <$kind as $crate::Named>::find(_model, _names.next().unwrap_or_default())?;)+)?
                Ok(Box::new(move |robot, memory, x, out| ONE(robot.$of(), memory, x, $($($key,)+)? out)))
            }),
        }
    };
}

/// The first of some expressions.
#[doc(hidden)]
#[macro_export]
macro_rules! first {
    ($first:expr) => {
        $first
    };
    (Some($first:expr) None) => {
        Some($first)
    };
    ($first:ident None) => {
        $first
    };
}
