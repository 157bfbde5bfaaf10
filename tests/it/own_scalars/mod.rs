//! Scalars that a user writes, over every algorithm: intervals, single precision, and numbers that record the operations
//! with them.
//!
//! None of them has derivatives, and none is `f64`: code that uses only their values loses the width, wins
//! digits that are not there, or records constants.

mod interval;
mod single;
mod tracer;

use dualbody::autodiff::Dual;
use dualbody::constraint::{Anchor, Constraint};
use dualbody::contact::{ContactLaw, RelaxedRigid, Rigid, SoftContact, Terrain};
use dualbody::dynamics::inverse_dynamics_derivatives;
use dualbody::model::samples;
use dualbody::sim::Actuation;
use dualbody::{Cast, Integrator, Model, Scalar, Simulator, State};
use nalgebra::DVector;

use crate::common::everything::{INTEGRATORS, everything};
use crate::common::ground::{free, hills, on, waves};
use crate::common::{OTHER_ALGORITHM, Point, SAME_ALGEBRA, asset, random_point, robots};
use interval::Interval;
use single::Single;
use tracer::{record, replay};

/// Operators between two numbers of a type, and with `f64` on the right, from functions of two of them; zero and one.
macro_rules! operators {
    ($number:ident; $($operator:ident $method:ident $assign:ident $assign_method:ident $function:expr;)*) => {
        $(
            impl $operator for $number {
                type Output = Self;
                fn $method(self, other: Self) -> Self {
                    ($function)(self, other)
                }
            }
            impl $operator<f64> for $number {
                type Output = Self;
                fn $method(self, other: f64) -> Self {
                    $operator::$method(self, Self::from(other))
                }
            }
            impl $assign for $number {
                fn $assign_method(&mut self, other: Self) {
                    *self = $operator::$method(*self, other);
                }
            }
        )*
        impl Zero for $number {
            fn zero() -> Self {
                Self::from(0.0)
            }
            fn is_zero(&self) -> bool {
                self.value(0) == 0.0
            }
        }
        impl One for $number {
            fn one() -> Self {
                Self::from(1.0)
            }
        }
    };
}
use operators;

/// Robots of every sort, and two that branch so much that plain numbers go side by side.
fn all_robots() -> Vec<Model> {
    let mut out = robots();
    out.push(asset("quadruped.urdf"));
    out.push(asset("humanoid.urdf"));
    out
}

/// Every function of the dynamics at a point, and the names of the numbers.
fn at_point<T: Scalar>(
    model: &Model,
    point: &Point,
    mut f: impl FnMut(f64) -> T,
) -> (Vec<&'static str>, Vec<T>) {
    let mut lift = |x: &[f64]| x.iter().map(|&x| f(x)).collect::<Vec<T>>();
    let (q, v, w) = (
        lift(point.q.as_slice()),
        lift(point.v.as_slice()),
        lift(point.w.as_slice()),
    );
    let results = everything(model, &q, &v, &w);
    (results.names, results.numbers)
}

/// A simulator at a state, with its input.
struct Case {
    name: String,
    simulator: Simulator,
    state: State,
    u: Vec<f64>,
}

impl Case {
    fn new(name: impl Into<String>, simulator: Simulator, state: State) -> Self {
        let u = (0..simulator.nu()).map(|i| 0.3 - 0.1 * i as f64).collect();
        Self {
            name: name.into(),
            simulator,
            state,
            u,
        }
    }

    /// The state after a step, from numbers around q, v, the state of contact and u.
    fn step<T: Scalar>(&self, x: &[T]) -> Vec<T> {
        let (nq, nv) = (self.state.q.len(), self.state.v.len());
        let (q, rest) = x.split_at(nq);
        let (v, rest) = rest.split_at(nv);
        let (m, u) = rest.split_at(self.state.contact.len());
        let mut state: State<T> = self.state.cast();
        state.q.copy_from_slice(q);
        state.v.copy_from_slice(v);
        state.contact.copy_from_slice(m);
        let next = self.simulator.step(&state, u);
        next.q
            .iter()
            .chain(&next.v)
            .chain(&next.contact)
            .copied()
            .collect()
    }

