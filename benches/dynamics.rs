//! Times of the core, named `function/scalar/robot`.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use dualbody::dynamics::{
    AbaScratch, CrbaScratch, RneaScratch, forward_dynamics_into, inverse_dynamics_into,
    mass_matrix_into,
};
use dualbody::joint::JointKind;
use dualbody::linearize::LinearizeScratch;
use dualbody::model::{Model, samples};
use dualbody::sim::StepScratch;
use dualbody::{Linearization, Over, Simulator, State};
use nalgebra::DMatrix;
use num_dual::DualSVec64;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

fn robots() -> Vec<(&'static str, Model)> {
    vec![
        ("cartpole", samples::cartpole()),
        ("arm7", samples::arm()),
        (
            "tree30",
            samples::random_tree_of(&[JointKind::Revolute], 30, 1),
        ),
    ]
}

/// Seeds the values: the identity for `f64`, four directions for dual numbers.
trait Seed: Over<f64> {
    const NAME: &'static str;
    fn seed(x: f64, k: usize) -> Self;
}

impl Seed for f64 {
    const NAME: &'static str = "f64";
    fn seed(x: f64, _k: usize) -> Self {
        x
    }
}

impl Seed for DualSVec64<4> {
    const NAME: &'static str = "dual4";
    fn seed(x: f64, k: usize) -> Self {
        Self::from(x).derivative(k % 4)
    }
}

fn random<T: Seed>(n: usize, rng: &mut Xoshiro256PlusPlus) -> Vec<T> {
    (0..n)
        .map(|k| T::seed(rng.random_range(-1.0..1.0), k))
        .collect()
}

fn bench_scalar<T: Seed>(c: &mut Criterion) {
    for (robot, model) in robots() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let (q, v, w) = (
            random::<T>(model.nq(), &mut rng),
            random::<T>(model.nv(), &mut rng),
            random::<T>(model.nv(), &mut rng),
        );
        let mut out = w.clone();
        let name = |function: &str| format!("{function}/{}/{robot}", T::NAME);
        let mut rnea = RneaScratch::new(&model);
        c.bench_function(&name("rnea"), |b| {
            b.iter(|| {
                inverse_dynamics_into(&model, black_box(&q), &v, &w, &[], &mut rnea, &mut out);
            });
        });
        let (mut crba, mut mass) = (
            CrbaScratch::new(&model),
            DMatrix::zeros(model.nv(), model.nv()),
        );
        c.bench_function(&name("crba"), |b| {
            b.iter(|| mass_matrix_into(&model, black_box(&q), &mut crba, &mut mass));
        });
        let mut aba = AbaScratch::new(&model);
        c.bench_function(&name("aba"), |b| {
            b.iter(|| {
                forward_dynamics_into(&model, black_box(&q), &v, &w, &[], &mut aba, &mut out);
            });
        });
        let simulator = Simulator::new(model.clone()).with_time_step(1e-3);
        let (state, mut scratch) = (State::new(&q, &v), StepScratch::new(&model));
        let mut next = state.clone();
        c.bench_function(&name("step"), |b| {
            b.iter(|| simulator.step_into(black_box(&state), &w, &mut scratch, &mut next));
        });
    }
}

fn bench_linearize(c: &mut Criterion) {
    for (robot, model) in robots() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let state = State::new(
            &random::<f64>(model.nq(), &mut rng),
            &random::<f64>(model.nv(), &mut rng),
        );
        let u = random::<f64>(model.nv(), &mut rng);
        let simulator = Simulator::new(model).with_time_step(1e-3);
        let (mut scratch, mut out) = (
            LinearizeScratch::new(&simulator),
            Linearization::zeros(&simulator),
        );
        c.bench_function(&format!("linearize/dual/{robot}"), |b| {
            b.iter(|| simulator.linearize_into(black_box(&state), &u, &mut scratch, &mut out));
        });
    }
}

criterion_group!(
    benches,
    bench_scalar::<f64>,
    bench_scalar::<DualSVec64<4>>,
    bench_linearize
);
criterion_main!(benches);
