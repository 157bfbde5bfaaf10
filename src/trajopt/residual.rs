//! Residuals of costs and constraints, generic over the scalar.

use std::fmt;

use nalgebra::DMatrix;
#[cfg(feature = "second-order")]
use num_dual::HyperDual64;

use super::robot::NO_ROBOT;
use super::system::{AnySystem, AsSystem, Manifold, Sizes, behind_a_pointer};
use crate::autodiff::{CHUNK, Dual, TangentPoint};
use crate::model::Model;
use crate::scalar::Scalar;

/// Node of a horizon at which a residual is evaluated, on numbers `T`.
pub struct Node<'a, T: Scalar = f64> {
    /// The system: its sizes, and the manifold of its states.
    pub dynamics: &'a dyn Manifold<T>,
    /// The stage, from 0, or from the first stage of the problem
    /// ([`Problem::set_first_stage`](super::Problem::set_first_stage)); the end of the horizon is the last stage plus one.
    pub stage: usize,
    /// The system on all scalars.
    system: &'a dyn AnySystem,
}

impl<'a> Node<'a> {
    /// The node of a stage, on plain numbers.
    pub fn new(dynamics: &'a (impl AsSystem + ?Sized), stage: usize) -> Self {
        let system = dynamics.as_system();
        Self {
            dynamics: system,
            stage,
            system,
        }
    }
}

impl<'a, T: Scalar> Node<'a, T> {
    /// The robot of the residual.
    ///
    /// # Panics
    /// If the system [is not a robot](super::System::robot).
    pub fn model(&self) -> &'a Model {
        self.dynamics.robot().expect(NO_ROBOT)
    }

    /// The node on plain numbers.
    pub(super) fn on_plain(&self) -> Node<'a> {
        self.on(|system| system)
    }

    /// The node on other numbers.
    pub(super) fn on<U: Scalar>(
        &self,
        manifold: fn(&'a dyn AnySystem) -> &'a dyn Manifold<U>,
    ) -> Node<'a, U> {
        Node {
            dynamics: manifold(self.system),
            stage: self.stage,
            system: self.system,
        }
    }
}

impl<T: Scalar> fmt::Debug for Node<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Node(stage {})", self.stage)
    }
}

/// Variables that a residual depends on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dependence {
    /// State and input.
    #[default]
    Both,
    /// The state alone.
    State,
    /// The first [`ndq`](super::System::ndq) tangent directions of the state alone: a robot's configuration.
    Configuration,
    /// The input alone. Such a residual is not allowed at the end of the horizon, where there is no input.
    Input,
}