    fn inputs(&self) -> Vec<f64> {
        let s = &self.state;
        let state = s.q.iter().chain(&s.v).chain(&s.contact);
        state.chain(&self.u).copied().collect()
    }
}

/// A sliding box under each law, on each ground, by each integrator that they work with; a linkage; actuators at a
/// stop.
fn cases() -> Vec<Case> {
    let soft = ContactLaw::Soft(SoftContact::estimate(1.0, 4, 1e-3));
    let (rigid, relaxed) = (Rigid::default(), RelaxedRigid::default());
    let laws = [
        ("soft", soft),
        ("rigid", ContactLaw::Rigid(rigid)),
        ("relaxed", ContactLaw::RelaxedRigid(relaxed)),
    ];
    let grounds = [
        ("flat", Terrain::flat(0.0)),
        ("grid", hills()),
        ("function", waves()),
    ];
    let mut out = Vec::new();
    for (law_name, law) in laws {
        for (ground, terrain) in &grounds {
            for integrator in INTEGRATORS {
                if law_name != "soft" && integrator == Integrator::RungeKutta4 {
                    continue;
                }
                let simulator =
                    on(asset("sphere.urdf"), terrain.clone(), law).with_integrator(integrator);
                let height = terrain.surface(&0.1, &0.2).height;
                let v = [1.0, 0.4, -0.3, 0.2, 0.1, 0.5];
                let mut state = free(&simulator, [0.1, 0.2, height + 0.0997], 0.3, v);
                state.contact.fill(2e-5);
                let name = format!("{law_name}, {ground}, {integrator:?}");
                out.push(Case::new(name, simulator, state));
            }
        }
    }
    out.extend(INTEGRATORS.map(linkage));
    out.extend(INTEGRATORS.map(actuated));
    out
}

/// An arm whose tip is held at a distance from the world.
fn linkage(integrator: Integrator) -> Case {
    let model = samples::arm();
    let q: Vec<f64> = (0..model.nq()).map(|i| 0.3 + 0.1 * i as f64).collect();
    let names = model.frame_names();
    let tip = Anchor::frame(&model, names[names.len() - 1]).expect("a frame of the arm");
    let simulator = Simulator::new(model)
        .with_integrator(integrator)
        .with_constraints(vec![Constraint::distance([tip, Anchor::world()], 0.9)]);
    let state = simulator.state(&q, &[0.2; 7]);
    Case::new(format!("linkage, {integrator:?}"), simulator, state)
}

/// A Panda with its actuators.
fn actuated(integrator: Integrator) -> Case {
    let model = asset("panda.urdf");
    let actuation = Actuation::from_model(&model);
    let point = random_point(&model, 3);
    let simulator = Simulator::new(model)
        .with_integrator(integrator)
        .with_time_step(1e-4)
        .with_actuation(actuation);
    let state = simulator.state(point.q.as_slice(), point.v.as_slice());
    Case::new(format!("actuated, {integrator:?}"), simulator, state)
}

/// Half the width of intervals that go in.
const RADIUS: f64 = 1e-14;
/// The largest width that comes out, relative to the number or to one: intervals that depend on the same input do not
/// cancel, which costs accelerations of a tree of nine bodies nine digits.
const WIDEST: f64 = 2e-1;

/// A number next to another one, within the interval around that.
fn beside(i: usize, x: f64) -> f64 {
    x + if i.is_multiple_of(2) { 0.9 } else { -0.9 } * RADIUS
}

/// Reason why an interval does not contain a number, or is uninformative: wider than `widest`, relative to the number or
/// to one.
fn refusal(interval: Interval, x: f64, (slack, widest): (f64, f64), what: &str) -> Option<String> {
    let wide = interval.width() > widest * x.abs().max(1.0);
    let [below, above] = [interval.low - x, x - interval.high];
    let outside = below.max(above) > slack * interval.width();
    (wide || outside).then(|| format!("{what}: {x} in {interval:?}"))
}

