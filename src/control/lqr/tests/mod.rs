//! Tests of both regulators.

mod outcomes;
mod solutions;

use super::*;
use crate::control::doubling::symmetrized;
use approx::assert_relative_eq;
use nalgebra::{dmatrix, dvector};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};

/// Relative difference from a solution by another formula: the digits that a well-conditioned problem keeps.
const OTHER_FORMULA: f64 = 1e-12;

/// Residual of a random problem, relative: its conditioning takes some digits.
const RANDOM_RESIDUAL: f64 = 1e-9;

type Design = fn(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>) -> Lqr;

const BOTH_TIMES: [(TimeDomain, Design); 2] = [
    (TimeDomain::Discrete, Lqr::discrete),
    (TimeDomain::Continuous, Lqr::continuous),
];

fn scalar(design: Design, [a, b, q, r]: [f64; 4]) -> Lqr {
    let [a, b, q, r] = [a, b, q, r].map(|x| dmatrix![x]);
    design(&a, &b, &q, &r)
}

fn diagonal(entries: &[f64]) -> DMatrix<f64> {
    DMatrix::from_diagonal(&DVector::from_column_slice(entries))
}

/// A random system in which Q = Cᵀ C has half the rank of the state.
#[derive(Clone, Debug)]
struct Problem {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    q: DMatrix<f64>,
    r: DMatrix<f64>,
}

impl Problem {
    fn solve(&self, design: Design) -> Lqr {
        design(&self.a, &self.b, &self.q, &self.r)
    }

    /// The Riccati equation as the textbook has it, relative to its largest term.
    fn textbook_residual(&self, time: TimeDomain, p: &DMatrix<f64>) -> f64 {
        let Self { a, b, q, r } = self;
        let (at, bt) = (a.transpose(), b.transpose());
        let inverse = |m: DMatrix<f64>| m.try_inverse().unwrap();
        let terms = match time {
            TimeDomain::Discrete => {
                let gain = inverse(r + &bt * p * b) * &bt * p * a;
                [q.clone(), &at * p * a, -(&at * p * b * gain), -p]
            }
            TimeDomain::Continuous => {
                let quadratic = p * b * inverse(r.clone()) * &bt * p;
                [q.clone(), &at * p, p * a, -quadratic]
            }
        };
        let size = terms.iter().map(DMatrix::norm).fold(0.0, f64::max);
        terms.iter().sum::<DMatrix<f64>>().norm() / size
    }

    /// The cost matrix of running u = −K x for ever: Σ Āᵏᵀ (Q + Kᵀ R K) Āᵏ with Ā = A − B K.
    fn cost_of(&self, gain: &DMatrix<f64>) -> DMatrix<f64> {
        let closed = &self.a - &self.b * gain;
        let mut term = &self.q + gain.transpose() * &self.r * gain;
        let mut sum = term.clone();
        for _ in 0..100_000 {
            term = closed.transpose() * term * &closed;
            sum += &term;
            if term.norm() <= 1e-18 * sum.norm() {
                return sum;
            }
        }
        panic!("the loop is not stable enough to sum its cost");
    }
}

fn entries(nrows: usize, ncols: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0, nrows * ncols)
        .prop_map(move |v| DMatrix::from_vec(nrows, ncols, v))
}

/// Random systems, stable or not: entries of A of size 2 / √nx give a spectral radius around one.
fn problems(nx: usize, nu: usize) -> impl Strategy<Value = Problem> {
    let size = 2.0 / (nx as f64).sqrt();
    let parts = (
        entries(nx, nx),
        entries(nx, nu),
        entries(nx.div_ceil(2), nx),
        entries(nu, nu),
    );
    parts.prop_map(move |(a, b, c, d)| Problem {
        a: a * size,
        b,
        q: c.transpose() * &c,
        r: d.transpose() * &d + DMatrix::identity(nu, nu),
    })
}

fn fixed_seed(cases: u32) -> Config {
    Config {
        cases,
        rng_seed: RngSeed::Fixed(7),
        failure_persistence: None,
        ..Config::default()
    }
}

fn one_problem(nx: usize, nu: usize) -> Problem {
    use proptest::strategy::ValueTree;
    let mut runner = proptest::test_runner::TestRunner::new(fixed_seed(1));
    problems(nx, nu).new_tree(&mut runner).unwrap().current()
}

/// A fixed well-conditioned change of coordinates, to hide the structure of diagonal systems.
fn mixed(nx: usize) -> DMatrix<f64> {
    DMatrix::from_fn(nx, nx, |i, j| {
        if i == j {
            2.0
        } else {
            1.0 / (1.0 + (i + 2 * j) as f64)
        }
    })
}

/// A system with the given modes, input and weight, in mixed coordinates.
fn modal(modes: &[f64], b: &DMatrix<f64>, q: &DMatrix<f64>) -> Problem {
    let t = mixed(modes.len());
    let inverse = t.clone().try_inverse().unwrap();
    Problem {
        a: &t * diagonal(modes) * &inverse,
        b: &t * b,
        q: symmetrized(inverse.transpose() * q * &inverse),
        r: DMatrix::identity(b.ncols(), b.ncols()),
    }
}