/// A vector r(x, u) to be minimised, or kept within bounds.
///
/// # Examples
/// ```
/// use dualbody::{Scalar, trajopt::{Node, Residual}};
///
/// /// Distance of the first two entries of a state from the unit circle.
/// struct OnCircle;
/// impl Residual for OnCircle {
///     fn dim(&self, _: &Node<'_>) -> usize {
///         1
///     }
///     fn eval<T: Scalar>(&self, _: &Node<'_, T>, x: &[T], _: &[T], r: &mut [T]) {
///         r[0] = x[0] * x[0] + x[1] * x[1] - 1.0;
///     }
/// }
/// ```
pub trait Residual: Sized + Send + Sync + 'static {
    /// Number of entries, the same at all stages.
    fn dim(&self, node: &Node<'_>) -> usize;

    /// Computes r(x, u).
    ///
    /// * `x` – state, length `nx`
    /// * `u` – input, length `nu`; empty at the end of the horizon
    /// * `r` – output, length `dim`
    fn eval<T: Scalar>(&self, node: &Node<'_, T>, x: &[T], u: &[T], r: &mut [T]);

    /// Variables that the residual depends on; saying less than [`Dependence::Both`] saves time.
    fn depends_on(&self) -> Dependence {
        Dependence::Both
    }

    /// [`eval`](Self::eval) on plain numbers, for residuals with a faster implementation.
    fn value(&self, node: &Node<'_>, x: &[f64], u: &[f64], r: &mut [f64]) {
        self.eval(node, x, u, r);
    }

    /// Computes r with its derivatives. The default uses dual numbers through [`eval`](Self::eval).
    ///
    /// * `out` – output, prepared with `dim` rows of zeros
    fn linearize(&self, node: &Node<'_>, x: &[f64], u: &[f64], out: &mut ResidualJacobian) {
        out.fill_by_duals(self, node, x, u);
    }

    /// The residual behind a pointer, which is all that costs know of it.
    #[doc(hidden)]
    fn boxed(self) -> Box<dyn AnyResidual> {
        Box::new(self)
    }
}

/// [`Residual::boxed`] of a residual of this library, with all that the pointer leads to compiled here.
macro_rules! compiled_here {
    () => {
        #[inline(never)]
        fn boxed(self) -> Box<dyn $crate::trajopt::residual::AnyResidual> {
            Box::new(self)
        }
    };
}
pub(super) use compiled_here;

/// Number of entries, whatever the robot, and [`Dependence`] of a residual of this library that is [`compiled_here`].
macro_rules! fixed_size {
    ($entries:expr, $dependence:ident) => {
        $crate::trajopt::residual::compiled_here!();

        fn dim(&self, _: &$crate::trajopt::residual::Node<'_>) -> usize {
            $entries
        }

        fn depends_on(&self) -> $crate::trajopt::residual::Dependence {
            $crate::trajopt::residual::Dependence::$dependence
        }
    };
}
pub(super) use fixed_size;

behind_a_pointer! {
    /// A residual on one scalar.
    pub trait EvalOn<T>: [Send + Sync] of Residual {
        /// r(x, u).
        fn eval(&self, node: &Node<'_, T>, x: &[T], u: &[T], r: &mut [T]);
    }
}

/// A residual on the numbers of second derivatives, with the feature `second-order` that takes them.
#[cfg(feature = "second-order")]
pub trait EvalTwice: EvalOn<HyperDual64> {}
#[cfg(feature = "second-order")]
impl<R: EvalOn<HyperDual64>> EvalTwice for R {}

/// A residual without second derivatives, which the feature `second-order` adds.
#[cfg(not(feature = "second-order"))]
pub trait EvalTwice: Send + Sync {}
#[cfg(not(feature = "second-order"))]
impl<R: Send + Sync> EvalTwice for R {}

behind_a_pointer! {
    /// A residual of any type on the scalars that solvers use.
    pub trait AnyResidual: [EvalTwice] of Residual {
        /// Number of entries.
        fn dim(&self, node: &Node<'_>) -> usize;
        /// Variables that the residual depends on.
        fn depends_on(&self) -> Dependence;
        /// r(x, u).
        fn value(&self, node: &Node<'_>, x: &[f64], u: &[f64], r: &mut [f64]);
        /// r with its derivatives.
        fn linearize(&self, node: &Node<'_>, x: &[f64], u: &[f64], out: &mut ResidualJacobian);
    }
}

/// A residual with its derivatives in (δx, δu), and working memory for them.
#[derive(Clone, Debug)]
pub struct ResidualJacobian {
    /// r, length `dim`.
    pub values: Vec<f64>,
    /// ∂r/∂(δx, δu), one row after the other.
    rows: Vec<f64>,
    ndx: usize,
    nu: usize,
    /// A spatial Jacobian of a robot, 6 × `nv`.
    pub(super) spatial: DMatrix<f64>,
    point: TangentPoint<Dual<f64, CHUNK>>,
    r: Vec<Dual<f64, CHUNK>>,
}

impl ResidualJacobian {
    /// Memory for residuals of up to `dim` entries.
    pub fn new(sizes: &dyn Sizes, dim: usize) -> Self {
        let (nx, ndx, nu) = (sizes.nx(), sizes.ndx(), sizes.nu());
        Self {
            values: vec![0.0; dim],
            rows: vec![0.0; dim * (ndx + nu)],
            ndx,
            nu,
            spatial: DMatrix::zeros(crate::spatial::SPATIAL, sizes.ndq()),
            point: TangentPoint::new(nx, ndx, nu),
            r: vec![Dual::from(0.0); dim],
        }
    }

    /// Number of tangent directions of the state.
    pub fn ndx(&self) -> usize {
        self.ndx
    }

    /// The derivatives of entry `i`, length `ndx` + `nu`.
    ///
    /// # Panics
    /// If there is no such entry.
    pub fn row(&self, i: usize) -> &[f64] {
        let nz = self.ndx + self.nu;
        &self.rows[i * nz..(i + 1) * nz]
    }

    /// [`row`](Self::row), to be written.
    ///
    /// # Panics
    /// If there is no such entry.
    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        let nz = self.ndx + self.nu;
        &mut self.rows[i * nz..(i + 1) * nz]
    }

    /// Makes `dim` rows of zeros; allocates only where it never had as many.
    pub(super) fn prepare(&mut self, dim: usize) {
        self.values.resize(dim, 0.0);
        self.r.resize(dim, Dual::from(0.0));
        self.rows.clear();
        self.rows.resize(dim * (self.ndx + self.nu), 0.0);
    }

    /// Fills values and derivatives of a residual by dual numbers, in the directions that it depends on.
    pub fn fill_by_duals<R: Residual>(
        &mut self,
        residual: &R,
        node: &Node<'_>,
        x: &[f64],
        u: &[f64],
    ) {
        let node = node.on::<Dual<f64, CHUNK>>(|system| system);
        let (ndx, nz) = (self.ndx, self.ndx + u.len());
        let directions = match residual.depends_on() {
            Dependence::Both => 0..nz,
            Dependence::State => 0..ndx,
            Dependence::Configuration => 0..node.dynamics.ndq(),
            Dependence::Input => ndx..nz,
        };
        let stride = self.ndx + self.nu;
        let Self { point, rows, r, .. } = self;
        point.set(x, u);
        point.each(
            directions,
            |x, dx, out| node.dynamics.integrate(x, dx, out),
            |x, u, seeded| {
                residual.eval(&node, x, u, r);
                for (row, r) in rows.chunks_exact_mut(stride).zip(&*r) {
                    let out = row[seeded.clone()].iter_mut();
                    out.zip(r.eps).for_each(|(out, eps)| *out = eps);
                }
            },
        );
        for (out, r) in self.values.iter_mut().zip(&self.r) {
            *out = r.re;
        }
    }

    /// Copies the first rows of the spatial Jacobian, as many as there are entries, to the directions of the
    /// configuration.
    pub(super) fn copy_spatial_rows(&mut self) {
        let stride = self.ndx + self.nu;
        let rows = self.rows.chunks_exact_mut(stride.max(1));
        for (row, jacobian) in rows.zip(self.spatial.row_iter()) {
            row.iter_mut()
                .zip(jacobian.iter())
                .for_each(|(out, &j)| *out = j);
        }
    }
}