#[track_caller]
fn assert_none(refusals: &[String]) {
    let first: Vec<_> = refusals.iter().take(10).collect();
    assert!(refusals.is_empty(), "{}, {first:#?}", refusals.len());
}

/// Robots of few bodies, whose steps are narrow too: the widest, of the arm by Runge and Kutta, is 8.4e-9.
const SMALL: [&str; 6] = [
    "pendulum",
    "double_pendulum",
    "cartpole",
    "arm",
    "free_body",
    "floating_robot",
];
/// The largest width of their steps.
const WIDEST_STEP: f64 = 1e-7;

// All of these contain the exact results: only the step decides on values, and that only whether something turns so
// fast that velocity forces are to be those of the middle of the step, far from the change between the two. Steps of
// larger robots may be as wide as they like: they solve with one factorised matrix after another, each of which costs
// trees of nine bodies nine digits.
#[test]
fn interval_dynamics_hold_those_of_numbers_inside() {
    let mut refusals = Vec::new();
    for model in all_robots() {
        let point = random_point(&model, 1);
        let (names, intervals) = at_point(&model, &point, |x| Interval::around(x, RADIUS));
        let (_, middle) = at_point(&model, &point, |x| x);
        let mut i = 0;
        let (_, side) = at_point(&model, &point, |x| {
            i += 1;
            beside(i, x)
        });
        for (k, name) in names.into_iter().enumerate() {
            let what = format!("{}, {name}, {k}", model.name());
            let widest = match name {
                "step" if SMALL.contains(&model.name()) => WIDEST_STEP,
                "step" => f64::INFINITY,
                _ => WIDEST,
            };
            for x in [middle[k], side[k]] {
                refusals.extend(refusal(intervals[k], x, (0.0, widest), &what));
            }
        }
    }
    assert_none(&refusals);
}

// A solver that decides on values continues along the tangent there, so that the last digits of a width may be missing.
#[test]
fn interval_steps_hold_those_of_numbers_inside() {
    /// Of the width.
    const SLACK: f64 = 1e-3;
    let mut refusals = Vec::new();
    for case in cases() {
        let x = case.inputs();
        let around: Vec<Interval> = x.iter().map(|&x| Interval::around(x, RADIUS)).collect();
        let side: Vec<f64> = x.iter().enumerate().map(|(i, &x)| beside(i, x)).collect();
        let (intervals, middle, side) = (case.step(&around), case.step(&x), case.step(&side));
        for k in 0..middle.len() {
            let what = format!("{}, {k}", case.name);
            for x in [middle[k], side[k]] {
                refusals.extend(refusal(intervals[k], x, (SLACK, WIDEST), &what));
            }
        }
    }
    assert_none(&refusals);
}

/// Roundings of single precision through a whole robot, relative to the largest entry of a result.
const SINGLE: f64 = 2e-4;

/// Compares results in single precision; returns whether they differ from rounded results in double precision.
#[track_caller]
fn assert_near(actual: &[Single], expected: &[f64], what: &str) -> bool {
    let largest = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
    for (a, e) in actual.iter().zip(expected) {
        let off = (a.value(0) - e).abs();
        assert!(off <= SINGLE * largest, "{what}: {a:?}, not {e}");
    }
    let mut both = actual.iter().zip(expected);
    both.any(|(a, &e)| (a.value(0) - e).abs() > e.abs() * f64::from(f32::EPSILON))
}

#[test]
fn dynamics_in_single_precision_are_near_those_in_double_and_have_its_errors() {
    for model in all_robots() {
        let point = random_point(&model, 2);
        let (names, single) = at_point(&model, &point, Single::from);
        let (_, double) = at_point(&model, &point, |x| Single::from(x).value(0));
        let mut first = 0;
        for block in names.chunk_by(|a, b| a == b) {
            let (range, name) = (first..first + block.len(), block[0]);
            first = range.end;
            let what = format!("{}, {name}", model.name());
            let rounded = assert_near(&single[range.clone()], &double[range], &what);
            let large = model.n_bodies() > 7 && ["forward_dynamics", "step"].contains(&name);
            assert!(rounded || !large, "{what} is not in single precision");
        }
    }
}

