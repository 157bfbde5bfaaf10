//! Residuals of a solution, and the mode of each block.

use super::Law;
use super::interval::clamped;
use super::law::Piece;
use super::newton::{Newton, UnitEquations};
use super::system::{Kind, Unit, UnitState, of_unit};
use crate::scalar::MapEach;

/// Distances to the surfaces between modes, beside the size of the problem, that count as none.
const ON_THE_SURFACE: f64 = 1e-9;

/// Status of a solution, from the best to the worst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// The residual is below the tolerance.
    #[default]
    Converged,
    /// The residual is below the [acceptable](super::ConeOptions::acceptable) one; the tolerance was not reached within a few tens of iterations.
    Acceptable,
    /// No solution was found: usually bilateral rows contradict each other, or contacts squeeze a body between rigid ones. The forces solve the
    /// problem with [`REGULARIZATION`](super::REGULARIZATION) of its diagonal as additional regularisation.
    Regularized,
    /// No solution was found within the iteration limit, or the residual is above the acceptable one (up to 1e-4), or more points should take part
    /// than [allowed](crate::contact::SolverOptions::points). The forces are finite and inside their cones.
    IterationLimit,
    /// An entry of the problem is not finite, or a force would not be; the forces are zero.
    NotFinite,
}

/// Accuracy of a solution: its status, its residual, and the violation of each condition.
///
/// Each row is scaled by the square root of its diagonal entry of G + diag R (in a cone, of the mean of the three entries), so that forces and
/// velocities have the same unit √J. Distances are then divided by σ = max |f| + max |g|, and products by σ². All values are maxima over blocks and
/// lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Certificate {
    /// Status of the solution.
    pub status: Status,
    /// Matrices factorised.
    pub iterations: usize,
    /// Natural map: ‖f − P(f − ŷ)‖ with P the projection on the cone or the interval; on the central path the residual of its equations.
    pub residual: f64,
    /// Distance of the force from its cone or its interval.
    pub cone_violation: f64,
    /// |fᵀ ŷ|; on the central path |fᵀ ŷ − κ|, with its ŷ. Of an interval |y| times the distance of the force from the bound at which that velocity is
    /// allowed; 0 on the path, where the residual contains this.
    pub complementarity: f64,
    /// Distance of the velocity ŷ from the dual cone; |y| of bilateral rows; 0 of intervals, which allow any.
    pub dual_violation: f64,
}

impl Certificate {
    /// Whether the status is [`Status::Converged`].
    pub fn is_converged(&self) -> bool {
        self.status == Status::Converged
    }

    /// The worse of two, number by number.
    pub(crate) fn worse(self, other: Self) -> Self {
        Self {
            status: self.status.max(other.status),
            iterations: self.iterations.max(other.iterations),
            residual: self.residual.max(other.residual),
            cone_violation: self.cone_violation.max(other.cone_violation),
            complementarity: self.complementarity.max(other.complementarity),
            dual_violation: self.dual_violation.max(other.dual_violation),
        }
    }
}

/// The active piece of the law of a block, which explains its derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Bilateral rows: the velocity is zero.
    Bilateral,
    /// No force; derivatives are zero.
    Separated,
    /// No force and no velocity; derivatives are zero, those of separation.
    Touching,
    /// A ray with a force: no velocity.
    Pressing,
    /// A force inside the cone: no velocity.
    Sticking,
    /// A force on the surface of the cone and no slip, or at a bound and no velocity; derivatives are those of either side.
    Impending,
    /// A force on the surface of the cone, against the slip.
    Sliding,
    /// A force between its bounds: no velocity.
    Holding,
    /// A force at a bound: the row yields.
    Yielding,
    /// A smoothed law: all derivatives exist, and decrease with the distance from the next mode.
    Smoothed,
}

/// The mode of a unit, from the piece of its law that holds.
pub(super) fn mode(newton: &Newton, unit: &Unit, own: &UnitEquations) -> Mode {
    let (f, y) = (of_unit(&newton.f, unit), of_unit(&newton.y, unit));
    let near = ON_THE_SURFACE * newton.size();
    let slack = unit.mu * f[0] - across(f);
    if let Some(bounded) = newton.system.bounded(unit, &newton.f) {
        return mode_of_moment(&bounded, [f, y], near);
    }
    match (unit.kind, own.piece) {
        (Kind::Row, Piece::Separated) => Mode::Separated,
        (Kind::Row, _) => Mode::Bilateral,
        (_, piece) if piece.is_smoothed() => Mode::Smoothed,
        (Kind::Interval, _) if unit.mu - f[0].abs() > near => Mode::Holding,
        (Kind::Interval, _) if y[0].abs() > near => Mode::Yielding,
        (Kind::Interval, _) => Mode::Impending,
        _ if f[0] <= near => {
            if y[0] <= near {
                Mode::Touching
            } else {
                Mode::Separated
            }
        }
        (Kind::Ray, _) => Mode::Pressing,
        _ if across(y) > near || unit.mu == 0.0 => Mode::Sliding,
        _ if slack <= near => Mode::Impending,
        _ => Mode::Sticking,
    }
}

/// The mode of a moment, with its bound.
fn mode_of_moment(unit: &Unit, [f, y]: [[f64; 3]; 2], near: f64) -> Mode {
    if unit.mu <= near {
        Mode::Separated
    } else if unit.mu - length(f) > near {
        Mode::Holding
    } else if length(y) > near {
        Mode::Yielding
    } else {
        Mode::Impending
    }
}

