//! The named derivatives of the dynamics against finite differences and identities.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use dualbody::autodiff::{VectorFunction, finite_difference, jacobian};
use dualbody::dynamics::{
    AbaScratch, ForwardDynamicsDerivatives, ForwardDynamicsDerivativesScratch,
    InverseDynamicsDerivatives, InverseDynamicsDerivativesScratch, RneaScratch, center_of_mass,
    center_of_mass_derivatives, center_of_mass_jacobian, centroidal_momentum,
    centroidal_momentum_derivatives, centroidal_momentum_matrix, forward_dynamics,
    forward_dynamics_derivatives, forward_dynamics_derivatives_into, forward_dynamics_into,
    frame_jacobian, frame_placement_derivatives, frame_pose, frame_velocity,
    frame_velocity_derivatives, inverse_dynamics, inverse_dynamics_derivatives,
    inverse_dynamics_derivatives_into, inverse_dynamics_into, inverse_dynamics_second_derivatives,
    mass_matrix, mass_matrix_inverse,
};
use dualbody::model::{BodyId, FrameId, samples};
use dualbody::spatial::{Force, Representation};
use dualbody::{Model, Scalar};
use nalgebra::{DMatrix, DVector};

use crate::common::everything::REPRESENTATIONS;
use crate::common::{
    FINITE_DIFFERENCE, OTHER_ALGORITHM, Point, SAME_ALGEBRA, assert_close, random_point, robots,
};

/// One function of (δq, v, w) at a configuration.
struct Of<'a> {
    model: &'a Model,
    q: &'a DVector<f64>,
    what: What,
}

#[derive(Clone, Copy)]
enum What {
    Inverse,
    Forward,
    Placement,
    Velocity(Representation),
    CenterOfMass,
    Momentum,
}

impl VectorFunction for Of<'_> {
    fn n_outputs(&self) -> usize {
        match self.what {
            What::Inverse | What::Forward => self.model.nv(),
            What::Placement => 12,
            What::Velocity(_) | What::Momentum => 6,
            What::CenterOfMass => 3,
        }
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let (model, nv) = (self.model, self.model.nv());
        let last = FrameId(model.frames().len() - 1);
        let q = model.integrate(self.q.map(T::constant).as_slice(), &x[..nv]);
        let (q, v, w) = (q.as_slice(), &x[nv..2 * nv], &x[2 * nv..]);
        match self.what {
            What::Inverse => y.copy_from_slice(inverse_dynamics(model, q, v, w).as_slice()),
            What::Forward => y.copy_from_slice(forward_dynamics(model, q, v, w).as_slice()),
            What::Placement => {
                let pose = frame_pose(model, q, last);
                y[..9].copy_from_slice(pose.rotation.as_slice());
                y[9..].copy_from_slice(pose.translation.as_slice());
            }
            What::Velocity(representation) => {
                y.copy_from_slice(&frame_velocity(model, q, v, last, representation).to_array());
            }
            What::CenterOfMass => y.copy_from_slice(center_of_mass(model, q).as_slice()),
            What::Momentum => y.copy_from_slice(&centroidal_momentum(model, q, v).to_array()),
        }
    }
}

/// Finite differences in (δq, v, w), as three blocks.
fn numeric(model: &Model, point: &Point, what: What) -> [DMatrix<f64>; 3] {
    let nv = model.nv();
    let x = [
        vec![0.0; nv],
        point.v.as_slice().to_vec(),
        point.w.as_slice().to_vec(),
    ]
    .concat();
    let all = finite_difference::jacobian(
        &Of {
            model,
            q: &point.q,
            what,
        },
        &x,
    );
    std::array::from_fn(|k| all.columns(k * nv, nv).into_owned())
}

/// Twice the inertia, twice the force: data of a model that are kept for its derivatives must not outlive a change of the
/// model.
#[test]
fn derivatives_of_a_robot_made_twice_as_heavy_are_twice_as_large() {
    for model in robots() {
        let Point { q, v, w } = &random_point(&model, 22);
        let derivatives = |model: &Model| {
            inverse_dynamics_derivatives(model, q.as_slice(), v.as_slice(), w.as_slice())
        };
        let before = derivatives(&model);
        let bodies = (0..model.n_bodies()).map(BodyId);
        let heavy = bodies.fold(model.clone(), |model, body| {
            let inertia = model.body(body).inertia.scaled(2.0);
            model.with_inertia(body, inertia)
        });
        let after = derivatives(&heavy);
        assert_eq!(after.dq, &before.dq * 2.0, "{}", model.name());
        assert_eq!(after.dv, &before.dv * 2.0, "{}", model.name());
        assert_eq!(derivatives(&model), before, "{}", model.name());
    }
}

