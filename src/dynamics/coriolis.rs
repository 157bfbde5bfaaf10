//! The Coriolis matrix whose companion Ṁ − 2C is skew-symmetric.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DMatrix;

use super::passes::{to_world, velocity};
use crate::model::{BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{Force, Inertia, Motion, SPATIAL, Transform};

/// A 6 × 6 matrix from motions to forces, by columns.
type MotionToForce<T> = [Force<T>; SPATIAL];

/// Working memory of [`coriolis_matrix_into`].
#[derive(Clone, Debug)]
pub struct CoriolisScratch<T> {
    X_PB: Vec<Transform<T>>,
    V: Vec<Motion<T>>,
    composite: Vec<Inertia<T>>,
    /// Composite Coriolis matrices of the bodies.
    B: Vec<MotionToForce<T>>,
}

impl<T: Scalar> CoriolisScratch<T> {
    /// Makes memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        let n = model.n_bodies();
        Self {
            X_PB: vec![Transform::identity(); n],
            V: vec![Motion::zero(); n],
            composite: vec![Inertia::zero(); n],
            B: vec![[Force::zero(); SPATIAL]; n],
        }
    }
}

/// Computes C(q, v), `nv` × `nv`, with  h(q, v) = C v + g(q)  and Ṁ − 2C skew-symmetric.
///
/// O(n · depth); allocates its result and working memory.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
///
/// # Panics
/// If a slice has the wrong length.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::coriolis_matrix, model::samples};
///
/// // The inertia of one hinge does not change with its angle
/// let c = coriolis_matrix(&samples::pendulum(), &[0.4], &[6.0]);
/// assert!(c[(0, 0)].abs() < 1e-14);
/// ```
///
/// # References
/// [Echeandia, Wensing 2021, algorithm 1].
pub fn coriolis_matrix<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T], v: &[T]) -> DMatrix<T> {
    let mut out = DMatrix::zeros(model.nv(), model.nv());
    coriolis_matrix_into(model, q, v, &mut CoriolisScratch::new(model), &mut out);
    out
}

/// [`coriolis_matrix`] without allocation.
///
/// * `out` – output, `nv` × `nv`
///
/// # Panics
/// If an argument has the wrong size for the model.
pub fn coriolis_matrix_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    scratch: &mut CoriolisScratch<T>,
    out: &mut DMatrix<T>,
) {
    model.check_q(q);
    model.check_v(v);
    assert_eq!(
        out.shape(),
        (model.nv(), model.nv()),
        "the Coriolis matrix of \"{}\" is nv × nv",
        model.name()
    );
    assert_eq!(
        scratch.V.len(),
        model.n_bodies(),
        "the scratch belongs to another model than \"{}\"",
        model.name()
    );
    out.fill(T::zero());
    outward(model, q, v, scratch);
    inward(model, scratch, out);
}

/// Velocities, and each composite starts as its own body.
fn outward<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T], v: &[T], s: &mut CoriolisScratch<T>) {
    for (i, body) in model.bodies().iter().enumerate() {
        let X = body.place(q);
        let V = velocity(body, &X, v, |p| s.V[p.0]);
        s.composite[i] = body.inertia.lift();
        s.B[i] = body_coriolis(&s.composite[i], &V);
        (s.X_PB[i], s.V[i]) = (X, V);
    }
}

/// B = ½ ((V ×*) I − I (V ×) + (I V) ×̄*), where F ×̄* U = U ×* F: the body's force is I A + B V, and İ − 2B is
/// skew-symmetric.
fn body_coriolis<T: Scalar>(I: &Inertia<T>, V: &Motion<T>) -> MotionToForce<T> {
    let momentum = I.times::<T>(V);
    std::array::from_fn(|k| {
        let U = Motion::basis(k);
        let sum = V.cross_force(&I.times::<T>(&U)) - I.times::<T>(&V.cross(&U))
            + U.cross_force(&momentum);
        sum.scaled(T::constant(0.5))
    })
}

/// Passes inward from the leaves, for each joint j and every ancestor i, with Ṡ = V × S:
/// `C_ij = Sᵢᵀ (I_c Ṡⱼ + B_c Sⱼ)`,  `C_ji = Ṡᵢᵀ I_c Sⱼ + Sᵢᵀ B_cᵀ Sⱼ`; then the composites move on to the parent.
fn inward<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    s: &mut CoriolisScratch<T>,
    out: &mut DMatrix<T>,
) {
    for (j, body) in model.bodies().iter().enumerate().rev() {
        for (column, S) in body.columns() {
            let carried = PropagatedForces {
                forward: s.composite[j].times::<T>(&s.V[j].cross(&S)) + apply(&s.B[j], &S),
                inertial: s.composite[j].times::<T>(&S),
                transposed: Force::from_array(std::array::from_fn(|k| S.power(&s.B[j][k]))),
            };
            carried.write(model, s, BodyId(j), column, out);
        }
        if let Some(p) = body.parent {
            let (X, I, B) = (s.X_PB[j], s.composite[j], s.B[j]);
            s.composite[p.0] = s.composite[p.0] + X.inertia(&I);
            let moved = moved(&X, &B);
            s.B[p.0]
                .iter_mut()
                .zip(moved)
                .for_each(|(sum, B)| *sum += B);
        }
    }
}

/// The forces that are carried from a joint to the world.
struct PropagatedForces<T> {
    /// `I_c Ṡ + B_c S`
    forward: Force<T>,
    /// `I_c S`
    inertial: Force<T>,
    /// `B_cᵀ S`
    transposed: Force<T>,
}

impl<T: Scalar> PropagatedForces<T> {
    /// Writes row and column of one coordinate for every joint on the way to the world.
    fn write<P: Scalar>(
        mut self,
        model: &Model<P>,
        s: &CoriolisScratch<T>,
        from: BodyId,
        column: usize,
        out: &mut DMatrix<T>,
    ) where
        T: Over<P>,
    {
        for (id, body) in to_world(model, Some(from)) {
            for (row, S) in body.columns::<T>() {
                out[(row, column)] += S.power(&self.forward);
                if id != from {
                    let S_dot = s.V[id.0].cross(&S);
                    out[(column, row)] += S_dot.power(&self.inertial) + S.power(&self.transposed);
                }
            }
            let X = &s.X_PB[id.0];
            self = Self {
                forward: X.force(&self.forward),
                inertial: X.force(&self.inertial),
                transposed: X.force(&self.transposed),
            };
        }
    }
}

/// B S.
fn apply<T: Scalar>(B: &MotionToForce<T>, S: &Motion<T>) -> Force<T> {
    B.iter()
        .zip(S.to_array())
        .fold(Force::zero(), |sum, (B, s)| sum + B.scaled(s))
}

/// X* B X⁻¹: forces transform the columns, and their transpose the rows.
fn moved<T: Scalar>(X: &Transform<T>, B: &MotionToForce<T>) -> MotionToForce<T> {
    let transpose = |B: &MotionToForce<T>| -> MotionToForce<T> {
        std::array::from_fn(|k| Force::from_array(std::array::from_fn(|row| B[row].coordinate(k))))
    };
    let columns = B.map(|column| X.force(&column));
    transpose(&transpose(&columns).map(|row| X.force(&row)))
}
