//! Composite-rigid-body algorithm: the joint-space mass matrix.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DMatrix;

use super::articulated_factor::{SLIDE, TURN};
use super::columns::Columns;
use crate::joint::JointKind;
use crate::model::{Body, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Inertia, Transform};

/// Working memory of [`mass_matrix_into`].
#[derive(Clone, Debug)]
pub struct CrbaScratch<T> {
    sin_cos: Vec<(T, T)>,
    X_PB: Vec<Transform<T>>,
    composite: Vec<Inertia<T>>,
    columns: Columns<T>,
}

impl<T: Scalar> CrbaScratch<T> {
    /// Memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        let n = model.n_bodies();
        Self {
            sin_cos: vec![(T::zero(), T::one()); model.nq()],
            X_PB: vec![Transform::identity(); n],
            composite: vec![Inertia::zero(); n],
            columns: Columns::new(model),
        }
    }
}

/// Computes the mass matrix M(q), `nv` × `nv`, symmetric:  T = ½ vᵀ M v.
///
/// Allocates its result and working memory.
///
/// * `q` – configuration, length `nq`
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::mass_matrix, model::samples};
///
/// // A rod of 1 kg and 1 m about its end: J = 1/3 kg·m²
/// assert!((mass_matrix(&samples::pendulum(), &[0.4])[(0, 0)] - 1.0 / 3.0).abs() < 1e-15);
/// ```
///
/// # References
/// [Featherstone 2008, table 6.2].
pub fn mass_matrix<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T]) -> DMatrix<T> {
    let mut out = DMatrix::zeros(model.nv(), model.nv());
    mass_matrix_into(model, q, &mut CrbaScratch::new(model), &mut out);
    out
}

/// [`mass_matrix`] without allocation.
///
/// * `out` – output, `nv` × `nv`
///
/// # Panics
/// If an argument has not the size that the model gives it.
pub fn mass_matrix_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    scratch: &mut CrbaScratch<T>,
    out: &mut DMatrix<T>,
) {
    model.check_q(q);
    assert_eq!(
        out.shape(),
        (model.nv(), model.nv()),
        "the mass matrix of \"{}\" is nv × nv",
        model.name()
    );
    assert_eq!(
        scratch.X_PB.len(),
        model.n_bodies(),
        "the scratch belongs to another model than \"{}\"",
        model.name()
    );
    out.as_mut_slice().fill(T::zero());
    let CrbaScratch {
        sin_cos,
        X_PB,
        composite,
        columns,
    } = scratch;
    T::vectorized(
        #[inline(always)]
        || {
            T::sin_cos_each(q, sin_cos);
            for (X, body) in X_PB.iter_mut().zip(model.bodies()) {
                *X = body.place_turned(q, sin_cos);
            }
            inward(model, X_PB, (composite, columns), out);
        },
    );
    add_armature(model, out);
}

/// [`mass_matrix_into`] where the pose of each body in its parent is known.
pub(crate) fn mass_matrix_of_placed_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    X_PB: &[Transform<T>],
    scratch: &mut CrbaScratch<T>,
    out: &mut DMatrix<T>,
) {
    out.as_mut_slice().fill(T::zero());
    let own = (&mut scratch.composite[..], &mut scratch.columns);
    T::vectorized(
        #[inline(always)]
        || inward(model, X_PB, own, out),
    );
    add_armature(model, out);
}

/// The rotors of the joints' motors turn with their own coordinate alone.
pub(crate) fn add_armature<P: Scalar, T: Over<P>>(model: &Model<P>, mass: &mut DMatrix<T>) {
    let diagonal = mass.as_mut_slice().iter_mut().step_by(model.nv() + 1);
    for (entry, &armature) in diagonal.zip(model.armature()) {
        *entry = *entry + armature;
    }
}

/// Each composite starts as its own body. From the tips: the columns of each joint, then the parent's composite inertia grows by X* Iⱼ X⁻¹.
#[inline(always)]
fn inward<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    X_PB: &[Transform<T>],
    (composite, columns): (&mut [Inertia<T>], &mut Columns<T>),
    out: &mut DMatrix<T>,
) {
    for (I, body) in composite.iter_mut().zip(model.bodies()) {
        *I = body.inertia.lift();
    }
    columns.number(model.bodies());
    for (j, body) in model.bodies().iter().enumerate().rev() {
        let (X, I) = (&X_PB[j], &composite[j]);
        match body.joint {
            JointKind::Revolute | JointKind::Continuous => {
                columns.pass::<P, TURN>((j, body), X, I, out);
            }
            JointKind::Prismatic => columns.pass::<P, SLIDE>((j, body), X, I, out),
            _ => columns.pass_several((j, body), X, I, out),
        }
        if let Some(p) = body.parent {
            let I_P = X.inertia(I);
            composite[p.0] = composite[p.0] + I_P;
        }
    }
}

/// A column is what the unit acceleration of its degree of freedom asks of the body that the sweep has come to.
impl<T: Scalar> Columns<T> {
    /// At a joint with one axis: writes what each column of the subtree has along the axis, and passes them on to the parent.
    #[inline(always)]
    fn pass<P: Scalar, const AXIS: usize>(
        &mut self,
        (j, body): (usize, &Body<P>),
        X: &Transform<T>,
        I: &Inertia<T>,
        out: &mut DMatrix<T>,
    ) {
        let (own, end, nv, row) = (
            self.first[j],
            self.first[body.subtree_end],
            out.nrows(),
            body.v,
        );
        let out = out.as_mut_slice();
        let F = body.scaled_force(I.column(AXIS));
        out[row + nv * row] += body.scaled(F.coordinate(AXIS));
        self.F[own] = X.force(&F);
        let carried = self.F[own + 1..end].iter_mut().zip(&self.v[own + 1..end]);
        for (F, &column) in carried {
            let entry = body.scaled(F.coordinate(AXIS));
            out[row + nv * column] += entry;
            out[column + nv * row] += entry;
            *F = X.force(F);
        }
    }

    /// At a joint with none or several axes: writes what each column of the subtree has along the axes, and propagates them to the parent.
    #[inline(always)]
    fn pass_several<P: Scalar>(
        &mut self,
        (j, body): (usize, &Body<P>),
        X: &Transform<T>,
        I: &Inertia<T>,
        out: &mut DMatrix<T>,
    ) {
        let (own, end, nv) = (self.first[j], self.first[body.subtree_end], out.nrows());
        let out = out.as_mut_slice();
        let axes = body.joint.axes();
        for (F, &axis) in self.F[own..].iter_mut().zip(axes) {
            *F = I.column(axis);
        }
        let carried = own + axes.len();
        for (k, F) in self.F[own..carried].iter().enumerate() {
            for (row, &axis) in (body.v..).zip(axes) {
                out[row + nv * (body.v + k)] += F.coordinate(axis);
            }
        }
        for (F, &column) in self.F[carried..end].iter().zip(&self.v[carried..end]) {
            let entries = F.to_array();
            for (row, &axis) in (body.v..).zip(axes) {
                out[row + nv * column] += entries[axis];
                out[column + nv * row] += entries[axis];
            }
        }
        if body.parent.is_some() {
            self.F[own..end].iter_mut().for_each(|F| *F = X.force(F));
        }
    }
}
