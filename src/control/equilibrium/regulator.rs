//! A regulator about an equilibrium, including contact.

use std::fmt;

use nalgebra::{Complex, DMatrix, DVector, DVectorView};

use super::Equilibrium;
use crate::control::doubling::TimeDomain;
use crate::control::lqr::Lqr;
use crate::control::reachable_decomposition::{complement, reachable_basis};
use crate::control::stability;
use crate::linearize::Linearization;
use crate::model::Model;
use crate::sim::{Simulator, State};
use crate::sorting::sort_indices;
use crate::spatial::Representation;

/// A linear-quadratic regulator u = u₀ − K (q ⊖ q₀, v − v₀) about an [`Equilibrium`], for the part of the state that is reachable from the inputs.
///
/// Made by [`Equilibrium::lqr`]. The deflections of bristles are not states of the regulator: the bristle of a sticking point follows the motion of
/// the point, others are straight. Unreachable directions, such as feet on the ground, are dropped; see [`dropped`](Self::dropped).
#[derive(Clone, Debug, PartialEq)]
pub struct EquilibriumLqr {
    /// Equilibrium.
    pub at: Equilibrium,
    /// Gain K, nu × 2 nv, zero in dropped directions.
    pub gain: DMatrix<f64>,
    /// Regulator of the reachable part, with its status.
    pub lqr: Lqr,
    /// Orthonormal basis of the reachable part, 2 nv × its dimension.
    pub basis: DMatrix<f64>,
    /// Directions and bristles that are not regulated.
    pub dropped: Dropped,
}

/// Parts of the state that are not regulated, because they are unreachable from the inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Dropped {
    /// Contact points whose bristles follow the motion, by number.
    pub bristles: Vec<usize>,
    /// Orthonormal basis of the unreachable directions (δq, δv), one per column.
    pub directions: DMatrix<f64>,
    /// Name of the largest component of each direction, see [`Simulator::tangent_names`]; where several directions share it, up to four components with
    /// their sizes, as in `"0.71 q.hip - 0.70 q.knee"`.
    pub names: Vec<String>,
    /// Eigenvalues of the unreachable part, the least stable first: modulus 1 for a marginally stable mode, above 1 for an unstable one.
    pub eigenvalues: Vec<Complex<f64>>,
}

impl Equilibrium {
    /// Designs the regulator that minimises Σ δxᵀ Q δx + δuᵀ R δu about this equilibrium, δx = (δq, δv). Allocates.
    ///
    /// * `q` – weight on (δq, δv), 2 nv × 2 nv, symmetric positive semidefinite
    /// * `r` – weight on the input, nu × nu, symmetric positive definite
    ///
    /// # Limitations
    /// Contact is linearised at the equilibrium: points that lift off or slip are not modelled.
    ///
    /// # Panics
    /// If the simulator belongs to another robot, Q or R has the wrong shape, or no direction is reachable.
    ///
    /// # References
    /// [Van Dooren 1981] for the reachable part.
    pub fn lqr(&self, simulator: &Simulator, q: &DMatrix<f64>, r: &DMatrix<f64>) -> EquilibriumLqr {
        let n = 2 * simulator.model().nv();
        assert!(q.shape() == (n, n), "Q is {:?}, not {n} x {n}", q.shape());
        let step = simulator.linearize(&self.state, self.input.as_slice());
        let (bristles, follow) = followers(simulator, &self.state);
        let Linearization { a, b } = step;
        let (a, b) = (a.rows(0, n) * follow, b.rows(0, n).into_owned());
        let basis = reachable_basis(&a, &b);
        assert!(
            !basis.is_empty(),
            "no input reaches any part of the state: the simulator needs an actuated joint"
        );
        let outside = complement(&basis);
        let alone = outside.tr_mul(&a) * &outside;
        let reduced = |m: &DMatrix<f64>| basis.tr_mul(m) * &basis;
        let lqr = Lqr::discrete(&reduced(&a), &basis.tr_mul(&b), &reduced(q), r);
        EquilibriumLqr {
            at: self.clone(),
            gain: &lqr.gain * basis.transpose(),
            lqr,
            basis,
            dropped: Dropped {
                bristles,
                names: described(simulator, &outside),
                eigenvalues: stability::eigenvalues(TimeDomain::Discrete, &alone),
                directions: outside,
            },
        }
    }
}

