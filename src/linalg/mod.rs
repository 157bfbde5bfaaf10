//! Small factorisations and products that do not allocate, over any scalar or in whole vectors; larger ones and decompositions are nalgebra's.
//!
//! | question | answer | used by |
//! |---|---|---|
//! | A x = b, A general, n up to some dozens | [`Lu`] | the cone solver |
//! | the same, A symmetric and positive definite, over the scalar, without decisions | [`Symmetric`] | the cone solver, recorded |
//! | A x = b, A symmetric and definite along free coordinates | [`FreeFactor`] | quadratic programs with bounds |
//! | min ½ dᵀ H d + gᵀ d within bounds | [`BoxQp`] | differential dynamic programming, least squares |
//! | A x = b, A of a joint's own coordinates, over the scalar | [`small_matrix`] | forward dynamics |
//! | eigenvalues, A general | [`eigenvalues`](fn@eigenvalues) | regulators, remarks on time steps |
//! | eigenvalues and axes, A symmetric | [`symmetric_eigen`], [`symmetric_eigen3`] | principal axes of inertia, constraints that repeat others |
//! | singular values | [`svd`] | what inputs reach, forces of a stance |
//! | C += Aᵀ B of dense columns | [`product`] | Riccati's recursion |

mod box_qp;
mod eigenvalues;
mod factors;
mod free_factor;
mod lu;
pub(crate) mod product;
pub(crate) mod small_matrix;
mod symmetric;

pub(crate) use box_qp::{Bounds, BoxQp};
pub(crate) use eigenvalues::{eigenvalues, svd, symmetric_eigen, symmetric_eigen3};
pub(crate) use factors::Factors;
pub(crate) use free_factor::{FreeFactor, NotConvex};
pub(crate) use lu::Lu;
pub(crate) use symmetric::Symmetric;
