//! An interior-point method along the central path: slower than Newton's on the active set, but it finds its way from anywhere.
//!
//! Forces f and velocities y are inside their cones; each step solves the path's equations for a smaller κ, linearised after Nesterov and Todd,
//! and goes at most to just before the surface. For Coulomb's law the tangential pair has a third number, the velocity `extra` that
//! goes with μ fₙ in the law of greatest dissipation; an interval has a multiplier for each of its bounds. [Nesterov & Todd 1997; Vandenberghe 2010; Howell et al. 2022].

use super::Law;
use super::interval::{Multipliers, bound_on_path};
use super::jacobian::Square;
use super::newton::{RIDGE, largest, product};
use super::second_order_cone::{Pair, scaling};
use super::system::{Kind, System, Unit, of_unit};
use crate::linalg::{Factors, Lu};
use crate::scalar::{MapEach, Scalar};

/// Steps in one go; the path takes ten to thirty.
const MAX_STEPS: usize = 60;
/// The part of the way to the surface that a step may go.
const TO_SURFACE: f64 = 0.99;
/// Ratio of the forces at the start to the free velocities, both scaled: heavy on light needs forces that grow large, and those that are
/// too large at first fall quickly.
const STRONG: f64 = 1e3;
/// The share of the first products that they keep while y = W f + g is as far from satisfied as at first.
const HOLD: f64 = 0.1;
/// Steps for a smoothed law before Newton's method is tried again: it is near enough only on the path itself.
const LEAST_STEPS: usize = 3;
/// Less friction than this is raised to it here, which the steps on the active set put right.
const LEAST_FRICTION: f64 = 1e-6;
/// The share of κ that a step keeps: at least, for a step that was free to go its way, and at most.
const SHARES: (f64, f64) = (0.02, 0.8);
/// The part of the way that a step of a fixed number may go: farther from the surface all steps are long, where those of a search
/// are short now and then, of which it takes more.
const STEADY_TO_SURFACE: f64 = 0.9;
/// The least share of κ that each of a fixed number of steps keeps; more brings it nearer to the path.
const STEADY_SHARE: f64 = 0.05;
/// Steps shorter than this do not get anywhere.
const SHORT: f64 = 1e-5;
/// A residual of y = W f + g that the rest of the path removes, beside the size of the problem.
const NEARLY_FEASIBLE: f64 = 1e-5;

/// Compliance of moments on the path, beside a diagonal of 1.
const YIELDING: f64 = 1e6;

/// End of the way along the path: κ is the larger of `kappa` and `relative` times the size of the problem squared.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathTarget {
    pub(super) kappa: f64,
    pub(super) relative: f64,
}

#[derive(Clone, Debug)]
pub(super) struct Interior<T = f64> {
    pub(super) f: Vec<T>,
    y: Vec<T>,
    /// The free velocities that the path is for.
    pub(super) g: Vec<T>,
    law: Law,
    extra: Vec<T>,
    /// The linearised law of each unit: H δf + δy = c.
    h: Vec<Square<T>>,
    c: Vec<T>,
    /// The first row of the cone's law, for `extra`.
    extra_rows: Vec<([T; 3], T)>,
    /// Of intervals.
    multipliers: Vec<Multipliers<T>>,
    df: Vec<T>,
    dy: Vec<T>,
    size: T,
    /// Lower bound of κ per unit of the error, so that products do not vanish before the forces are found.
    hold: T,
    /// Whether a place on the path was reached before.
    arrived: bool,
    share: T,
    pub(super) steps: usize,
}

impl<T: Scalar> Default for Interior<T> {
    fn default() -> Self {
        Self {
            f: Vec::new(),
            y: Vec::new(),
            g: Vec::new(),
            law: Law::default(),
            extra: Vec::new(),
            h: Vec::new(),
            c: Vec::new(),
            extra_rows: Vec::new(),
            multipliers: Vec::new(),
            df: Vec::new(),
            dy: Vec::new(),
            size: T::zero(),
            hold: T::zero(),
            arrived: false,
            share: T::zero(),
            steps: 0,
        }
    }
}