/// Measures the forces of a system; its velocities have to be up to date.
pub(super) fn measure(newton: &Newton) -> Certificate {
    let size = newton.size();
    let mut worst = Certificate::default();
    if size == 0.0 {
        return worst;
    }
    for (unit, own) in newton.system.units.iter().zip(&newton.equations) {
        let (f, y) = (of_unit(&newton.f, unit), of_unit(&newton.y, unit));
        let smoothed = own.piece.is_smoothed();
        let of_unit = match unit.kind {
            Kind::Row => of_row(y[0], size),
            _ if smoothed => of_path(newton, unit, own, size),
            Kind::Ray => of_cone(f, y, 0.0, size),
            Kind::Interval => of_interval(f[0], y[0], unit.mu, size),
            Kind::Cone => of_cone(f, corrected(newton.system.law, unit.mu, y), unit.mu, size),
            Kind::Spin | Kind::Roll => {
                let bounded = newton.system.bounded(unit, &newton.f);
                of_moment(f, y, bounded.map_or(0.0, |unit| unit.mu), size)
            }
        };
        worst = worst.worse(of_unit);
    }
    worst
}

fn of_row(y: f64, size: f64) -> Certificate {
    let violation = y.abs() / size;
    Certificate {
        residual: violation,
        dual_violation: violation,
        ..Certificate::default()
    }
}

fn of_interval(f: f64, y: f64, bound: f64, size: f64) -> Certificate {
    // Velocities against the force are allowed at the bound that it has reached.
    let room = if y > 0.0 { bound + f } else { bound - f };
    Certificate {
        residual: (f - clamped(f - y, bound)).abs() / size,
        cone_violation: (f - clamped(f, bound)).abs() / size,
        complementarity: (room * y).abs() / (size * size),
        ..Certificate::default()
    }
}

fn of_moment(f: [f64; 3], y: [f64; 3], bound: f64, size: f64) -> Certificate {
    let a = [f[0] - y[0], f[1] - y[1], 0.0];
    Certificate {
        residual: distance(f, shortened(a, bound)) / size,
        cone_violation: distance(f, shortened(f, bound)) / size,
        complementarity: ((bound * length(y) + f[0] * y[0] + f[1] * y[1]) / (size * size)).abs(),
        ..Certificate::default()
    }
}

/// De Saxcé's correction:  ŷ = y + μ ‖yₜ‖ eₙ.
fn corrected(law: Law, mu: f64, y: [f64; 3]) -> [f64; 3] {
    match law {
        Law::Convex => y,
        Law::Coulomb => [y[0] + mu * across(y), y[1], y[2]],
    }
}

fn of_cone(f: [f64; 3], y: [f64; 3], mu: f64, size: f64) -> Certificate {
    let a = [f[0] - y[0], f[1] - y[1], f[2] - y[2]];
    // By Moreau, the distance of y from the dual cone is the length of the projection of −y on the cone.
    let outside = project(y.map_each(|y| -y), mu);
    Certificate {
        residual: distance(f, project(a, mu)) / size,
        cone_violation: distance(f, project(f, mu)) / size,
        complementarity: (f[0] * y[0] + f[1] * y[1] + f[2] * y[2]).abs() / (size * size),
        dual_violation: distance(outside, [0.0; 3]) / size,
        ..Certificate::default()
    }
}

fn of_path(newton: &Newton, unit: &Unit, own: &UnitEquations, size: f64) -> Certificate {
    let UnitState { f, y } = UnitState::of(unit, &newton.f, &newton.y);
    let product = match newton.system.law {
        Law::Coulomb => f[0] * y[0],
        Law::Convex => f[0] * y[0] + f[1] * y[1] + f[2] * y[2],
    };
    let e = own
        .e
        .iter()
        .fold(0.0, |largest: f64, e| largest.max(e.abs()));
    if unit.kind == Kind::Interval {
        return Certificate {
            residual: e / size,
            cone_violation: (f[0] - clamped(f[0], unit.mu)).abs() / size,
            ..Certificate::default()
        };
    }
    Certificate {
        residual: e / size,
        cone_violation: distance(f, project(f, unit.mu)) / size,
        complementarity: (product - newton.kappa).abs() / (size * size),
        ..Certificate::default()
    }
}

/// The nearest point of the cone.
pub(super) fn project(a: [f64; 3], mu: f64) -> [f64; 3] {
    let l = across(a);
    if a[0] >= 0.0 && l <= mu * a[0] {
        return a;
    }
    let p = (a[0] + mu * l) / (1.0 + mu * mu);
    if p <= 0.0 {
        return [0.0; 3];
    }
    let along = mu * p / l.max(f64::MIN_POSITIVE);
    [p, along * a[1], along * a[2]]
}

/// The nearest moment within a bound.
pub(super) fn shortened(f: [f64; 3], bound: f64) -> [f64; 3] {
    let size = length(f);
    if size <= bound {
        return f;
    }
    f.map_each(|x| x * (bound / size))
}

/// The length of a moment.
fn length(f: [f64; 3]) -> f64 {
    f[0].hypot(f[1])
}

/// The length of the part across the normal.
fn across(x: [f64; 3]) -> f64 {
    (x[1] * x[1] + x[2] * x[2]).sqrt()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
}
