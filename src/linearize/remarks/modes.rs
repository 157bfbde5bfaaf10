//! Remarks on the modes of a robot at rest: how a step multiplies them, and how many steps a period has.
//!
//! A mode e^(λ t) of the motion about a pose has an eigenvalue λ of the Jacobian of the rate, and one of that of the step, μ, which is e^(λ Δt) if the
//! integrator is exact. Which forces an integrator takes at the start, in the middle or at the end of a step is in μ, so that no list of them is
//! needed here. The ground is left out: soft contact has a remark of its own, and rigid contact only holds what would move, which makes no mode faster.

use nalgebra::{Complex, DMatrix, DVector};

use crate::dynamics::mass_matrix;
use crate::linalg::eigenvalues;
use crate::sim::{Integrator, NaturalMode, Simulator, SimulatorRemark, State};

/// Steps of a period below which a vibration is not resolved.
const FEW_STEPS: f64 = 10.0;
/// Part of its amplitude that a vibration loses in a period from which on it is not one that has to be resolved.
const OVERDAMPED: f64 = 0.99;
/// Logarithm of the growth of a mode in a step up to which it counts as roundings: eigenvalues of free bodies are fourfold, and known to the fourth
/// root of roundings only. Beyond its bound a step makes modes grow steeply: this is passed within 0.1 % of it.
const ROUNDING: f64 = 1e-3;
/// By how much faster than the fastest growth in continuous time modes may grow, as a pendulum that falls does: methods of low order are that far off.
const FALLING: f64 = 2.0;
/// Halvings of a step within which a stable one is sought.
const HALVINGS: i32 = 60;
/// Halvings of the interval, in logarithms, that holds the longest stable step: to 0.03 %.
const BISECTIONS: usize = 11;
/// Iterations that find a mode of a known eigenvalue; the second one changes nothing but roundings.
const ITERATIONS: usize = 3;
/// Relative distance from the eigenvalue at which a mode is sought, so that the equations have a solution.
const OFF: f64 = 1e-6;

/// A robot without ground, at rest in a pose.
struct AtRest {
    simulator: Simulator,
    state: State,
    u: Vec<f64>,
    /// Fastest growth in continuous time, 1/s.
    growth: f64,
}

/// Jacobians with velocities in rad or m per step, so that they have entries of one size.
fn scaled(mut a: DMatrix<f64>, dt: f64) -> DMatrix<f64> {
    let nv = a.nrows() / 2;
    let mut upper = a.view_mut((0, nv), (nv, nv));
    upper /= dt;
    let mut lower = a.view_mut((nv, 0), (nv, nv));
    lower *= dt;
    a
}

impl AtRest {
    fn new(simulator: &Simulator, q: &[f64]) -> Self {
        let simulator = simulator.without_contacts();
        let mut out = Self {
            state: simulator.state(q, &vec![0.0; simulator.model().nv()]),
            u: vec![0.0; simulator.nu()],
            simulator,
            growth: 0.0,
        };
        let grown = eigenvalues(out.rate()).into_iter().map(|z| z.re);
        out.growth = grown.fold(0.0, f64::max) / out.simulator.time_step();
        out
    }

    /// Jacobian of the rate, per step.
    fn rate(&self) -> DMatrix<f64> {
        let dt = self.simulator.time_step();
        scaled(self.simulator.linearize_rate(&self.state, &self.u).a, dt) * dt
    }

    /// Jacobian of a step.
    fn step(&self) -> DMatrix<f64> {
        let a = self.simulator.linearize(&self.state, &self.u).a;
        scaled(a, self.simulator.time_step())
    }

    fn with(&self, change: impl FnOnce(Simulator) -> Simulator) -> Self {
        Self {
            simulator: change(self.simulator.clone()),
            state: self.state.clone(),
            u: self.u.clone(),
            growth: self.growth,
        }
    }

