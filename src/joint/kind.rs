//! A joint kind as a type: what algorithms are compiled for.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;
use rand::Rng;

use super::{Axis, Coordinate};
use crate::scalar::{Over, Scalar, pairs};
use crate::spatial::{ArticulatedInertia, Force, Motion, Transform};

/// A joint kind; without data except the pitch of a screw. Each is one file, and one line of [`with_joint!`]. [`JointKind`](super::JointKind)
/// is one as well, of which is known only at run time which it is: algorithms are compiled once for all kinds that are rare.
///
/// The velocity is that of the body frame B with respect to the joint frame J, expressed in B, where the motion subspace S is constant:
/// so the bias `Ṡ v` is zero, and the tangent space is a Lie algebra whose exponential is [`integrate`](Self::integrate).
///
/// Slices of coordinates have the lengths `nq` and `nv`.
pub(crate) trait Joint: Copy {
    /// Number of configuration coordinates.
    fn nq(self) -> usize;
    /// Number of velocity coordinates.
    fn nv(self) -> usize;

    /// One `X` per degree of freedom.
    type PerDof<X: Copy>: Copy + AsRef<[X]> + AsMut<[X]>;

    /// `[f(0), f(1), …]`, laid out flat: `std::array::from_fn` is not always inlined.
    fn per_dof<X: Copy>(self, f: impl FnMut(usize) -> X) -> Self::PerDof<X>;

    /// The coordinates of the spatial vector that the columns of S are along.
    fn coordinates(self) -> &'static [usize];

    /// Advance along z beside a turn about z, m/rad; 0 except for a screw.
    #[inline(always)]
    fn pitch(self) -> f64 {
        0.0
    }

    /// Column k of S.
    #[inline(always)]
    fn axis(self, k: usize) -> Axis {
        Axis::new(self.coordinates()[k], self.pitch())
    }

    /// Quantity that the k-th number of q measures: a displacement along or about the k-th axis, where there are as many numbers as axes.
    fn measures(self, k: usize) -> Coordinate {
        self.axis(k).displacement()
    }

    /// `true` if the axes of its linear velocity turn with the body.
    #[inline(always)]
    fn turns_with_body(self) -> bool {
        false
    }

    /// `X_JB(q)`.
    fn transform<T: Scalar>(self, q: &[T]) -> Transform<T>;

    /// `X_PB = X_PJ X_JB(q)`; `sin_cos` are the sine and cosine of the first coordinate, for kinds where it is an angle.
    #[inline(always)]
    fn compose<P: Scalar, T: Over<P>>(
        self,
        X_PJ: &Transform<P>,
        q: &[T],
        sin_cos: impl FnOnce() -> (T, T),
    ) -> Transform<T> {
        let _ = sin_cos;
        X_PJ.lift::<T>() * self.transform(q)
    }

    /// `X_JB(q)⁻¹ V` of a motion that is data.
    #[inline(always)]
    fn motion_inverse<P: Scalar, T: Over<P>>(self, q: &[T], V: &Motion<P>) -> Motion<T> {
        self.transform(q).data_motion_inverse(V)
    }

    /// `X_JB(q)* F` of a force that is data.
    #[inline(always)]
    fn force<P: Scalar, T: Over<P>>(self, q: &[T], F: &Force<P>) -> Force<T> {
        self.transform(q).data_force(F)
    }

    /// V += S v.
    #[inline(always)]
    fn add_motion<T: Scalar>(self, v: &[T], V: &mut Motion<T>) {
        for (k, &v) in v.iter().enumerate().take(self.nv()) {
            let axis = self.axis(k);
            *V.coordinate_mut(axis.coordinate()) += v;
            if axis.pitch() != 0.0 {
                V.linear.z += v * axis.pitch();
            }
        }
    }

    /// V × S v.
    #[inline(always)]
    fn velocity_product<T: Scalar>(self, V: &Motion<T>, v: &[T]) -> Motion<T> {
        let mut own = Motion::zero();
        self.add_motion(v, &mut own);
        V.cross(&own)
    }

    /// I C for a velocity product C, which has no components along and about z where the joint moves along or about it.
    #[inline(always)]
    fn times_velocity_product<T: Scalar>(
        self,
        I: &ArticulatedInertia<T>,
        C: &Motion<T>,
    ) -> Force<T> {
        I.times(C)
    }

    /// Sᵀ F, coordinate by coordinate.
    #[inline(always)]
    fn project<T: Scalar>(self, F: &Force<T>, mut each: impl FnMut(usize, T)) {
        for k in 0..self.nv() {
            each(k, self.axis(k).project(F));
        }
    }

