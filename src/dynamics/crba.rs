//! Composite-rigid-body algorithm: the joint-space mass matrix.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DMatrix;

use crate::joint::JointKind;
use crate::model::{BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Inertia, Transform};

/// Working memory of [`mass_matrix_into`].
#[derive(Clone, Debug)]
pub struct CrbaScratch<T> {
    sin_cos: Vec<(T, T)>,
    X_PB: Vec<Transform<T>>,
    composite: Vec<Inertia<T>>,
}

impl<T: Scalar> CrbaScratch<T> {
    /// Memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        let n = model.n_bodies();
        Self {
            sin_cos: vec![(T::zero(), T::one()); model.nq()],
            X_PB: vec![Transform::identity(); n],
            composite: vec![Inertia::zero(); n],
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
    } = scratch;
    T::vectorized(
        #[inline(always)]
        || {
            T::sin_cos_each(q, sin_cos);
            for (X, body) in X_PB.iter_mut().zip(model.bodies()) {
                *X = body.place_turned(q, sin_cos);
            }
            inward(model, X_PB, composite, out);
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
    let composite = &mut scratch.composite[..];
    T::vectorized(
        #[inline(always)]
        || inward(model, X_PB, composite, out),
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
    composite: &mut [Inertia<T>],
    out: &mut DMatrix<T>,
) {
    for (I, body) in composite.iter_mut().zip(model.bodies()) {
        *I = body.inertia.lift();
    }
    for (j, body) in model.bodies().iter().enumerate().rev() {
        // The force that the composite body needs for a unit acceleration of its joint: I S.
        let I = &composite[j];
        match body.joint {
            JointKind::Revolute | JointKind::Continuous => {
                write_column(model, X_PB, j, body.v, I.column_angular_z(), out);
            }
            JointKind::Prismatic => {
                write_column(model, X_PB, j, body.v, I.column_linear_z(), out);
            }
            _ => {
                for (column, axis) in body.axes() {
                    write_column(model, X_PB, j, column, I.column(axis), out);
                }
            }
        }
        if let Some(p) = body.parent {
            let I_P = X_PB[j].inertia(&composite[j]);
            composite[p.0] = composite[p.0] + I_P;
        }
    }
}

/// Carries a column of body j towards the world and writes its projection on every joint on the way: `M_ij = Sᵢᵀ X* Iⱼ Sⱼ`.
/// Followers add to the coordinates of their leaders.
#[inline(always)]
fn write_column<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    X_PB: &[Transform<T>],
    j: usize,
    column: usize,
    F: Force<T>,
    out: &mut DMatrix<T>,
) {
    let (bodies, nv) = (model.bodies(), out.nrows());
    let out = out.as_mut_slice();
    let mut body = &bodies[j];
    let (mut X, mut F) = (&X_PB[j], body.scaled_force(F));
    body.project(&F, |row, entry| out[row + nv * column] += entry);
    while let Some(BodyId(p)) = body.parent {
        F = X.force(&F);
        (body, X) = (&bodies[p], &X_PB[p]);
        body.project(&F, |row, entry| {
            out[row + nv * column] += entry;
            out[column + nv * row] += entry;
        });
    }
}