    /// The largest eigenvalue of a step in which a mode grows more than in continuous time; infinite where the step is not finite.
    fn growing(&self) -> Option<Complex<f64>> {
        let step = self.step();
        if step.iter().any(|x| !x.is_finite()) {
            return Some(Complex::from(f64::INFINITY));
        }
        let of_step = eigenvalues(step).into_iter();
        let largest = of_step.max_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()))?;
        let allowed = ROUNDING + FALLING * self.growth * self.simulator.time_step();
        (largest.norm().ln() > allowed).then_some(largest)
    }

    fn is_stable(&self) -> bool {
        self.growing().is_none()
    }

    /// The longest step that is stable, s, and the robot with one that is hardly longer; nothing if none is.
    fn longest(&self) -> Option<(f64, Self)> {
        let with_step = |dt| self.with(|simulator| simulator.with_time_step(dt));
        let dt = self.simulator.time_step();
        let halved = (1..HALVINGS).map(|k| dt * 0.5_f64.powi(k));
        let mut stable = { halved }.find(|&dt| with_step(dt).is_stable())?;
        let mut unstable = 2.0 * stable;
        for _ in 0..BISECTIONS {
            let middle = (stable * unstable).sqrt();
            match with_step(middle).is_stable() {
                true => stable = middle,
                false => unstable = middle,
            }
        }
        Some((stable, with_step(unstable)))
    }

    /// Positions of the mode of an eigenvalue, of one phase or the other: a plane that A leaves as it is, by inverse iteration with the real
    /// (A − λ) (A − λ̄).
    fn shape(&self, a: &DMatrix<f64>, eigenvalue: Complex<f64>) -> Option<[DVector<f64>; 2]> {
        let (n, near) = (a.nrows(), eigenvalue * (1.0 + OFF));
        let product = a * a - a * (2.0 * near.re) + DMatrix::identity(n, n) * near.norm_sqr();
        let factors = product.lu();
        let mut x = DVector::from_fn(n, |i, _| 1.0 / (1.0 + i as f64));
        for _ in 0..ITERATIONS {
            x = factors.solve(&x)?.normalize();
        }
        let y = a * &x;
        let is_finite = x.iter().all(|x| x.is_finite());
        is_finite.then(|| [x, y].map(|x| x.rows(0, n / 2).into_owned()))
    }

    /// Name of the coordinate with the largest part of the kinetic energy.
    fn name(&self, shape: &[DVector<f64>; 2]) -> String {
        let mass = self.mass().diagonal();
        let energy = |k: usize| mass[k] * (shape[0][k].powi(2) + shape[1][k].powi(2));
        let most = (0..mass.len()).max_by(|&a, &b| energy(a).total_cmp(&energy(b)));
        let names = self.simulator.tangent_names();
        let name = most.and_then(|k| names.into_iter().nth(k));
        name.map_or_else(String::new, |name| name.replacen("q.", "", 1))
    }

    fn mass(&self) -> DMatrix<f64> {
        mass_matrix(self.simulator.model(), self.state.q.as_slice())
    }

    /// The motion of a shape by itself: m s² + d s + k = 0 with the mass, damper and spring along it.
    fn along(&self, shape: &[DVector<f64>; 2]) -> NaturalMode {
        let (mass, rate, nv) = (self.mass(), self.rate(), shape[0].len());
        let dt = self.simulator.time_step();
        let x = &shape[0];
        let weighted = &mass * x;
        let m = weighted.dot(x);
        let of = |column: usize| -weighted.dot(&(rate.view((nv, column), (nv, nv)) * x)) / m;
        let (k, half) = (of(0), of(nv) / 2.0);
        let root = Complex::from(half * half - k).sqrt();
        let (re, im) = (-half - root.re, root.im);
        NaturalMode::of(self.name(shape), re / dt, im / dt)
    }
}

impl Simulator<f64> {
    /// The remark on modes at rest in a pose: on one that grows though it should not, else on the fastest vibration that is not resolved.
    pub(super) fn remark_on_modes(&self, q: &[f64]) -> Option<SimulatorRemark> {
        let at_rest = AtRest::new(self, q);
        match at_rest.is_stable() {
            true => unresolved(&at_rest),
            false => unstable(&at_rest),
        }
    }
}

fn unstable(at_rest: &AtRest) -> Option<SimulatorRemark> {
    let (longest, beyond) = at_rest.longest()?;
    let shape = beyond.shape(&beyond.step(), beyond.growing()?)?;
    let candidates = [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity];
    let is_stable = |&integrator: &Integrator| {
        let other = at_rest.with(|simulator| simulator.with_integrator(integrator));
        other.is_stable()
    };
    Some(SimulatorRemark::UnstableMode {
        mode: beyond.along(&shape),
        longest,
        time_step: at_rest.simulator.time_step(),
        stable: candidates.into_iter().find(is_stable),
    })
}

fn unresolved(at_rest: &AtRest) -> Option<SimulatorRemark> {
    let rate = at_rest.rate();
    // e^(2π λ.re / λ.im) is left of the amplitude after a period.
    let damping = -(1.0 - OVERDAMPED).ln() / std::f64::consts::TAU;
    let vibrates = |z: &Complex<f64>| -z.re < damping * z.im;
    let vibrations = eigenvalues(rate.clone()).into_iter().filter(vibrates);
    let fastest = vibrations.max_by(|a, b| a.im.total_cmp(&b.im))?;
    if fastest.im * FEW_STEPS < std::f64::consts::TAU {
        return None;
    }
    let name = at_rest.name(&at_rest.shape(&rate, fastest)?);
    let (dt, z) = (at_rest.simulator.time_step(), fastest);
    Some(SimulatorRemark::UnresolvedMode {
        mode: NaturalMode::of(name, z.re / dt, z.im / dt),
        time_step: dt,
    })
}