#[test]
fn steps_in_single_precision_are_near_those_in_double() {
    for case in cases() {
        let single: Vec<Single> = case.inputs().into_iter().map(Single::from).collect();
        let double: Vec<f64> = single.iter().map(|x| x.value(0)).collect();
        assert_near(&case.step(&single), &case.step(&double), &case.name);
    }
}

#[test]
fn recorded_dynamics_give_the_dynamics_at_any_other_point() {
    for model in all_robots() {
        let (here, there) = (random_point(&model, 4), random_point(&model, 5));
        let all = |p: &Point| -> Vec<f64> { p.q.iter().chain(&p.v).chain(&p.w).copied().collect() };
        let mut inputs = record(&all(&here)).into_iter();
        let (names, outputs) = at_point(&model, &here, |_| inputs.next().expect("an input"));
        let (_, expected) = at_point(&model, &there, |x| x);
        let replayed = replay(&all(&there), &outputs);
        for ((name, a), e) in names.iter().zip(replayed).zip(expected) {
            let off = (a - e).abs();
            let small = off <= 10.0 * SAME_ALGEBRA * e.abs().max(1.0);
            assert!(small, "{}, {name}: {a}, not {e}", model.name());
        }
    }
}

// A solver's forces are recorded with the pieces of the laws that hold here, and with the slopes there.
#[test]
fn recorded_steps_have_the_value_and_the_slope_of_the_step() {
    /// Change of each input.
    const SMALL: f64 = 1e-8;
    let mut refusals = Vec::new();
    for case in cases() {
        let x = case.inputs();
        let along: Vec<f64> = (0..x.len()).map(|i| (1.0 + i as f64).sin()).collect();
        let outputs = case.step(&record(&x));
        let moved = |h: f64| -> Vec<f64> {
            let x = x.iter().zip(&along).map(|(x, d)| x + h * d);
            replay(&x.collect::<Vec<_>>(), &outputs)
        };
        let (here, plus, minus) = (moved(0.0), moved(SMALL), moved(-SMALL));
        let dual = x.iter().zip(&along).map(|(&x, &d)| Dual::new(x, [d]));
        let exact = case.step(&dual.collect::<Vec<Dual<f64, 1>>>());
        let steepest = exact
            .iter()
            .fold(1.0_f64, |most, x| most.max(x.eps[0].abs()));
        for (k, value) in case.step(&x).into_iter().enumerate() {
            let off = (here[k] - value).abs();
            assert!(
                off <= OTHER_ALGORITHM * value.abs().max(1.0),
                "{}: {off}",
                case.name
            );
            let slope = (plus[k] - minus[k]) / (2.0 * SMALL);
            let exact = exact[k].eps[0];
            if (slope - exact).abs() > 1e-6 * steepest {
                refusals.push(format!("{}, {k}: {slope}, not {exact}", case.name));
            }
        }
    }
    assert_none(&refusals);
}

#[test]
fn derivatives_along_the_tree_in_single_precision_equal_those_in_double() {
    for model in robots() {
        let Point { q, v, w } = random_point(&model, 8);
        let single = |x: &DVector<f64>| x.map(Single::from);
        let (q1, v1, w1) = (single(&q), single(&v), single(&w));
        let own = inverse_dynamics_derivatives(&model, q1.as_slice(), v1.as_slice(), w1.as_slice());
        let exact = inverse_dynamics_derivatives(&model, q.as_slice(), v.as_slice(), w.as_slice());
        for (own, exact) in [(own.dq, exact.dq), (own.dv, exact.dv), (own.da, exact.da)] {
            let off = (own.map(|x| f64::from(x.0)) - &exact).amax() / exact.amax().max(1.0);
            assert!(off < 1e-4, "{}: {off:e}", model.name());
        }
    }
}