impl<T: Scalar> Interior<T> {
    /// Makes room for so many rows.
    pub(super) fn reserve(&mut self, rows: usize) {
        let forces = [&mut self.f, &mut self.df, &mut self.extra, &mut self.c];
        let velocities = [&mut self.y, &mut self.dy, &mut self.g];
        let all = forces.into_iter().chain(velocities);
        all.for_each(|x| x.reserve(rows));
        self.h.reserve(rows);
        self.extra_rows.reserve(rows);
        self.multipliers.reserve(rows);
    }

    /// A start inside all cones, of the size of the problem.
    pub(super) fn start(&mut self, system: &System<T>, law: Law, size: T) {
        let (n, units) = (system.n, system.units.len());
        for x in [
            &mut self.f,
            &mut self.y,
            &mut self.c,
            &mut self.df,
            &mut self.dy,
        ] {
            x.clear();
            x.resize(n, T::zero());
        }
        self.h.resize(units, [[T::zero(); 3]; 3]);
        self.extra_rows.resize(units, ([T::zero(); 3], T::zero()));
        self.extra.clear();
        self.law = law;
        self.size = size.max(T::constant(f64::MIN_POSITIVE.sqrt()));
        (self.share, self.hold) = (T::constant(SHARES.1), T::zero());
        self.arrived = false;
        self.multipliers.clear();
        let kappa = self.size * self.size * STRONG;
        for unit in &system.units {
            if matches!(unit.kind, Kind::Ray | Kind::Cone) {
                self.f[unit.row] = self.size * STRONG;
                self.y[unit.row] = self.size;
            }
            self.extra.push(self.size / friction(unit));
            self.multipliers.push(match unit.kind {
                Kind::Interval => Multipliers::start(self.bound(unit), kappa),
                _ => Multipliers::none(),
            });
        }
    }

    /// Goes a fixed number of steps along the path, without early end, to a κ of at least `kappa`.
    pub(super) fn walk(
        &mut self,
        system: &System<T>,
        factors: &mut impl Factors<T>,
        kappa: T,
        steps: usize,
    ) {
        for step in 0..steps {
            let (gap, error) = (self.gap(system), self.error(system));
            if step == 0 {
                let some = T::zero().select_lt(error, error, T::one());
                self.hold = gap * HOLD / some;
            }
            let least = kappa.max(self.hold * error);
            self.linearize(system, least.max(self.share * gap));
            self.direction(system, factors);
            let length = self.advance(system, STEADY_TO_SURFACE);
            self.share = (-length + 1.0).clamp(STEADY_SHARE, SHARES.1);
        }
    }

    /// One more step, over a system with derivatives, whose values are those of the path so far: it gives the forces theirs.
    ///
    /// Returns how far the path is from its end then, in values: the error of y = W f + g, and the gap beside κ, relative to the size of the problem.
    /// Forces and velocities are inside their cones, so that a gap bounds the distance from the solution.
    pub(super) fn arrive(
        &mut self,
        system: &System<T>,
        factors: &mut impl Factors<T>,
        kappa: T,
    ) -> T {
        self.error(system);
        self.linearize(system, kappa);
        self.direction(system, factors);
        let derivatives: Vec<T> = self.df.iter().map(|&df| df - df.detached()).collect();
        let steps = self.df.iter_mut().chain(&mut self.dy);
        steps.for_each(|x| *x = x.detached());
        self.advance(system, STEADY_TO_SURFACE);
        let (gap, error) = (self.gap(system), self.error(system));
        for (f, d) in self.f.iter_mut().zip(derivatives) {
            *f += d;
        }
        let off = (gap - kappa) / (self.size * self.size);
        off.max(error / self.size).detached()
    }

    /// The mean of the products that equal κ on the central path.
    fn gap(&self, system: &System<T>) -> T {
        let (mut sum, mut count) = (T::zero(), 0.0);
        for (index, unit) in system.units.iter().enumerate() {
            if unit.kind == Kind::Ray || (unit.kind == Kind::Cone && self.law == Law::Coulomb) {
                sum += self.f[unit.row] * self.y[unit.row];
                count += 1.0;
            }
            if unit.kind == Kind::Cone {
                sum += self.pair(unit, index).product();
                count += 1.0;
            }
            if unit.kind == Kind::Interval {
                let (own, f) = (&self.multipliers[index], self.f[unit.row]);
                let [below, above] = own.products(f, self.bound(unit));
                sum += below + above;
                count += 2.0;
            }
        }
        if count > 0.0 { sum / count } else { T::zero() }
    }

