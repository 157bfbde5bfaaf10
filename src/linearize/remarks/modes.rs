//! Remarks on the modes of a robot at rest: their amplification by a step, and the number of steps per period.
//!
//! A mode e^(λ t) of the motion about a pose has an eigenvalue λ of the Jacobian of the rate, and one of that of the step, μ, which is e^(λ Δt) if the
//! integrator is exact. μ contains which forces an integrator evaluates at the start, in the middle or at the end of a step. The ground is excluded:
//! soft contact has its own remark, and rigid contact does not make modes faster.
//!
//! For a spring s and a damper d on a mass m with ω² = s / m, the longest stable steps found by this method are
//!
//! | force | semi-implicit Euler, implicit velocity | Runge–Kutta | implicit midpoint |
//! |---|---|---|---|
//! | spring of a joint, or of a constraint (not with the implicit midpoint rule) | any | 2.828 / ω | any |
//! | damper of these | any | 2.785 m / d | any |
//! | spring as external force, gravity of a pendulum | 2 / ω | 2.828 / ω | any |
//! | damper as external force | 2 m / d | 2.785 m / d | any |

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix};

use super::frozen::{Frozen, Shape, shape};
use crate::linalg::eigenvalues;
use crate::sim::{Integrator, NaturalMode, Simulator, SimulatorRemark};

/// Steps of a period below which a vibration is not resolved.
const FEW_STEPS: f64 = 10.0;
/// Part of its amplitude that is left after a period of a vibration which is damped too much to need it resolved.
const LITTLE: f64 = 0.01;
/// Logarithm of the growth of a mode in a step up to which it counts as roundings: eigenvalues of free bodies are fourfold, and known to the fourth
/// root of roundings only. Beyond its bound a step makes modes grow steeply: this is passed within 0.1 % of it.
const ROUNDING: f64 = 1e-3;
/// Allowed growth of modes beyond the fastest growth in continuous time, as of a falling pendulum: the error of methods of low order.
const FALLING: f64 = 2.0;
/// Halvings of a step within which a stable one is sought.
const HALVINGS: i32 = 60;
/// Halvings of the interval, in logarithms, that holds the longest stable step: to 0.03 %.
const BISECTIONS: usize = 11;

/// A robot at rest without ground.
struct AtRest {
    robot: Frozen,
    /// Fastest growth in continuous time, 1/s.
    growth: f64,
}

impl AtRest {
    fn new(simulator: &Simulator, q: &[f64]) -> Self {
        let still = vec![0.0; simulator.model().nv()];
        let robot = Frozen::new(simulator.without_contacts(), q, &still);
        let rates = eigenvalues(robot.rate()).into_iter().map(|z| z.re);
        let growth = rates.fold(0.0, f64::max) / robot.dt();
        Self { robot, growth }
    }

    fn with(&self, change: impl FnOnce(Simulator) -> Simulator) -> Self {
        Self {
            robot: self.robot.with(change),
            growth: self.growth,
        }
    }

    /// The largest eigenvalue of a step in which a mode grows more than in continuous time; infinite where the step is not finite.
    fn growing(&self) -> Option<Complex<f64>> {
        let step = self.robot.step();
        if step.iter().any(|x| !x.is_finite()) {
            return Some(Complex::from(f64::INFINITY));
        }
        // Eigenvalues of free motion are all 1, which the search for them tells apart better about 0.
        let identity = DMatrix::identity(step.nrows(), step.nrows());
        let of_step = eigenvalues(step - identity).into_iter().map(|z| z + 1.0);
        let largest = of_step.max_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()))?;
        let allowed = ROUNDING + FALLING * self.growth * self.robot.dt();
        (largest.norm().ln() > allowed).then_some(largest)
    }

    fn is_stable(&self) -> bool {
        self.growing().is_none()
    }

    /// The longest step that is stable, s, and the robot with one that is hardly longer; nothing if none is.
    fn longest(&self) -> Option<(f64, Self)> {
        let with_step = |dt| self.with(|simulator| simulator.with_time_step(dt));
        let mut halved = (1..HALVINGS).map(|k| self.robot.dt() * 0.5_f64.powi(k));
        let mut stable = halved.find(|&dt| with_step(dt).is_stable())?;
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

    /// The motion along a single mode shape: m λ² + d λ + k = 0 with mass, damper and spring along it.
    fn along(&self, shape: &Shape) -> NaturalMode {
        let (rate, nv, x) = (self.robot.rate(), shape[0].len(), &shape[0]);
        let weighted = self.robot.mass() * x;
        let m = weighted.dot(x);
        let of = |column: usize| -weighted.dot(&(rate.view((nv, column), (nv, nv)) * x)) / m;
        let (k, half) = (of(0), of(nv) / 2.0);
        let root = Complex::from(half * half - k).sqrt();
        let eigenvalue = Complex::new(-half - root.re, root.im);
        self.named(shape, eigenvalue)
    }

    /// The mode of an eigenvalue of the rate per step.
    fn named(&self, shape: &Shape, eigenvalue: Complex<f64>) -> NaturalMode {
        let dt = self.robot.dt();
        NaturalMode::of(
            self.robot.name(shape),
            eigenvalue.re / dt,
            eigenvalue.im / dt,
        )
    }

    fn unstable(&self) -> Option<SimulatorRemark> {
        let (longest, beyond) = self.longest()?;
        let motion = shape(&beyond.robot.step(), beyond.growing()?)?;
        let candidates = [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity];
        let with = |&by: &Integrator| self.with(|simulator| simulator.with_integrator(by));
        Some(SimulatorRemark::UnstableMode {
            mode: beyond.along(&motion),
            longest,
            time_step: self.robot.dt(),
            stable: candidates.into_iter().find(|by| with(by).is_stable()),
        })
    }

    fn unresolved(&self) -> Option<SimulatorRemark> {
        let rate = self.robot.rate();
        // e^(2π Re λ / Im λ) is left of the amplitude after a period.
        let vibrates = |z: &Complex<f64>| (TAU * z.re).exp() > LITTLE.powf(z.im);
        let vibrations = eigenvalues(rate.clone()).into_iter();
        let vibrations = vibrations.filter(|z| z.im * FEW_STEPS > TAU && vibrates(z));
        let fastest = vibrations.max_by(|a, b| a.im.total_cmp(&b.im))?;
        Some(SimulatorRemark::UnresolvedMode {
            mode: self.named(&shape(&rate, fastest)?, fastest),
            time_step: self.robot.dt(),
        })
    }
}

impl Simulator<f64> {
    /// The remark on modes at rest in a pose: on one that grows though it should not, else on the fastest vibration that is not resolved.
    pub(super) fn remark_on_modes(&self, q: &[f64]) -> Option<SimulatorRemark> {
        let at_rest = AtRest::new(self, q);
        // The implicit midpoint rule is stable at any step.
        match self.integrator() == Integrator::ImplicitMidpoint || at_rest.is_stable() {
            true => at_rest.unresolved(),
            false => at_rest.unstable(),
        }
    }
}