#[test]
fn inverse_and_forward_dynamics_derivatives_equal_finite_differences() {
    for model in robots() {
        let point = random_point(&model, 21);
        let (q, v, w) = (point.q.as_slice(), point.v.as_slice(), point.w.as_slice());
        let [dq, dv, da] = numeric(&model, &point, What::Inverse);
        let inverse = inverse_dynamics_derivatives(&model, q, v, w);
        assert_close(
            &inverse.dq,
            &dq,
            FINITE_DIFFERENCE,
            &format!("{}, ∂τ/∂q", model.name()),
        );
        assert_close(
            &inverse.dv,
            &dv,
            FINITE_DIFFERENCE,
            &format!("{}, ∂τ/∂v", model.name()),
        );
        assert_close(
            &inverse.da,
            &da,
            FINITE_DIFFERENCE,
            &format!("{}, ∂τ/∂a", model.name()),
        );
        assert_close(
            &inverse.da,
            &mass_matrix(&model, q),
            SAME_ALGEBRA,
            model.name(),
        );
        let [dq, dv, dtau] = numeric(&model, &point, What::Forward);
        let forward = forward_dynamics_derivatives(&model, q, v, w);
        assert_close(
            &forward.dq,
            &dq,
            FINITE_DIFFERENCE,
            &format!("{}, ∂v̇/∂q", model.name()),
        );
        assert_close(
            &forward.dv,
            &dv,
            FINITE_DIFFERENCE,
            &format!("{}, ∂v̇/∂v", model.name()),
        );
        assert_close(
            &forward.dtau,
            &dtau,
            FINITE_DIFFERENCE,
            &format!("{}, ∂v̇/∂τ", model.name()),
        );
        assert_close(
            &forward.dtau,
            &mass_matrix_inverse(&model, q),
            SAME_ALGEBRA,
            model.name(),
        );
    }
}

#[test]
fn derivatives_of_frames_and_momentum_equal_finite_differences_and_their_jacobians() {
    for model in robots() {
        let point = random_point(&model, 22);
        let (q, v) = (point.q.as_slice(), point.v.as_slice());
        let last = FrameId(model.frames().len() - 1);
        let name = model.name();
        let placement = frame_placement_derivatives(&model, q, last);
        assert_close(
            &placement,
            &numeric(&model, &point, What::Placement)[0],
            FINITE_DIFFERENCE,
            name,
        );
        // The translation's rate is the linear part of the mixed Jacobian.
        let mixed = frame_jacobian(&model, q, last, Representation::Mixed);
        assert_close(
            &placement.rows(9, 3).into(),
            &mixed.rows(0, 3).into(),
            SAME_ALGEBRA,
            name,
        );
        for representation in REPRESENTATIONS {
            let velocity = frame_velocity_derivatives(&model, q, v, last, representation);
            assert_close(
                &velocity.dq,
                &numeric(&model, &point, What::Velocity(representation))[0],
                FINITE_DIFFERENCE,
                name,
            );
            assert_close(
                &velocity.dv,
                &frame_jacobian(&model, q, last, representation),
                SAME_ALGEBRA,
                name,
            );
        }
        let com = center_of_mass_derivatives(&model, q);
        assert_close(
            &com,
            &numeric(&model, &point, What::CenterOfMass)[0],
            FINITE_DIFFERENCE,
            name,
        );
        assert_close(
            &com,
            &center_of_mass_jacobian(&model, q),
            SAME_ALGEBRA,
            name,
        );
        let momentum = centroidal_momentum_derivatives(&model, q, v);
        assert_close(
            &momentum.dq,
            &numeric(&model, &point, What::Momentum)[0],
            FINITE_DIFFERENCE,
            name,
        );
        assert_close(
            &momentum.dv,
            &centroidal_momentum_matrix(&model, q),
            SAME_ALGEBRA,
            name,
        );
    }
}

/// ∂τ/∂(δq, v, a) side by side, at the configuration q ⊕ δq.
fn first_derivatives(model: &Model, point: &Point, x: &[f64]) -> DMatrix<f64> {
    let nv = model.nv();
    let q = model.integrate(point.q.as_slice(), &x[..nv]);
    let d = inverse_dynamics_derivatives(model, q.as_slice(), &x[nv..2 * nv], &x[2 * nv..]);
    DMatrix::from_columns(
        &[d.dq.column_iter(), d.dv.column_iter(), d.da.column_iter()]
            .into_iter()
            .flatten()
            .collect::<Vec<_>>(),
    )
}

