//! Vector-Jacobian products of the dynamics against the transposed Jacobians, which other code finds.

use dualbody::autodiff::{VectorFunction, gradient};
use dualbody::dynamics::{
    AbaScratch, ForwardDynamicsDerivatives, ForwardDynamicsDerivativesScratch,
    ForwardDynamicsGradient, ForwardDynamicsVjpScratch, InverseDynamicsDerivatives,
    InverseDynamicsDerivativesScratch, InverseDynamicsGradient, InverseDynamicsVjpScratch,
    RneaScratch, forward_dynamics_derivatives_into, forward_dynamics_into,
    forward_dynamics_vjp_into, inverse_dynamics_derivatives_into, inverse_dynamics_into,
    inverse_dynamics_vjp, inverse_dynamics_vjp_into,
};
use dualbody::joint::{JointKind, Pitch};
use dualbody::model::{JointSpec, LinkSpec, ModelBuilder, SecondAxis};
use dualbody::spatial::{Force, SPATIAL};
use dualbody::{Model, Scalar};
use nalgebra::DVector;
use rand::RngExt;

use crate::common::{
    OTHER_ALGORITHM, SAME_ALGEBRA, assert_close_vector, generator, random_point, random_tangent,
    robots,
};

/// An arm with a screw and a universal joint, between hinges.
fn threaded_arm() -> Model {
    let mut builder = ModelBuilder::new("threaded_arm");
    builder.add_link(LinkSpec::new("world"));
    let hinge = |name: &str, kind, parent: &str, child: &str| {
        JointSpec::new(name, kind, parent, child)
            .with_translation([0.1, -0.2, 0.3])
            .with_axis([0.6, 0.0, 0.8])
            .with_armature(0.03)
    };
    let screw = JointKind::Screw(Pitch::per_radian(0.1));
    for (k, link) in ["a", "b", "c", "d"].into_iter().enumerate() {
        let com = [0.1, -0.05 * k as f64, 0.2];
        builder.add_link(LinkSpec::new(link).with_mass(1.0 + k as f64, com, [0.2, 0.15, 0.1]));
    }
    builder.add_joint(hinge("first", JointKind::Revolute, "world", "a"));
    builder.add_joint(hinge("thread", screw, "a", "b"));
    let cross = hinge("cross", JointKind::Universal, "b", "c");
    builder.add_joint(cross.with_second_axis(SecondAxis::about([0.0, 1.0, 0.0])));
    builder.add_joint(hinge("last", JointKind::Continuous, "c", "d"));
    builder.build().expect("a robot that is known to be right")
}

/// A robot at a motion under external forces, with weights.
struct Case {
    model: Model,
    q: DVector<f64>,
    v: DVector<f64>,
    w: DVector<f64>,
    weights: DVector<f64>,
    external: Vec<Force<f64>>,
}

impl Case {
    fn new(model: Model, seed: u64) -> Self {
        let (point, mut rng) = (random_point(&model, seed), generator(seed + 100));
        let mut number = || rng.random_range(-1.0..1.0);
        let force = |_| Force::from_array(std::array::from_fn::<_, SPATIAL, _>(|_| number()));
        let external = (0..model.n_bodies()).map(force).collect();
        Self {
            weights: random_tangent(&model, &mut generator(seed + 200)),
            q: point.q,
            v: point.v,
            w: point.w,
            external,
            model,
        }
    }

    fn all() -> Vec<Self> {
        let robots = robots().into_iter().chain([threaded_arm()]);
        let mut seeds = 0..;
        robots
            .map(|model| Self::new(model, seeds.next().unwrap_or(0)))
            .collect()
    }

    fn state(&self) -> (&[f64], &[f64], &[f64]) {
        (self.q.as_slice(), self.v.as_slice(), self.w.as_slice())
    }
}

/// A weighted sum of joint forces or accelerations as a function of all parameters and of the external forces.
struct Sum<'a> {
    case: &'a Case,
    forward: bool,
}

impl VectorFunction for Sum<'_> {
    fn n_outputs(&self) -> usize {
        1
    }

    fn eval<T: Scalar>(&self, x: &[T], y: &mut [T]) {
        let Case {
            q,
            v,
            w,
            weights,
            model,
            ..
        } = self.case;
        let (parameters, forces) = x.split_at(model.parameters().len());
        let model = model.with_parameters(parameters);
        let forces = forces.as_chunks::<SPATIAL>().0;
        let external: Vec<_> = forces.iter().map(|&F| Force::from_array(F)).collect();
        let [q, v, w] = [q, v, w].map(|x| x.map(T::constant));
        let (q, v, w) = (q.as_slice(), v.as_slice(), w.as_slice());
        let mut out = vec![T::zero(); model.nv()];
        if self.forward {
            let mut scratch = AbaScratch::new(&model);
            forward_dynamics_into(&model, q, v, w, &external, &mut scratch, &mut out);
        } else {
            let mut scratch = RneaScratch::new(&model);
            inverse_dynamics_into(&model, q, v, w, &external, &mut scratch, &mut out);
        }
        let products = out.iter().zip(weights);
        y[0] = products.fold(T::zero(), |sum, (&x, &weight)| sum + x * weight);
    }
}