    /// c ← W f + g − y for now; its largest entry.
    fn error(&mut self, system: &System<T>) -> T {
        system.velocities(&self.f, &self.g, &mut self.c);
        for (c, &y) in self.c.iter_mut().zip(&self.y) {
            *c -= y;
        }
        largest(&self.c)
    }

    /// The bound of an interval, near enough to the size of the problem for the path.
    fn bound(&self, unit: &Unit<T>) -> T {
        bound_on_path(unit.mu, self.size)
    }

    /// (μ fₙ, fₜ) and (velocity that goes with it, yₜ).
    fn pair(&self, unit: &Unit<T>, index: usize) -> Pair<T> {
        let (f, y) = (of_unit(&self.f, unit), of_unit(&self.y, unit));
        let mu = friction(unit);
        let first = if self.law == Law::Convex {
            y[0] / mu
        } else {
            self.extra[index]
        };
        Pair {
            z: [mu * f[0], f[1], f[2]],
            w: [first, y[1], y[2]],
        }
    }

    /// H and c of every unit; the right side  df = c − (W f + g − y).
    fn linearize(&mut self, system: &System<T>, kappa: T) {
        for (index, unit) in system.units.iter().enumerate() {
            let (f, y) = (of_unit(&self.f, unit), of_unit(&self.y, unit));
            let (mut h, mut c) = ([[T::zero(); 3]; 3], [T::zero(); 3]);
            match unit.kind {
                Kind::Row => {}
                Kind::Ray => (h[0][0], c[0]) = (y[0] / f[0], kappa / f[0] - y[0]),
                Kind::Cone => (h, c) = self.linearize_cone(unit, index, kappa),
                Kind::Interval => {
                    let bound = self.bound(unit);
                    let own = &mut self.multipliers[index];
                    (h[0][0], c[0]) = own.linearize(f[0], bound, kappa);
                }
                // Moments change little of the rest: on the path they give way, and the active set finds them.
                Kind::Spin | Kind::Roll => {
                    (h[0][0], h[1][1]) = (T::constant(YIELDING), T::constant(YIELDING));
                }
            }
            self.h[index] = h;
            for i in 0..unit.rows() {
                let row = unit.row + i;
                self.df[row] = c[i] - self.c[row];
                self.c[row] = c[i];
            }
        }
    }

    /// S δz + δw = κ z⁻¹ − w.
    fn linearize_cone(&mut self, unit: &Unit<T>, index: usize, kappa: T) -> (Square<T>, [T; 3]) {
        let pair = self.pair(unit, index);
        let (mut h, mut c) = (scaling(&pair), pair.target(kappa));
        let mu = friction(unit);
        for i in 0..3 {
            h[i][0] *= mu;
        }
        if self.law == Law::Convex {
            h[0] = h[0].map_each(|entry| entry * mu);
            c[0] *= mu;
        } else {
            let (f, y) = (self.f[unit.row], self.y[unit.row]);
            // This row only gives the step of `extra`; Signorini's law replaces it.
            self.extra_rows[index] = (h[0], c[0]);
            h[0] = [y / f, T::zero(), T::zero()];
            c[0] = kappa / f - y;
        }
        (h, c)
    }

    /// (W + H) δf = c − (W f + g − y),  δy = c − H δf. The matrix is one of values, also where the right side has derivatives.
    fn direction(&mut self, system: &System<T>, factors: &mut impl Factors<T>) {
        let n = system.n;
        factors.start(n);
        for (j, w) in system.w.chunks_exact(n.max(1)).enumerate() {
            let column = factors.column_mut(j);
            let entries = column.iter_mut().zip(w);
            entries.for_each(|(out, w)| *out = w.detached());
            column[j] += T::constant(RIDGE);
        }
        for (unit, h) in system.units.iter().zip(&self.h) {
            for j in 0..unit.rows() {
                let column = factors.column_mut(unit.row + j);
                for i in 0..unit.rows() {
                    column[unit.row + i] += h[i][j].detached();
                }
            }
        }
        factors.factorize();
        factors.solve(&mut self.df);
        for (unit, h) in system.units.iter().zip(&self.h) {
            let change = product(h, of_unit(&self.df, unit));
            for i in 0..unit.rows() {
                self.dy[unit.row + i] = self.c[unit.row + i] - change[i];
            }
        }
        self.steps += 1;
    }

