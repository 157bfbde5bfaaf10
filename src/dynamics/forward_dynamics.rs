//! Forward dynamics: accelerations from forces.

use nalgebra::DVector;

use super::aba::Driven;
use super::calls::Calls;
use super::differential::DifferentialScratch;
use super::direct::DirectScratch;
use super::joint_friction::{Decision, JointFriction};
use super::rnea::{Motions, RneaScratch};
use crate::model::Model;
use crate::scalar::{Over, Scalar, compiled_over_f64};
use crate::spatial::Force;

/// Working memory of [`forward_dynamics_into`]. It belongs to the model that it was made for and to clones of it; when
/// masses, placements or armature have changed, a new one is needed.
#[derive(Clone, Debug)]
pub struct AbaScratch<T> {
    n_bodies: usize,
    way: Way<T>,
}

/// Way of forward dynamics: on the scalar itself, or on its values first.
#[derive(Clone, Debug)]
enum Way<T> {
    Direct(Box<DirectScratch<T>>),
    Differential(Box<DifferentialScratch<T>>),
}

impl<T: Scalar> AbaScratch<T> {
    /// Makes memory for a model.
    ///
    /// # Panics
    /// If its mass matrix is singular, with the message of [`Model::check_mass_matrix`].
    pub fn new<P: Scalar>(model: &Model<P>) -> Self {
        Self::for_calls(model, Calls::Many)
    }

    /// Memory for a model that is called so often.
    pub(crate) fn for_calls<P: Scalar>(model: &Model<P>, calls: Calls) -> Self {
        model.assert_mass_matrix();
        let way = match DifferentialScratch::new(model, calls) {
            Some(differential) => Way::Differential(differential),
            None => Way::Direct(Box::new(DirectScratch::new(model, calls))),
        };
        Self {
            n_bodies: model.n_bodies(),
            way,
        }
    }

    /// The motions of all bodies at the accelerations that were last computed, if this memory has them since [`forget`](Self::forget).
    pub(crate) fn motions(&self) -> Option<Motions<'_, T>> {
        match &self.way {
            Way::Direct(direct) => direct.motions(),
            Way::Differential(_) => None,
        }
    }

    /// Whether this memory has these motions in the lanes of a packed tree instead.
    pub(crate) fn has_packed_motions(&self) -> bool {
        match &self.way {
            Way::Direct(direct) => direct.has_packed_motions(),
            Way::Differential(_) => false,
        }
    }

    /// Hands those of some bodies to the working memory of inverse dynamics.
    pub(crate) fn copy_packed_motions(&self, bodies: &[usize], out: &mut RneaScratch<T>) {
        if let Way::Direct(direct) = &self.way {
            direct.copy_packed_motions(bodies, out);
        }
    }

    /// Drops the motions of the bodies: the state is another one.
    pub(crate) fn forget(&mut self) {
        if let Way::Direct(direct) = &mut self.way {
            direct.forget();
        }
    }
}

/// Computes the accelerations that the joint forces `tau` produce:  v̇ = M(q)⁻¹ (τ − h(q, v)).
///
/// O(n), but O(nv³) with mimic joints. Allocates its result and working memory.
///
/// Over numbers with derivatives, the algorithm is evaluated on values, and inverse dynamics once for each order of the derivatives. Four first
/// derivatives cost five times (an arm) to ten times (a humanoid) as much as values.
///
/// * `q` – configuration, length `nq`
/// * `v` – velocity in tangent coordinates, length `nv` (rad/s or m/s)
/// * `tau` – joint forces, length `nv` (N·m or N)
///
/// # Panics
/// If a slice has the wrong length, or the mass matrix is singular: [`Model::check_mass_matrix`] checks this beforehand.
///
/// # Examples
/// ```
/// use dualbody::{dynamics::forward_dynamics, model::samples};
///
/// // A rod of 1 m let go at the horizontal: v̇ = −(m g l / 2) / (m l² / 3) = −3 g / 2
/// let a = forward_dynamics(&samples::pendulum(), &[std::f64::consts::FRAC_PI_2], &[0.0], &[0.0]);
/// assert!((a[0] + 1.5 * 9.81).abs() < 1e-12);
/// ```
///
/// # References
/// [Featherstone 2008, table 7.1].
pub fn forward_dynamics<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    tau: &[T],
) -> DVector<T> {
    compiled_over_f64!(
        [P, T] accelerations, model: &Model, q: &[f64], v: &[f64], tau: &[f64] => DVector<f64> as DVector<T>
    )
}