    /// out = q ⊕ dv; coordinate by coordinate, where those of position and velocity are the same.
    #[inline(always)]
    fn integrate<T: Scalar>(self, q: &[T], dv: &[T], out: &mut [T]) {
        for k in 0..self.nv() {
            out[k] = q[k] + dv[k];
        }
    }

    /// out = q1 ⊖ q0.
    #[inline(always)]
    fn difference<T: Scalar>(self, q0: &[T], q1: &[T], out: &mut [T]) {
        for k in 0..self.nv() {
            out[k] = q1[k] - q0[k];
        }
    }

    /// The second half of a step of semi-implicit Euler. Comes with the velocity `next_v` after it along the axes of before it; gives the
    /// position, and the velocity along the axes of after it.
    ///
    /// * `center` – the point of the body that flies straight in the step, in the body, of kinds whose linear velocity turns with the body
    #[inline(always)]
    fn advance<D: Scalar, T: Over<D>>(
        self,
        center: &Vector3<T>,
        q: &[T],
        dt: D,
        next_q: &mut [T],
        next_v: &mut [T],
    ) {
        let _ = center;
        let mut turn = [T::zero(); super::MAX_NV];
        for (turn, &v) in pairs(&mut turn, &*next_v) {
            *turn = v * dt;
        }
        self.integrate(q, &turn[..self.nv()], next_q);
    }

    /// The configuration with B = J.
    fn neutral<T: Scalar>(self, out: &mut [T]) {
        out[..self.nq()].fill(T::zero());
    }

    /// A random configuration.
    fn random<R: Rng + ?Sized>(self, rng: &mut R, out: &mut [f64]);
}

/// The sizes of a kind: coordinates `nq`, degrees of freedom `nv` and their numbers, the coordinates that the columns of S are along.
macro_rules! sizes {
    (nq = $nq:literal, nv = $nv:literal: $($k:literal)*, axes = $axes:expr) => {
        #[inline(always)]
        fn nq(self) -> usize {
            $nq
        }

        #[inline(always)]
        fn nv(self) -> usize {
            $nv
        }

        type PerDof<X: Copy> = [X; $nv];

        #[inline(always)]
        fn per_dof<X: Copy>(self, mut _f: impl FnMut(usize) -> X) -> [X; $nv] {
            [$(_f($k)),*]
        }

        #[inline(always)]
        fn coordinates(self) -> &'static [usize] {
            &$axes
        }
    };
}
pub(super) use sizes;

/// Runs a piece of code with the type of a joint kind; with `else`, only that of the frequent kinds, which have one coordinate axis, and
/// other code for the rest: the same out of line, with `rare`, of which only free motion, which most robots without a fixed base have once, is
/// compiled by itself, and [`JointKind`](super::JointKind) is the type of all others.
macro_rules! with_joint {
    (rare $kind:expr, $joint:ident => $run:expr) => {
        match $kind {
            $crate::joint::JointKind::Floating => {
                let $joint = $crate::joint::Floating;
                $run
            }
            $joint => $run,
        }
    };
    ($kind:expr, $joint:ident => $frequent:expr, else $rare:expr) => {
        match $kind {
            $crate::joint::JointKind::Revolute | $crate::joint::JointKind::Continuous => {
                let $joint = $crate::joint::Revolute;
                $frequent
            }
            $crate::joint::JointKind::Prismatic => {
                let $joint = $crate::joint::Prismatic;
                $frequent
            }
            _ => $rare,
        }
    };
    ($kind:expr, $joint:ident => $run:expr) => {
        $crate::joint::with_joint!(
            @all $kind, $joint => $run;
            Fixed => $crate::joint::Fixed,
            Revolute => $crate::joint::Revolute,
            Continuous => $crate::joint::Revolute,
            Prismatic => $crate::joint::Prismatic,
            Screw(pitch) => $crate::joint::Screw { pitch },
            Universal => $crate::joint::Universal,
            Spherical => $crate::joint::Spherical,
            Planar => $crate::joint::Planar,
            Floating => $crate::joint::Floating,
        )
    };
    (@all $kind:expr, $joint:ident => $run:expr; $($name:ident $(($data:ident))? => $type:expr),* $(,)?) => {
        match $kind {
            $($crate::joint::JointKind::$name $(($data))? => {
                let $joint = $type;
                $run
            })*
        }
    };
}
pub(crate) use with_joint;
