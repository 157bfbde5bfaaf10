//! The functions of the Python package, each once, on any scalar: from this table come the functions on NumPy's arrays, and those of JAX and PyTorch
//! with their derivatives.
//!
//! | file | what it is |
//! |---|---|
//! | `functions` | the table |
//! | `function` | an entry of it: names, shapes, the function on a scalar |
//! | `named` | what arguments give by name: frames, representations |
//! | `robot` | what a function is of: a model or a simulator |
//! | `memory` | working memory on a scalar |
//! | `hot`, `based`, `write` | what entries are made of |
//! | `point` | derivatives along directions, and of weighted sums, by dual numbers |
//! | `adjoint` | gradients of the dynamics in all inputs and parameters along the tree |
//!
//! A crate of its own, since derivatives by dual numbers take much code: it is compiled with few optimisations, see the profiles in the manifest of the
//! extension module. That one compiles the functions on numbers.

mod adjoint;
pub mod based;
mod function;
mod functions;
pub mod hot;
mod memory;
mod named;
mod point;
mod robot;
pub mod write;

pub use adjoint::{Adjoint, adjoint_of};
pub use function::{Function, Keyword, Prepared, Shape, is_configuration, on_duals, shape_of};
pub use memory::Memory;
pub use named::{Named, Unknown};
pub use point::{Directions, Lifted, Point};
pub use robot::{Own, Robot};

/// Items that entries of the table name.
pub mod prelude {
    pub use crate::based;
    pub use crate::hot::{self, contacts, points};
    pub use crate::shape;
    pub use crate::write::*;
    pub use dualbody::dynamics::{self as d, BaseFrame, BaseQuantity, MomentumFrame};
    pub use dualbody::model::FrameId;
    pub use dualbody::scalar::{One, Zero};
    pub use dualbody::spatial::{Force, Representation};
    pub use nalgebra::DMatrix;
}

/// A number with derivatives in some directions.
pub type Dual = dualbody::autodiff::Dual<f64, { dualbody::scalar::CHUNK }>;