/// The gradient in parameters and external forces by dual numbers.
fn by_duals(case: &Case, forward: bool) -> (DVector<f64>, DVector<f64>) {
    let parameters = case.model.parameters();
    let forces = case.external.iter().flat_map(Force::to_array);
    let x: Vec<f64> = parameters.iter().copied().chain(forces).collect();
    let all = gradient(&Sum { case, forward }, &x);
    let n = parameters.len();
    let rest = all.rows(n, all.len() - n).into_owned();
    (all.rows(0, n).into_owned(), rest)
}

#[test]
fn inverse_dynamics_vjp_equals_the_transposed_jacobian_of_every_robot() {
    for case in Case::all() {
        let (model, (q, v, a)) = (&case.model, case.state());
        let mut out = InverseDynamicsGradient::zeros(model);
        let mut scratch = InverseDynamicsVjpScratch::new(model);
        let (external, mu) = (&case.external, case.weights.as_slice());
        // Twice, so that an effect of the first call would show.
        for _ in 0..2 {
            inverse_dynamics_vjp_into(model, q, v, a, external, mu, &mut scratch, &mut out);
        }
        let mut jacobians = InverseDynamicsDerivatives::zeros(model);
        let mut scratch = InverseDynamicsDerivativesScratch::new(model);
        inverse_dynamics_derivatives_into(model, q, v, a, external, &mut scratch, &mut jacobians);
        let (parameters, forces) = by_duals(&case, false);
        let actual = out.external.iter().flat_map(|V| V.to_array());
        let actual = DVector::from_iterator(SPATIAL * model.n_bodies(), actual);
        for (name, actual, expected) in [
            ("q", &out.q, jacobians.dq.tr_mul(&case.weights)),
            ("v", &out.v, jacobians.dv.tr_mul(&case.weights)),
            ("a", &out.a, jacobians.da.tr_mul(&case.weights)),
            ("parameters", &out.parameters, parameters),
            ("external forces", &actual, forces),
        ] {
            let what = format!("{}, in {name}", model.name());
            assert_close_vector(actual, &expected, SAME_ALGEBRA, &what);
        }
    }
}

#[test]
fn forward_dynamics_vjp_equals_the_transposed_jacobian_of_every_robot() {
    for case in Case::all() {
        let (model, (q, v, tau)) = (&case.model, case.state());
        let mut out = ForwardDynamicsGradient::zeros(model);
        let mut scratch = ForwardDynamicsVjpScratch::new(model);
        let (external, lambda) = (&case.external, case.weights.as_slice());
        for _ in 0..2 {
            forward_dynamics_vjp_into(model, q, v, tau, external, lambda, &mut scratch, &mut out);
        }
        let mut jacobians = ForwardDynamicsDerivatives::zeros(model);
        let mut scratch = ForwardDynamicsDerivativesScratch::new(model);
        forward_dynamics_derivatives_into(model, q, v, tau, external, &mut scratch, &mut jacobians);
        let (parameters, forces) = by_duals(&case, true);
        let actual = out.external.iter().flat_map(|V| V.to_array());
        let actual = DVector::from_iterator(SPATIAL * model.n_bodies(), actual);
        for (name, actual, expected) in [
            ("q", &out.q, jacobians.dq.tr_mul(&case.weights)),
            ("v", &out.v, jacobians.dv.tr_mul(&case.weights)),
            ("τ", &out.tau, jacobians.dtau.tr_mul(&case.weights)),
            ("parameters", &out.parameters, parameters),
            ("external forces", &actual, forces),
        ] {
            let what = format!("{}, in {name}", model.name());
            assert_close_vector(actual, &expected, OTHER_ALGORITHM, &what);
        }
    }
}

#[test]
fn gradients_without_parameters_are_the_same_in_the_rest() {
    let case = Case::new(threaded_arm(), 3);
    let (model, (q, v, a)) = (&case.model, case.state());
    let mu = case.weights.as_slice();
    let with = inverse_dynamics_vjp(model, q, v, a, mu);
    let mut without = InverseDynamicsGradient::zeros(model);
    without.parameters = DVector::zeros(0);
    let mut scratch = InverseDynamicsVjpScratch::new(model);
    inverse_dynamics_vjp_into(model, q, v, a, &[], mu, &mut scratch, &mut without);
    assert_eq!((with.q, with.v, with.a), (without.q, without.v, without.a));
    assert!(without.parameters.is_empty());
}

#[test]
#[should_panic(expected = "the scratch belongs to another model than")]
fn scratch_of_another_robot_is_refused() {
    let (one, other) = (Case::new(threaded_arm(), 3), threaded_arm());
    let (q, v, a) = one.state();
    let mut out = InverseDynamicsGradient::zeros(&one.model);
    let mut scratch = InverseDynamicsVjpScratch::new(&other);
    inverse_dynamics_vjp_into(&one.model, q, v, a, &[], v, &mut scratch, &mut out);
}
