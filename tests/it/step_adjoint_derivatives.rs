//! The adjoint of a step on dual numbers: its derivative along a direction against differences of the adjoint on plain numbers, for every term,
//! integrator and law of contact.

use dualbody::autodiff::Dual;
use dualbody::linearize::{
    RolloutCost, RolloutDirection, RolloutGradientOptions, WantedParameters,
};
use dualbody::sim::RolloutStatus;
use dualbody::{Integrator, Scalar, State};
use nalgebra::DVector;
use rand::RngExt;

use crate::common::generator;
use crate::step_adjoints::{Case, closed_loops, solved_contact, uneven_ground};

/// A cost of all entries of the last state that is not quadratic, each relative to its size.
struct AtTheEnd {
    sizes: Vec<f64>,
}

impl RolloutCost for AtTheEnd {
    fn end<T: Scalar>(&self, last: &State<T>) -> T {
        let numbers = last.numbers().zip(&self.sizes).enumerate();
        numbers.fold(T::zero(), |sum, (k, (&x, &size))| {
            sum + (x / size).sin_cos().0 * (1.0 + (k as f64).sin())
        })
    }
}

/// A rollout of two steps, and a direction.
struct Directed {
    case: Case,
    inputs: Vec<DVector<f64>>,
    along: RolloutDirection,
    cost: AtTheEnd,
}

impl Directed {
    fn new(case: Case) -> Self {
        let mut rng = generator(3);
        let simulator = &case.simulator;
        let next = simulator.step(&case.state, case.u.as_slice());
        let last = simulator.step(&next, case.u.as_slice());
        let mut numbers = |n: usize| DVector::from_fn(n, |_, _| rng.random_range(-1.0..1.0));
        let mut start = numbers(simulator.n_tangent());
        // Bristles are stretched by micrometres, and contact has its pieces nearby.
        let contact = 2 * simulator.model().nv();
        start.rows_range_mut(contact..).scale_mut(1e-3);
        Self {
            along: RolloutDirection {
                start,
                inputs: vec![numbers(simulator.nu()), numbers(simulator.nu())],
            },
            inputs: vec![case.u.clone(); 2],
            cost: AtTheEnd {
                sizes: last.numbers().map(|x| 1.0 + x.abs()).collect(),
            },
            case,
        }
    }

    /// The product with the direction, one number after the other.
    fn product(&self) -> DVector<f64> {
        let (simulator, start) = (&self.case.simulator, &self.case.state);
        let found = simulator.rollout_hessian_product(start, &self.inputs, &self.cost, &self.along);
        assert_eq!(found.status, RolloutStatus::Completed, "{}", self.case.name);
        stacked(&found.product.start, &found.product.inputs)
    }

    /// The gradient at x ⊕ h d, along the tangent at x.
    fn gradient(&self, h: f64) -> DVector<f64> {
        let (simulator, state) = (&self.case.simulator, &self.case.state);
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let change = &self.along.start * h;
        let mut start = state.clone();
        start.q = model.integrate(state.q.as_slice(), &change.as_slice()[..nv]);
        let numbers = start.v.iter_mut().chain(start.contact.iter_mut());
        let pairs = numbers.zip(&change.as_slice()[nv..]);
        pairs.for_each(|(x, dx)| *x += dx);
        let inputs = self.inputs.iter().zip(&self.along.inputs);
        let inputs: Vec<_> = inputs.map(|(u, du)| u + du * h).collect();
        let options = RolloutGradientOptions {
            parameters: WantedParameters::None,
            ..Default::default()
        };
        let mut found = simulator
            .rollout_gradients(&[start.clone()], &[inputs], &self.cost, &options)
            .swap_remove(0);
        let there = found.start.rows(0, nv).into_owned();
        let lift = |x: &DVector<f64>| x.map(Dual::<f64, 1>::from);
        for k in 0..nv {
            // How x ⊕ (h d + ε e) moves, seen at x ⊕ h d.
            let mut tangent = lift(&change.rows(0, nv).into_owned());
            tangent[k].eps[0] = 1.0;
            let moved = model.integrate(lift(&state.q).as_slice(), tangent.as_slice());
            let seen = model.difference(lift(&start.q).as_slice(), moved.as_slice());
            found.start[k] = seen.map(|x| x.eps[0]).dot(&there);
        }
        stacked(&found.start, &found.inputs)
    }

    /// Largest difference between the product and differences of gradients, beside the largest number, at the best of several sizes.
    fn error(&self) -> f64 {
        let found = self.product();
        let errors = [1e-4, 1e-5, 1e-6, 1e-7].map(|h| {
            let expected = (self.gradient(h) - self.gradient(-h)) / (2.0 * h);
            (&found - &expected).amax() / expected.amax().max(1e-3)
        });
        errors.into_iter().fold(f64::INFINITY, f64::min)
    }
}

fn stacked(start: &DVector<f64>, inputs: &[DVector<f64>]) -> DVector<f64> {
    let all = start.iter().chain(inputs.iter().flatten());
    DVector::from_vec(all.copied().collect())
}

fn check(cases: impl IntoIterator<Item = Case>) {
    let mut wrong = Vec::new();
    for case in cases
        .into_iter()
        .filter(|case| case.simulator.model().nv() > 0)
    {
        let directed = Directed::new(case);
        let error = directed.error();
        if error.is_nan() || error > 1e-5 {
            wrong.push(format!("{}: {error:e}", directed.case.name));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

// Explicit steps of stiff robots diverge unless they are short.
#[test]
fn derivative_of_the_adjoint_equals_differences_of_every_robot_and_term() {
    check(Case::all().into_iter().map(|mut case| {
        if case.simulator.integrator() == Integrator::RungeKutta4 {
            case.simulator = case.simulator.with_time_step(1e-4);
        }
        case
    }));
}

#[test]
fn derivative_of_the_adjoint_through_solved_contact_equals_differences() {
    check(solved_contact());
}

#[test]
fn derivative_of_the_adjoint_over_uneven_ground_equals_differences() {
    // A function of the ground counts as the plane that touches it: second derivatives of it are not found.
    let is_function = |case: &Case| {
        let contacts = case.simulator.contacts().expect("contacts");
        matches!(contacts.terrain(), dualbody::contact::Terrain::Function(_))
    };
    check(
        uneven_ground()
            .into_iter()
            .filter(|case| !is_function(case)),
    );
}

#[test]
fn derivative_of_the_adjoint_of_closed_loops_equals_differences() {
    check(closed_loops());
}