fn accelerations<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    tau: &[T],
) -> DVector<T> {
    let mut a = DVector::zeros(model.nv());
    forward_dynamics_into(
        model,
        q,
        v,
        tau,
        &[],
        &mut AbaScratch::for_calls(model, Calls::One),
        a.as_mut_slice(),
    );
    a
}

/// [`forward_dynamics`] with external forces and without allocation:  v̇ = M⁻¹ (τ − h + Σᵢ Jᵢᵀ Fᵢ).
///
/// * `external` – force on each body in its body frame, length `n_bodies`, see
///   [`add_frame_force`](super::add_frame_force); empty for none
/// * `a` – output, length `nv` (rad/s² or m/s²)
///
/// # Panics
/// If an argument has the wrong size for the model.
pub fn forward_dynamics_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    tau: &[T],
    external: &[Force<T>],
    scratch: &mut AbaScratch<T>,
    a: &mut [T],
) {
    compiled_over_f64!(
        [P, T] accelerate, model: &Model, q: &[f64], v: &[f64], tau: &[f64], external: &[Force<f64>], scratch: &mut AbaScratch<f64>, a: &mut [f64]
    );
}

fn accelerate<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    tau: &[T],
    external: &[Force<T>],
    scratch: &mut AbaScratch<T>,
    a: &mut [T],
) {
    resisted_forward_dynamics_into(model, q, v, tau, &[], external, scratch, a);
}

/// [`resisted_forward_dynamics_into`] with dry friction of joints, of which the pieces that hold are found too.
///
/// * `friction` – of all coordinates
///
/// Returns by how many pieces the law is broken, zero as a rule; nothing, and computes nothing, where it cannot: over numbers that are more than values, and
/// with mimic joints.
pub(crate) fn frictional_forward_dynamics_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    driven: &Driven<'_, T>,
    friction: &mut Vec<JointFriction<T>>,
    decision: Decision,
    scratch: &mut AbaScratch<T>,
    a: &mut [T],
) -> Option<T> {
    check(model, driven, scratch, a);
    match &mut scratch.way {
        Way::Direct(direct) if const { T::HAS_VALUES && T::ORDER == 0 } => {
            direct.frictional_accelerations(model, driven, friction, decision, a)
        }
        _ => None,
    }
}

/// Computes the accelerations under forces that grow against them:  v̇ = (M + R)⁻¹ (τ − h + Σᵢ Jᵢᵀ Fᵢ)  with a diagonal
/// R, as if joints had additional rotor inertia. [`forward_dynamics_into`] for R = 0.
///
/// * `resistance` – R, length `nv` (kg·m² or kg); empty for none
pub(crate) fn resisted_forward_dynamics_into<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    q: &[T],
    v: &[T],
    tau: &[T],
    resistance: &[T],
    external: &[Force<T>],
    scratch: &mut AbaScratch<T>,
    a: &mut [T],
) {
    let driven = Driven {
        q,
        v,
        tau,
        resistance,
        external,
    };
    check(model, &driven, scratch, a);
    match &mut scratch.way {
        Way::Differential(differential) => differential.accelerations(model, &driven, a),
        Way::Direct(direct) => {
            // A constant: unused branches are not compiled for a type.
            assert!(
                const { T::LANES > 1 || T::ORDER != 1 },
                "numbers with first derivatives have memory of their own"
            );
            direct.accelerations(model, &driven, a);
        }
    }
}

fn check<P: Scalar, T: Over<P>>(
    model: &Model<P>,
    driven: &Driven<'_, T>,
    scratch: &AbaScratch<T>,
    a: &[T],
) {
    model.check_q(driven.q);
    [driven.v, driven.tau, a]
        .into_iter()
        .for_each(|x| model.check_v(x));
    model.check_external(driven.external);
    assert_eq!(
        scratch.n_bodies,
        model.n_bodies(),
        "the scratch belongs to another model than \"{}\"",
        model.name()
    );
}
