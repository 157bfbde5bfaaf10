//! The Coriolis matrix whose companion Ṁ − 2C is skew-symmetric.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::ops::{AddAssign, IndexMut};

use nalgebra::{DMatrix, Vector3};

use super::passes::{to_world, velocity};
use crate::model::{BodyId, Model};
use crate::scalar::{MapEach, Over, Scalar, from_each};
use crate::spatial::linear::{cross, dot, from_columns, rotate, rows, scale};
use crate::spatial::{Force, Inertia, Motion, Transform};

/// Working memory of [`coriolis_matrix_into`].
#[derive(Clone, Debug)]
pub struct CoriolisScratch<T> {
    X_PB: Vec<Transform<T>>,
    V: Vec<Motion<T>>,
    composite: Vec<Inertia<T>>,
    /// Composite Coriolis matrices of the bodies.
    B: Vec<BodyCoriolis<T>>,
}

impl<T: Scalar> CoriolisScratch<T> {
    /// Makes memory for a model.
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        let n = model.n_bodies();
        Self {
            X_PB: vec![Transform::identity(); n],
            V: vec![Motion::zero(); n],
            composite: vec![Inertia::zero(); n],
            B: vec![BodyCoriolis::zero(); n],
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
    assert_eq!(
        out.shape(),
        (model.nv(), model.nv()),
        "the Coriolis matrix of \"{}\" is nv × nv",
        model.name()
    );
    out.fill(T::zero());
    add_coriolis_matrix(model, q, v, scratch, out);
}

/// Adds [`coriolis_matrix`] to the entries of a matrix.
pub(crate) fn add_coriolis_matrix<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    scratch: &mut CoriolisScratch<T>,
    out: &mut impl IndexMut<(usize, usize), Output = T>,
) {
    model.check_q(q);
    model.check_v(v);
    assert_eq!(
        scratch.V.len(),
        model.n_bodies(),
        "the scratch belongs to another model than \"{}\"",
        model.name()
    );
    outward(model, q, v, scratch);
    inward(model, scratch, out);
}

/// Velocities, and each composite starts as its own body.
fn outward<P: Scalar, T: Over<P>>(model: &Model<P>, q: &[T], v: &[T], s: &mut CoriolisScratch<T>) {
    for (i, body) in model.bodies().iter().enumerate() {
        let X = body.place(q);
        let V = velocity(body, &X, v, |p| s.V[p.0]);
        s.composite[i] = body.inertia.lift();
        s.B[i] = BodyCoriolis::of(&s.composite[i], &V);
        (s.X_PB[i], s.V[i]) = (X, V);
    }
}

/// Coriolis matrix of a body or a composite from motions to forces: of the motion (v, ω) the force (ω × f, D ω).
///
/// A body has B = ½ ((V ×*) I − I (V ×) + (I V) ×̄*), where F ×̄* U = U ×* F: the force of the body is I A + B V, and İ − 2B is skew-symmetric. With
/// I V = (f, n), the first moment h and the rotational inertia J,
///
/// > D = ½ (\[ω\] J − J \[ω\] − h vᵀ − v hᵀ − \[n\]) + (v · h) 1,
///
/// and the other blocks vanish. Neither moving to another frame nor sums change that.
#[derive(Clone, Copy, Debug)]
struct BodyCoriolis<T> {
    f: Vector3<T>,
    /// D by columns.
    turning: [Vector3<T>; 3],
}

impl<T: Scalar> BodyCoriolis<T> {
    fn zero() -> Self {
        Self {
            f: Vector3::zeros(),
            turning: [Vector3::zeros(); 3],
        }
    }

    /// That of a body.
    fn of(I: &Inertia<T>, V: &Motion<T>) -> Self {
        let momentum = I.times::<T>(V);
        let (h, v, n) = (&I.first_moment, &V.linear, &momentum.angular);
        // [ω] J, whose transpose is −J [ω].
        let W: [_; 3] = from_each(|k| cross(&V.angular, &I.rotational.column(k)));
        let transposed = rows(&from_columns(&W[0], &W[1], &W[2]));
        let along = dot(v, h);
        let turning = from_each(|k| {
            let axis = Vector3::from_fn(|row, _| T::constant(if row == k { 1.0 } else { 0.0 }));
            let symmetric = W[k] + transposed[k] - scale(h, v[k]) - scale(v, h[k]);
            scale(&(symmetric - cross(n, &axis)), T::constant(0.5)) + scale(&axis, along)
        });
        Self {
            f: momentum.linear,
            turning,
        }
    }

    /// B S.
    fn times(&self, S: &Motion<T>) -> Force<T> {
        let [a, b, c] = &self.turning;
        let w = &S.angular;
        let angular = scale(a, w.x) + scale(b, w.y) + scale(c, w.z);
        Force::new(cross(w, &self.f), angular)
    }

    /// Bᵀ S.
    fn times_transposed(&self, S: &Motion<T>) -> Force<T> {
        let along = self.turning.map_each(|column| dot(&column, &S.angular));
        Force::new(
            Vector3::zeros(),
            cross(&self.f, &S.linear) + Vector3::from(along),
        )
    }

    /// X* B X⁻¹: with the rotation R and the translation p the force R f, and R D Rᵀ − \[p\] \[R f\].
    fn moved(&self, X: &Transform<T>) -> Self {
        let (R, p) = (&X.rotation, &X.translation);
        let f = rotate(R, &self.f);
        let half = self.turning.map_each(|column| rotate(R, &column));
        let turning = rows(R).map_each(|row| {
            scale(&half[0], row.x) + scale(&half[1], row.y) + scale(&half[2], row.z)
        });
        // −[p] [f] = (p · f) 1 − f pᵀ
        let along = dot(p, &f);
        let turning = from_each(|k| {
            let mut column = turning[k] - scale(&f, p[k]);
            column[k] += along;
            column
        });
        Self { f, turning }
    }
}

impl<T: Scalar> AddAssign for BodyCoriolis<T> {
    fn add_assign(&mut self, other: Self) {
        self.f += other.f;
        for (own, other) in self.turning.iter_mut().zip(other.turning) {
            *own += other;
        }
    }
}

/// Passes inward from the leaves, for each joint j and every ancestor i, with Ṡ = V × S:
/// `C_ij = Sᵢᵀ (I_c Ṡⱼ + B_c Sⱼ)`,  `C_ji = Ṡᵢᵀ I_c Sⱼ + Sᵢᵀ B_cᵀ Sⱼ`; then the composites move on to the parent.
fn inward<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    s: &mut CoriolisScratch<T>,
    out: &mut impl IndexMut<(usize, usize), Output = T>,
) {
    for (j, body) in model.bodies().iter().enumerate().rev() {
        for (column, S) in body.columns() {
            let carried = PropagatedForces {
                forward: s.composite[j].times::<T>(&s.V[j].cross(&S)) + s.B[j].times(&S),
                inertial: s.composite[j].times::<T>(&S),
                transposed: s.B[j].times_transposed(&S),
            };
            carried.write(model, s, BodyId(j), column, out);
        }
        if let Some(p) = body.parent {
            let (X, I, B) = (s.X_PB[j], s.composite[j], s.B[j]);
            s.composite[p.0] = s.composite[p.0] + X.inertia(&I);
            s.B[p.0] += B.moved(&X);
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
        out: &mut impl IndexMut<(usize, usize), Output = T>,
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
