//! Second derivatives of rollouts: against differences of exact gradients, and the symmetry of Hessians.

use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, Rigid, SoftContact, Terrain};
use dualbody::linearize::{RolloutCost, RolloutDirection};
use dualbody::model::samples;
use dualbody::sim::{Actuation, RolloutStatus};
use dualbody::{Integrator, Scalar, Simulator, State};
use nalgebra::{DMatrix, DVector};
use rand::RngExt;

use crate::common::everything::INTEGRATORS;
use crate::common::{asset, generator, random_point};

/// A cost of all entries of a trajectory that is not quadratic.
struct Everything;

impl RolloutCost for Everything {
    fn stage<T: Scalar>(&self, step: usize, state: &State<T>, u: &[T]) -> T {
        let weight = 1.0 + (step as f64).sin();
        let numbers = state.v.iter().chain(u);
        numbers.fold(T::zero(), |sum, &x| sum + x.sin_cos().1 * weight)
    }

    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        let numbers = last.numbers().enumerate();
        numbers.fold(T::zero(), |sum, (k, &x)| {
            sum + x.sin_cos().0 * (1.0 + k as f64)
        })
    }
}

/// A rollout, and a direction.
struct Case {
    name: String,
    simulator: Simulator,
    start: State,
    inputs: Vec<DVector<f64>>,
    along: RolloutDirection,
}

impl Case {
    fn new(simulator: Simulator, start: State, what: &str) -> Self {
        const STEPS: usize = 6;
        let mut rng = generator(11);
        let mut numbers = |n: usize| DVector::from_fn(n, |_, _| rng.random_range(-1.0..1.0));
        let nu = simulator.nu();
        let inputs: Vec<_> = (0..STEPS).map(|_| numbers(nu)).collect();
        let along = RolloutDirection {
            start: numbers(simulator.n_tangent()),
            inputs: (0..STEPS).map(|_| numbers(nu)).collect(),
        };
        Self {
            name: format!("{what}, {:?}", simulator.integrator()),
            simulator,
            start,
            inputs,
            along,
        }
    }

    fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for integrator in INTEGRATORS {
            for model in [samples::arm(), samples::random_tree(6, 4)] {
                let point = random_point(&model, 3);
                let what = model.name().to_owned();
                let actuation = Actuation::from_model(&model);
                let simulator = Simulator::new(model)
                    .with_actuation(actuation)
                    .with_integrator(integrator)
                    .with_time_step(0.01);
                let start = simulator.state(point.q.as_slice(), point.v.as_slice());
                all.push(Self::new(simulator, start, &what));
            }
        }
        let laws = [
            ("sphere.urdf", ContactLaw::Rigid(Rigid::default())),
            (
                "box.urdf",
                ContactLaw::RelaxedRigid(RelaxedRigid::default()),
            ),
            (
                "box.urdf",
                ContactLaw::Soft(SoftContact::estimate(10.0, 4, 1e-3)),
            ),
        ];
        all.extend(laws.map(|(robot, law)| Self::sliding(robot, law)));
        all
    }

    /// A body that slides on all its points, deep enough to stay there. A box on four rigid corners is at a nonsmooth point: any tilt lifts one.
    fn sliding(robot: &str, law: ContactLaw) -> Self {
        let model = asset(robot);
        let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
        let simulator = Simulator::new(model)
            .with_contacts(contacts)
            .with_integrator(Integrator::SemiImplicitEuler)
            .with_time_step(1e-3);
        let mut start = simulator.neutral_state();
        let contacts = simulator.contacts().expect("contacts");
        let states = contacts.states(simulator.model(), start.q.as_slice(), start.v.as_slice());
        let deepest = states.iter().map(|s| s.depth).fold(f64::MIN, f64::max);
        start.q[2] += deepest - 2e-3;
        (start.v[0], start.v[1]) = (0.8, -0.3);
        Self::new(simulator, start, &format!("{law:?}"))
    }

    fn product(&self, along: &RolloutDirection) -> RolloutDirection {
        let (start, inputs) = (&self.start, &self.inputs);
        let found = (self.simulator).rollout_hessian_product(start, inputs, &Everything, along);
        assert_eq!(found.status, RolloutStatus::Completed, "{}", self.name);
        found.product
    }

    /// The direction of one number.
    fn unit(&self, k: usize) -> RolloutDirection {
        let mut out = RolloutDirection::zeros(&self.simulator, self.inputs.len());
        let numbers = out.start.iter_mut();
        let mut numbers = numbers.chain(out.inputs.iter_mut().flatten());
        *numbers.nth(k).expect("a number") = 1.0;
        out
    }

    /// ∇J · d at x ⊕ h d, in the tangent space at x: that there, taken back by the derivative of ⊕.
    fn slope(&self, h: f64) -> f64 {
        let model = self.simulator.model();
        let moved = |h: f64| {
            let (dq, rest) = self.along.start.as_slice().split_at(model.nv());
            let dq: Vec<f64> = dq.iter().map(|x| h * x).collect();
            let q = model.integrate(self.start.q.as_slice(), &dq);
            let mut start = self.start.clone();
            start.q = q;
            let numbers = start.v.iter_mut().chain(start.contact.iter_mut());
            numbers.zip(rest).for_each(|(x, dx)| *x += h * dx);
            let inputs = self.inputs.iter().zip(&self.along.inputs);
            let inputs: Vec<_> = inputs.map(|(u, du)| u + du * h).collect();
            (start, inputs)
        };
        let (start, inputs) = moved(h);
        let gradient = self
            .simulator
            .rollout_gradient(&start, &inputs, &Everything);
        // d/dh of q ⊕ h δq seen there is δq itself, since that turns about its own axis.
        let of_inputs = gradient.inputs.iter().zip(&self.along.inputs);
        gradient.start.dot(&self.along.start) + of_inputs.map(|(g, du)| g.dot(du)).sum::<f64>()
    }
}