// Where directions of q commute (joints of one degree of freedom), the second derivatives are those of the first ones.
#[test]
fn second_derivatives_of_inverse_dynamics_equal_differences_of_the_first() {
    const STEP: f64 = 1e-5;
    for model in [samples::double_pendulum(), samples::cartpole()] {
        let (point, nv) = (random_point(&model, 23), model.nv());
        let second = inverse_dynamics_second_derivatives(
            &model,
            point.q.as_slice(),
            point.v.as_slice(),
            point.w.as_slice(),
        );
        let x = [
            vec![0.0; nv],
            point.v.as_slice().to_vec(),
            point.w.as_slice().to_vec(),
        ]
        .concat();
        for k in 0..3 * nv {
            let at = |step: f64| {
                let mut x = x.clone();
                x[k] += step;
                first_derivatives(&model, &point, &x)
            };
            let difference = (at(STEP) - at(-STEP)) / (2.0 * STEP);
            for (i, h) in second.iter().enumerate() {
                let row: DMatrix<f64> = h
                    .row(k)
                    .into_owned()
                    .reshape_generic(nalgebra::Dyn(1), nalgebra::Dyn(3 * nv));
                assert_close(
                    &row,
                    &difference.rows(i, 1).into(),
                    1e-7,
                    &format!("{}, τ{i}, direction {k}", model.name()),
                );
            }
        }
    }
}

/// (δq, v, w) ↦ inverse and forward dynamics under forces that move with their bodies.
struct Pushed<'a> {
    model: &'a Model,
    q: &'a DVector<f64>,
    external: &'a [Force<f64>],
    forward: bool,
}

impl VectorFunction for Pushed<'_> {
    fn n_outputs(&self) -> usize {
        self.model.nv()
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let (model, nv) = (self.model, self.model.nv());
        let q = model.integrate(self.q.map(T::constant).as_slice(), &x[..nv]);
        let (q, v, w) = (q.as_slice(), &x[nv..2 * nv], &x[2 * nv..]);
        let lift = |F: &Force<f64>| Force::from_array(F.to_array().map(T::constant));
        let external: Vec<Force<T>> = self.external.iter().map(lift).collect();
        if self.forward {
            let mut scratch = AbaScratch::new(model);
            forward_dynamics_into(model, q, v, w, &external, &mut scratch, y);
        } else {
            let mut scratch = RneaScratch::new(model);
            inverse_dynamics_into(model, q, v, w, &external, &mut scratch, y);
        }
    }
}

#[test]
fn derivatives_along_the_tree_equal_dense_duals_under_external_forces() {
    for model in robots() {
        for seed in 0..2 {
            let Point { q, v, w } = random_point(&model, seed);
            let external: Vec<Force<f64>> = (0..model.n_bodies())
                .map(|i| Force::from_array(std::array::from_fn(|k| ((6 * i + k) as f64).sin())))
                .collect();
            let (nv, mut at) = (model.nv(), vec![0.0; model.nv()]);
            at.extend(v.iter().chain(&w));
            let dense = |forward| {
                let (model, q, external) = (&model, &q, &external);
                let f = Pushed {
                    model,
                    q,
                    external,
                    forward,
                };
                jacobian(&f, &at)
            };
            let mut inverse = InverseDynamicsDerivatives::zeros(&model);
            inverse_dynamics_derivatives_into(
                &model,
                q.as_slice(),
                v.as_slice(),
                w.as_slice(),
                &external,
                &mut InverseDynamicsDerivativesScratch::new(&model),
                &mut inverse,
            );
            let mut forward = ForwardDynamicsDerivatives::zeros(&model);
            forward_dynamics_derivatives_into(
                &model,
                q.as_slice(),
                v.as_slice(),
                w.as_slice(),
                &external,
                &mut ForwardDynamicsDerivativesScratch::new(&model),
                &mut forward,
            );
            let (of_inverse, of_forward) = (dense(false), dense(true));
            for (k, (actual, name)) in [
                (&inverse.dq, "dτ/dq"),
                (&inverse.dv, "dτ/dv"),
                (&inverse.da, "dτ/da"),
                (&forward.dq, "da/dq"),
                (&forward.dv, "da/dv"),
                (&forward.dtau, "da/dτ"),
            ]
            .into_iter()
            .enumerate()
            {
                let (all, tolerance) = if k < 3 {
                    (&of_inverse, SAME_ALGEBRA)
                } else {
                    (&of_forward, OTHER_ALGORITHM)
                };
                let expected = all.columns(k % 3 * nv, nv);
                let error = (actual - expected).amax() / expected.amax().max(1.0);
                assert!(
                    error <= tolerance,
                    "{}, seed {seed}: {name} is off by {error:e}",
                    model.name()
                );
            }
        }
    }
}
