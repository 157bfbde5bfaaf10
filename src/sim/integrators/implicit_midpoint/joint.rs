//! Momenta of a joint whose configuration is not a vector, transported along its motion.
//!
//! Its coordinates are a Lie algebra (see [`joint`](crate::joint)). With half of the tangent of a step, φ = ½ Δt ξ, momenta along the axes of the start go to
//! those of the middle by A = Ad(exp φ)ᵀ, and on to those of the end by the same. The differential of the exponential, seen from where it starts, is
//! dexp φ = Σ adⁿ φ / (n + 1)!.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use crate::joint::{JointKind, MAX_NV};
use crate::linalg::product::add_scaled;
use crate::model::Body;
use crate::model::manifold::v_range;
use crate::scalar::{Dual, MapEach, Scalar, from_each};
use crate::sim::integrators::joint_tangents::{Part, in_both, integrated_alone, seeded};
use crate::spatial::{Force, SPATIAL};

/// Numbers of one joint along its axes, the first `nv` of which count.
pub(super) type Along<T> = [T; MAX_NV];

/// Matrix of one joint, row by row.
pub(super) type OwnMatrix<T> = [[T; MAX_NV]; MAX_NV];

/// Terms of the series of dexp: with half a revolution in half of a step the next one is 1e-10 of the sum, with half of that 1e-17.
const TERMS: usize = 20;

/// Ad(exp φ)ᵀ p: a momentum along the axes after a motion, from those before it. One coordinate alone keeps its axis.
pub(super) fn carried<T: Scalar>(joint: JointKind, phi: &Along<T>, p: &Along<T>) -> Along<T> {
    let (nq, nv) = (joint.nq(), joint.nv());
    if nv == 1 {
        return *p;
    }
    let (mut start, mut end) = ([T::zero(); MAX_NV + 1], [T::zero(); MAX_NV + 1]);
    joint.neutral(&mut start[..nq]);
    joint.integrate(&start[..nq], &phi[..nv], &mut end[..nq]);
    let X = joint.transform(&end[..nq]);
    from_force(joint, &X.force_inverse(&to_force(joint, p)))
}

/// (dexp φ)ᵀ x; x itself for one coordinate.
fn dexp_transposed<T: Scalar>(joint: JointKind, phi: &Along<T>, x: &Along<T>) -> Along<T> {
    if joint.nv() == 1 {
        return *x;
    }
    let V = joint.motion(&phi[..joint.nv()]);
    let (mut term, mut out) = (*x, *x);
    for n in 0..TERMS {
        let turned = -V.cross_force(&to_force(joint, &term));
        term = from_force(joint, &turned).map_each(|x| x / (n as f64 + 2.0));
        out.iter_mut().zip(term).for_each(|(out, x)| *out += x);
    }
    out
}

fn to_force<T: Scalar>(joint: JointKind, x: &Along<T>) -> Force<T> {
    let mut F = [T::zero(); SPATIAL];
    for (axis, &x) in joint.axes().zip(x) {
        F[axis.coordinate()] = x;
    }
    Force::from_array(F)
}

fn from_force<T: Scalar>(joint: JointKind, F: &Force<T>) -> Along<T> {
    let (F, mut out) = (F.to_array(), [T::zero(); MAX_NV]);
    for (axis, out) in joint.axes().zip(&mut out) {
        *out = F[axis.coordinate()];
    }
    out
}

/// The momentum of the middle of a step: (dexp 2φ)ᵀ p₀ + (dexp φ)ᵀ w = (dexp φ)ᵀ (½ (1 + A) p₀ + w) with the momentum p₀ of the start and half of the
/// impulse, w.
pub(super) fn at_middle<T: Scalar>(
    joint: JointKind,
    phi: &Along<T>,
    p: &Along<T>,
    half_impulse: &Along<T>,
) -> Along<T> {
    let mut x = carried(joint, phi, p);
    for k in 0..joint.nv() {
        x[k] = (x[k] + p[k]) * 0.5 + half_impulse[k];
    }
    dexp_transposed(joint, phi, &x)
}

/// The momentum of the end of a step: A (A p₀ + the impulse).
pub(super) fn at_end<T: Scalar>(
    joint: JointKind,
    phi: &Along<T>,
    p: &Along<T>,
    impulse: &Along<T>,
) -> Along<T> {
    let mut x = carried(joint, phi, p);
    x.iter_mut().zip(impulse).for_each(|(x, &y)| *x += y);
    carried(joint, phi, &x)
}

/// Numbers of one joint out of those of all.
pub(super) fn own<T: Scalar, P>(body: &Body<P>, x: &[T]) -> Along<T> {
    let mut out = [T::zero(); MAX_NV];
    out.iter_mut()
        .zip(&x[v_range(body)])
        .for_each(|(out, &x)| *out = x);
    out
}