impl EquilibriumLqr {
    /// Computes u = u₀ − K (q ⊖ q₀, v − v₀). Allocates.
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn control(&self, model: &Model, state: &State) -> DVector<f64> {
        let mut dx = state.deviation(model, &self.at.state);
        dx = dx.resize_vertically(self.gain.ncols(), 0.0);
        &self.at.input - &self.gain * dx
    }

    /// Whether the design succeeded and the unreachable part is not unstable. False if the eigenvalues of that part could not be computed.
    pub fn is_stabilized(&self) -> bool {
        let falls = |z: &Complex<f64>| z.norm() > 1.0 + BLUR;
        let Dropped {
            eigenvalues,
            directions,
            ..
        } = &self.dropped;
        let are_known = eigenvalues.len() == directions.ncols();
        self.lqr.is_stabilized() && are_known && !eigenvalues.iter().any(falls)
    }
}

/// Distance from the unit circle that rounding gives a chain of two equal eigenvalues, and some to spare.
const BLUR: f64 = 1e-6;

/// Points that touch, and the states (δq, δv, δm) in which their bristles bend as the points move along the ground, (2 nv + nm) × 2 nv.
fn followers(simulator: &Simulator, at: &State) -> (Vec<usize>, DMatrix<f64>) {
    let (model, nv) = (simulator.model(), simulator.model().nv());
    let mut out = DMatrix::identity(simulator.n_tangent(), 2 * nv);
    let Some(contacts) = simulator.contacts().filter(|_| simulator.n_contact() > 0) else {
        return (Vec::new(), out);
    };
    let q = at.q.as_slice();
    let points = contacts.states(model, q, at.v.as_slice());
    let jacobians = contacts.frame_jacobians(model, q, Representation::Mixed);
    let touching = |k: &usize| points[*k].depth > 0.0;
    let bristles: Vec<usize> = (0..points.len()).filter(touching).collect();
    for &k in &bristles {
        let (jacobian, normal) = (jacobians[k].rows(0, 3), points[k].normal);
        let across = jacobian - normal * (normal.transpose() * jacobian);
        out.view_mut((2 * nv + 3 * k, 0), (3, nv))
            .copy_from(&across);
    }
    (bristles, out)
}

/// Most components that the name of a direction has.
const MOST_NAMED: usize = 4;

/// Least component that it has beside the largest one, of a unit vector.
const LEAST_NAMED: f64 = 0.1;

/// Names of the largest components of directions; where that of one is that of another too, several components tell them apart.
fn described(simulator: &Simulator, directions: &DMatrix<f64>) -> Vec<String> {
    let names = simulator.tangent_names();
    let largest: Vec<usize> = directions.column_iter().map(|own| own.iamax()).collect();
    let mut count = vec![0; names.len()];
    largest.iter().for_each(|&k| count[k] += 1);
    let each = largest.iter().zip(directions.column_iter());
    let describe = |(&k, column): (&usize, _)| match count[k] {
        1 => names[k].clone(),
        _ => components(&names, column),
    };
    each.map(describe).collect()
}

/// Largest components of a direction with their names, the first one positive, since the sign of a direction is arbitrary.
fn components(names: &[String], direction: DVectorView<'_, f64>) -> String {
    let mut parts: Vec<usize> = (0..direction.len()).collect();
    sort_indices(&mut parts, &|i, j| {
        direction[j].abs().total_cmp(&direction[i].abs())
    });
    parts.truncate(MOST_NAMED);
    parts.retain(|&k| direction[k].abs() >= LEAST_NAMED);
    let sign = parts.first().map_or(1.0, |&k| direction[k].signum());
    let term = |(n, &k): (usize, &usize)| {
        let x = sign * direction[k];
        let before = match (n, x < 0.0) {
            (0, _) => "",
            (_, true) => " - ",
            (_, false) => " + ",
        };
        format!("{before}{:.2} {}", x.abs(), names[k])
    };
    parts.iter().enumerate().map(term).collect()
}

impl fmt::Display for Dropped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (bristles, directions) = (self.bristles.len(), self.names.len());
        write!(
            f,
            "{bristles} bristles follow their points; {directions} directions are out of reach"
        )?;
        for (k, name) in self.names.iter().enumerate() {
            write!(f, "{} {name}", if k == 0 { ":" } else { "," })?;
        }
        if let Some(worst) = self.eigenvalues.first() {
            write!(f, "; the least stable eigenvalue there is {worst:.6}")?;
        }
        Ok(())
    }
}
