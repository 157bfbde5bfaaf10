//! Composite-rigid-body algorithm: the joint-space mass matrix.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DMatrix;

use crate::joint::{JointKind, MAX_NV};
use crate::model::Model;
use crate::model::manifold::v_range;
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Inertia, Transform};

/// Working memory of [`mass_matrix_into`].
#[derive(Clone, Debug)]
pub struct CrbaScratch<T> {
    X_PB: Vec<Transform<T>>,
    composite: Vec<Inertia<T>>,
}

impl<T: Scalar> CrbaScratch<T> {
    /// Memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        let n = model.n_bodies();
        Self {
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
    out.fill(T::zero());
    outward(model, q, scratch);
    inward(model, scratch, out);
    for (k, &armature) in model.armature().iter().enumerate() {
        out[(k, k)] = out[(k, k)] + armature;
    }
}

/// Joint transforms, and each composite starts as its own body.
fn outward<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T], s: &mut CrbaScratch<T>) {
    for (i, body) in model.bodies().iter().enumerate() {
        s.X_PB[i] = body.place(q);
        s.composite[i] = body.inertia.lift();
    }
}

/// From the tips, followers adding to the coordinates of their leaders: `M_ij = Sᵢᵀ X* Iⱼ Sⱼ` for all ancestors i of j, then the parent's composite inertia grows by X* Iⱼ X⁻¹.
fn inward<P: Scalar, T: Over<P>>(model: &Model<P>, s: &mut CrbaScratch<T>, out: &mut DMatrix<T>) {
    for (j, body) in model.bodies().iter().enumerate().rev() {
        let mut F = [Force::zero(); MAX_NV];
        let F = &mut F[..body.joint.nv()];
        columns(body.joint, &s.composite[j], F);
        write_blocks(model, s, j, F, out);
        if let Some(p) = body.parent {
            let I_P = s.X_PB[j].inertia(&s.composite[j]);
            s.composite[p.0] = s.composite[p.0] + I_P;
        }
    }
}

/// I S: the force that the composite body needs for each unit acceleration of its joint.
#[inline]
fn columns<T: Scalar>(kind: JointKind, inertia: &Inertia<T>, out: &mut [Force<T>]) {
    match kind {
        JointKind::Revolute | JointKind::Continuous => out[0] = inertia.column_angular_z(),
        JointKind::Prismatic => out[0] = inertia.column_linear_z(),
        _ => out
            .iter_mut()
            .zip(kind.axes())
            .for_each(|(F, &axis)| *F = inertia.column(axis)),
    }
}

/// Carries the columns of body j towards the world and writes their projections on every joint on the way.
#[inline]
fn write_blocks<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    s: &CrbaScratch<T>,
    j: usize,
    F: &mut [Force<T>],
    out: &mut DMatrix<T>,
) {
    let first = model.bodies()[j].v;
    let mut i = j;
    loop {
        let body = &model.bodies()[i];
        for (k, F) in F.iter_mut().enumerate() {
            let mut tau = [T::zero(); MAX_NV];
            body.joint.project(F, &mut tau[..body.joint.nv()]);
            for (row, tau) in v_range(body).zip(tau) {
                let entry = body.scaled(model.bodies()[j].scaled(tau));
                out[(row, first + k)] += entry;
                if i != j {
                    out[(first + k, row)] += entry;
                }
            }
        }
        let Some(p) = body.parent else { return };
        F.iter_mut().for_each(|F| *F = s.X_PB[i].force(F));
        i = p.0;
    }
}