/// Derivatives of the step of a single joint.
#[derive(Clone, Debug)]
pub(super) struct JointDerivatives<T> {
    /// Index of its first coordinate, and their number.
    pub(super) first: usize,
    pub(super) nv: usize,
    /// Of the configurations of middle and end, each in its tangent space, in that of the start and in ξ.
    pub(super) middle: [OwnMatrix<T>; 2],
    pub(super) end: [OwnMatrix<T>; 2],
    /// A.
    pub(super) carry: OwnMatrix<T>,
    /// Of the momentum of the middle in ξ and in half of the impulse; of that of the end in ξ.
    pub(super) momentum: [OwnMatrix<T>; 2],
    pub(super) end_momentum: OwnMatrix<T>,
}

/// Position of one joint in a step.
pub(super) struct JointStep<'a, T> {
    /// Configuration of the start.
    pub(super) q: &'a [T],
    /// Tangents there of the middle, which is φ, and of the end.
    pub(super) offsets: [&'a [T]; 2],
    pub(super) p: &'a [T],
    pub(super) impulse: &'a [T],
    pub(super) dt: f64,
}

impl<T: Scalar> JointDerivatives<T> {
    /// Of a step in which nothing happens.
    pub(super) fn new<P: Scalar>(body: &Body<P>) -> Self {
        let zero = [[T::zero(); MAX_NV]; MAX_NV];
        Self {
            first: body.v,
            nv: body.joint.nv(),
            middle: [zero; 2],
            end: [zero; 2],
            carry: zero,
            momentum: [zero; 2],
            end_momentum: zero,
        }
    }

    /// Finds them.
    pub(super) fn find(&mut self, body: &Body<f64>, at: &JointStep<'_, T>) {
        self.middle = moved(body.joint, at.q, at.offsets[0], 0.5 * at.dt);
        self.end = moved(body.joint, at.q, at.offsets[1], at.dt);
        self.find_momenta(body, at);
    }

    fn find_momenta(&mut self, body: &Body<f64>, at: &JointStep<'_, T>) {
        let (joint, nv) = (body.joint, body.joint.nv());
        let [middle, end, carry] = in_both(joint, |first| {
            let of = |x: &[T], slope: f64, direction: usize| -> Along<Part<T>> {
                let mut out = [Dual::from(0.0); MAX_NV];
                for (k, &x) in x.iter().enumerate() {
                    out[k] = seeded(x, T::constant(slope), direction + k, first);
                }
                out
            };
            let phi = of(at.offsets[0], 0.5 * at.dt, 0);
            let (p, impulse) = (of(at.p, 0.0, 0), of(at.impulse, 2.0, nv));
            let middle = at_middle(joint, &phi, &p, &impulse.map_each(|x| x * 0.5));
            let end = at_end(joint, &phi, &p, &of(at.impulse, 0.0, 0));
            [middle, end, carried(joint, &phi, &of(at.p, 1.0, nv))]
        });
        self.momentum = [part(&middle, 0), part(&middle, MAX_NV)];
        self.end_momentum = part(&end, 0);
        self.carry = part(&carry, MAX_NV);
    }

    /// The coordinates of the joint.
    pub(super) fn range(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.nv
    }
}

/// Derivatives of q ⊕ offset in the tangent at q, and in the velocity of which the offset is so many times.
fn moved<T: Scalar>(joint: JointKind, q: &[T], offset: &[T], time: f64) -> [OwnMatrix<T>; 2] {
    let mut end = [T::zero(); MAX_NV + 1];
    joint.integrate(q, offset, &mut end[..q.len()]);
    let x = integrated_alone(joint, q, offset, &end[..q.len()]);
    [
        part(&x, 0),
        part(&x, MAX_NV).map_each(|row| row.map_each(|x| x * time)),
    ]
}

/// Some directions of dual numbers.
fn part<T: Scalar, const N: usize>(x: &Along<Dual<T, N>>, first: usize) -> OwnMatrix<T> {
    x.map_each(|x| from_each(|k| x.eps[first + k]))
}

/// x ← m x of one joint.
pub(super) fn apply<T: Scalar>(m: &OwnMatrix<T>, x: &mut [T]) {
    let mut known = [T::zero(); MAX_NV];
    known[..x.len()].copy_from_slice(x);
    for (x, row) in x.iter_mut().zip(m) {
        let products = row.iter().zip(&known);
        *x = products.fold(T::zero(), |sum, (&m, &x)| sum + m * x);
    }
}

/// out += mᵀ x of one joint.
pub(super) fn add_transposed<T: Scalar>(m: &OwnMatrix<T>, x: &[T], out: &mut [T]) {
    for (row, &x) in m.iter().zip(x) {
        let row = &row[..out.len()];
        add_scaled(out, row, x);
    }
}

/// x ← mᵀ x of one joint.
pub(super) fn apply_transposed<T: Scalar>(m: &OwnMatrix<T>, x: &mut [T]) {
    let mut known = [T::zero(); MAX_NV];
    known[..x.len()].copy_from_slice(x);
    let known = &known[..x.len()];
    x.fill(T::zero());
    add_transposed(m, known, x);
}