    /// Goes along the direction, at most so much of the way to the surface of a cone; returns how far.
    fn advance(&mut self, system: &System<T>, to_surface: f64) -> T {
        let mut length = T::one();
        for (index, unit) in system.units.iter().enumerate() {
            // A room that is not a number limits nothing.
            length = (self.room(unit, index) * to_surface).min(length);
        }
        for (index, unit) in system.units.iter().enumerate() {
            if unit.kind == Kind::Cone && self.law == Law::Coulomb {
                let step = self.extra_step(unit, index);
                self.extra[index] += length * step;
            }
        }
        for (x, dx) in [(&mut self.f, &self.df), (&mut self.y, &self.dy)] {
            for (x, &dx) in x.iter_mut().zip(dx) {
                *x += length * dx;
            }
        }
        for (unit, own) in system.units.iter().zip(&mut self.multipliers) {
            if unit.kind == Kind::Interval {
                own.advance(length, self.df[unit.row]);
                self.y[unit.row] = own.velocity();
            }
        }
        length
    }

    fn extra_step(&self, unit: &Unit<T>, index: usize) -> T {
        let (row, constant) = self.extra_rows[index];
        let df = of_unit(&self.df, unit);
        constant - row[0] * df[0] - row[1] * df[1] - row[2] * df[2]
    }

    /// Largest fraction of the direction that keeps this unit inside its cone; infinite for bilateral rows.
    fn room(&self, unit: &Unit<T>, index: usize) -> T {
        let (f, y) = (self.f[unit.row], self.y[unit.row]);
        let (df, dy) = (of_unit(&self.df, unit), of_unit(&self.dy, unit));
        let ray = room_of_ray(f, df[0]).min(room_of_ray(y, dy[0]));
        match unit.kind {
            Kind::Row | Kind::Spin | Kind::Roll => T::constant(f64::INFINITY),
            Kind::Ray => ray,
            Kind::Interval => {
                let own = &self.multipliers[index];
                let pairs = own.positive(f, df[0], self.bound(unit).detached());
                let rooms = pairs.map_each(|(x, dx)| room_of_ray(x, dx));
                rooms.into_iter().fold(rooms[0], |least, x| x.min(least))
            }
            Kind::Cone => {
                let mu = friction(unit);
                let first = match self.law {
                    Law::Convex => dy[0] / mu,
                    Law::Coulomb => self.extra_step(unit, index),
                };
                let step = Pair {
                    z: [mu * df[0], df[1], df[2]],
                    w: [first, dy[1], dy[2]],
                };
                ray.min(self.pair(unit, index).room(&step))
            }
        }
    }
}

impl Interior {
    /// Goes on along the path to a target, in at most so many steps.
    pub(super) fn follow(
        &mut self,
        system: &System,
        lu: &mut Lu,
        target: PathTarget,
        most: usize,
    ) -> bool {
        let PathTarget { kappa, relative } = target;
        let least_steps = if self.arrived && kappa > 0.0 {
            LEAST_STEPS
        } else {
            0
        };
        let goal = kappa.max(relative * self.size * self.size);
        for step in 0..MAX_STEPS.min(most) {
            let gap = self.gap(system);
            let error = self.error(system);
            if step >= least_steps && gap <= 2.0 * goal && error <= NEARLY_FEASIBLE * self.size {
                self.arrived = true;
                return true;
            }
            if self.hold == 0.0 && error > 0.0 {
                self.hold = HOLD * gap / error;
            }
            let least = kappa.max(self.hold * error);
            self.linearize(system, least.max(self.share * gap));
            self.direction(system, lu);
            let finite = self.df.iter().all(|df| df.is_finite());
            let length = if finite {
                self.advance(system, TO_SURFACE)
            } else {
                0.0
            };
            if length <= SHORT {
                return false;
            }
            self.share = (1.0 - length).powi(2).clamp(SHARES.0, SHARES.1);
        }
        false
    }
}

/// Fraction of a step at which x reaches zero; infinite where x does not fall.
fn room_of_ray<T: Scalar>(x: T, step: T) -> T {
    let zero = T::zero();
    let room = -x / step.select_lt(zero, step, -T::one());
    step.select_lt(zero, room, T::constant(f64::INFINITY))
}

fn friction<T: Scalar>(unit: &Unit<T>) -> T {
    unit.mu.max(T::constant(LEAST_FRICTION))
}
