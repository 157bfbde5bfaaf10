//! The check of derivatives by differences, where it is hard: inputs of very different sizes, and steps in contact.

use dualbody::autodiff::finite_difference::{Options, estimate};
use dualbody::autodiff::{VectorFunction, jacobian};
use dualbody::contact::{ContactLaw, RelaxedRigid, Rigid, SoftContact, Terrain};
use dualbody::dynamics::{MassMatrixFactor, bias_forces, forward_dynamics, mass_matrix};
use dualbody::linearize::LinearizationEstimate;
use dualbody::{Integrator, Linearization, Model, Scalar, Simulator, State};
use nalgebra::{DMatrix, Vector3};

use crate::common::everything::INTEGRATORS;
use crate::common::ground::{free, hills, on, run, waves};
use crate::common::{Point, asset, random_point};

/// Accelerations as a function of all parameters of a robot.
struct InParameters(Model, Point);

impl VectorFunction for InParameters {
    fn n_outputs(&self) -> usize {
        self.0.nv()
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let lift = |x: &[f64]| x.iter().map(|&x| T::constant(x)).collect::<Vec<T>>();
        let Point { q, v, w } = &self.1;
        let (q, v, w) = (lift(q.as_slice()), lift(v.as_slice()), lift(w.as_slice()));
        let model: Model<T> = self.0.cast();
        let model = model.with_parameters(x);
        if T::ORDER > 0 {
            y.copy_from_slice(forward_dynamics(&model, &q, &v, &w).as_slice());
            return;
        }
        // Differences lead to negative inertias, which forward dynamics refuses: M a = τ − h.
        let bias = bias_forces(&model, &q, &v);
        let forces = w.iter().zip(bias.iter());
        y.iter_mut()
            .zip(forces)
            .for_each(|(y, (&tau, &bias))| *y = tau - bias);
        MassMatrixFactor::new(&model, &mass_matrix(&model, &q)).solve(y);
    }
}

// The last wrist of a UR5 has 1.32e-4 kg m² about its axis: steps of 1e-3 lead across the pole of the acceleration, to
// derivatives of 5e3 instead of −6e7.
#[test]
fn derivatives_of_accelerations_in_small_inertias_equal_finite_differences() {
    for name in ["ur5.urdf", "humanoid.urdf"] {
        let model = asset(name);
        let x = model.parameters();
        let names = model.parameter_layout();
        let point = random_point(&model, 7);
        let f = InParameters(model, point);
        let exact = jacobian(&f, x.as_slice());
        let numeric = estimate(&f, x.as_slice(), &Options::default());
        for k in 0..x.len() {
            let largest = exact.column(k).amax();
            for row in 0..exact.nrows() {
                let off = (exact[(row, k)] - numeric.jacobian[(row, k)]).abs();
                let error = numeric.error[(row, k)];
                let what = format!(
                    "{name}, {}, {row}: off by {off} of {largest}",
                    names.names()[k]
                );
                assert!(off <= 2.0 * error + 1e-8 * largest, "{what}, said {error}");
                // Steps follow inputs down to 1e-6: rounding of the humanoid's accelerations leaves 1.05e-5 at a first
                // moment of 2e-6 kg m.
                let most = if x[k].abs() < 1e-5 { 2e-5 } else { 1e-5 };
                assert!(error <= most * largest.max(1.0), "{what}, said {error}");
            }
        }
    }
}

/// The two Jacobians side by side.
fn both(of: &Linearization) -> DMatrix<f64> {
    let (n, m) = (of.a.ncols(), of.b.ncols());
    let mut out = of.a.clone().resize_horizontally(n + m, 0.0);
    out.columns_mut(n, m).copy_from(&of.b);
    out
}

/// The largest difference between derivatives and differences, and its remainder beyond the error that differences
/// admit.
fn compare(simulator: &Simulator, state: &State) -> (f64, f64) {
    let u = vec![0.0; simulator.nu()];
    let exact = both(&simulator.linearize(state, &u));
    let LinearizationEstimate {
        linearization,
        error,
    } = simulator.estimate_linearization(state, &u, &Options::default());
    let off = (both(&linearization) - &exact).abs();
    let size = exact.amax();
    let beyond = (&off - both(&error) * 2.0).max();
    (off.amax() / size, beyond / size)
}

fn laws() -> [ContactLaw; 3] {
    [
        ContactLaw::Soft(SoftContact::estimate(1.0, 1, 1e-3)),
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        ContactLaw::Rigid(Rigid::default()),
    ]
}

// Points that touch by a tenth of a millimetre, or are as far above the ground: with steps of an inch, differences are
// off by more than A.
#[test]
fn linearization_by_finite_differences_equals_the_exact_one_in_contact() {
    for terrain in [Terrain::flat(0.0), Terrain::incline(0.1), hills(), waves()] {
        for (law, integrator) in laws().into_iter().flat_map(|l| INTEGRATORS.map(|i| (l, i))) {
            if !matches!(law, ContactLaw::Soft(_)) && integrator == Integrator::RungeKutta4 {
                continue;
            }
            let simulator =
                on(asset("sphere.urdf"), terrain.clone(), law).with_integrator(integrator);
            let ground = terrain.surface(&0.1, &0.2);
            for (name, gap, v) in [
                ("flight", 1e-4, [0.3, 0.4, 1.0, 0.2, 0.1, 0.5]),
                ("landing", 2e-4, [0.2, 0.1, -1.0, 0.2, 0.1, 0.5]),
                ("sliding", -1e-4, [1.0, 0.4, -0.5, 0.2, 0.1, 0.5]),
            ] {
                let centre = Vector3::new(0.1, 0.2, ground.height) + ground.normal() * (0.1 + gap);
                let place = centre.into();
                let mut state = free(&simulator, place, 0.3, v);
                state
                    .contact
                    .fill(if name == "sliding" { 2e-5 } else { 0.0 });
                let (off, _) = compare(&simulator, &state);
                assert!(
                    off < 1e-6,
                    "{terrain:?} {law:?} {integrator:?} {name}: {off:e}"
                );
            }
        }
    }
}

// At rest, at the moment of touch-down and where friction reverses the two sides of a law meet: differences are the
// mean of both slopes.
#[test]
fn linearization_by_finite_differences_admits_its_error_where_laws_have_a_kink() {
    for law in laws() {
        let ball = on(asset("sphere.urdf"), Terrain::flat(0.0), law);
        let touching = free(
            &ball,
            [0.0, 0.0, 0.1],
            0.0,
            [0.0, 0.0, -1e-3, 0.0, 0.0, 0.0],
        );
        let cube = on(asset("box.urdf"), Terrain::flat(0.0), law);
        let resting = run(&cube, &free(&cube, [0.0, 0.0, 0.06], 0.0, [0.0; 6]), 1.0);
        for (name, simulator, state) in [("touching", &ball, touching), ("resting", &cube, resting)]
        {
            let (off, beyond) = compare(simulator, &state);
            assert!(
                beyond < 1e-6,
                "{law:?} {name}: off by {off:e}, {beyond:e} not admitted"
            );
        }
    }
}