// Differences are compared at their best step: contact is stiff.
#[test]
fn curvature_along_a_direction_equals_differences_of_exact_gradients() {
    for case in Case::all() {
        let product = case.product(&case.along);
        let of_inputs = product.inputs.iter().zip(&case.along.inputs);
        let found =
            product.start.dot(&case.along.start) + of_inputs.map(|(x, du)| x.dot(du)).sum::<f64>();
        let errors = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8].map(|h| {
            let expected = (case.slope(h) - case.slope(-h)) / (2.0 * h);
            (found - expected).abs() / (1.0 + expected.abs())
        });
        let error = errors.into_iter().fold(f64::INFINITY, f64::min);
        assert!(error < 1e-6, "{}: {found}: {errors:?}", case.name);
        assert!(found.abs() > 1e-3, "{}: {found}", case.name);
    }
}

#[test]
fn hessian_is_symmetric_and_has_the_products_with_directions() {
    for case in [
        Case::all().swap_remove(1),
        Case::sliding(
            "box.urdf",
            ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        ),
    ] {
        let stacked = |x: &RolloutDirection| {
            let all = x.start.iter().chain(x.inputs.iter().flatten());
            DVector::<f64>::from_vec(all.copied().collect())
        };
        let n = stacked(&case.along).len();
        let columns: Vec<_> = (0..n)
            .map(|k| stacked(&case.product(&case.unit(k))))
            .collect();
        let h = DMatrix::from_columns(&columns);
        let asymmetry = (&h - h.transpose()).amax() / h.amax();
        assert!(asymmetry < 1e-11, "{}: {asymmetry:e}", case.name);
        let expected = &h * stacked(&case.along);
        let error = (stacked(&case.product(&case.along)) - &expected).amax() / expected.amax();
        assert!(error < 1e-12, "{}: {error:e}", case.name);
    }
}

#[test]
fn hessian_of_a_rollout_that_ends_early_is_zero_and_says_so() {
    let mut case = Case::all().swap_remove(0);
    case.inputs[2][0] = f64::NAN;
    let found =
        case.simulator
            .rollout_hessian_product(&case.start, &case.inputs, &Everything, &case.along);
    assert_eq!(found.status, RolloutStatus::NonFiniteInput { step: 2 });
    assert_eq!(
        found.product,
        RolloutDirection::zeros(&case.simulator, case.inputs.len())
    );
}
