//! Initial pose of the search for an equilibrium: on the ground, with the forces of statics.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::contact::{ContactLaw, Contacts, PointState};
use crate::dynamics::gravity_forces;
use crate::linalg::svd;
use crate::model::Model;
use crate::scalar::MapEach;
use crate::sim::{Simulator, State};
use crate::spatial::Representation;

/// Distance from the ground up to which a point of a robot that has been put down is taken to carry it, m.
const NEAR: f64 = 1e-2;
/// Depth of a point without a spring, m: so little that it touches.
const TOUCHING: f64 = 1e-6;
/// Steps of Newton's method on the depths of points.
const MOVES: usize = 8;
/// Singular values that count as zero, beside the largest.
const SINGULAR: f64 = 1e-9;
/// Size of a force along the normal that counts as much as a torque of 1 N·m, N: large, as the ground gives it for nothing.
const NORMAL: f64 = 10.0;
/// Size of friction that counts as much as a torque of 1 N·m, N: small, so that there is no friction without need.
const TANGENT: f64 = 0.3;

/// Load of a contact point by statics.
struct Load {
    /// Number of the point.
    point: usize,
    /// Force along the normal, N; a negative one pulls.
    normal: f64,
    /// Friction in the world, N.
    friction: Vector3<f64>,
}

/// Moves a floating robot to the ground, with the input and the deflections of bristles that hold it as a rigid body; other robots are unchanged.
pub(super) fn begin(simulator: &Simulator, state: &mut State, u: &mut DVector<f64>) {
    let (model, contacts) = (simulator.model(), simulator.contacts());
    let Some(contacts) = contacts.filter(|_| model.has_floating_base()) else {
        return;
    };
    if !state.is_finite() || !put_down(model, contacts, state) {
        return;
    }
    let loads;
    (*u, loads) = carried(simulator, contacts, state);
    sink(model, contacts, state, &loads);
    if simulator.n_contact() > 0 {
        bend(contacts, &loads, state);
    }
}

/// Points at rest.
fn points(model: &Model, contacts: &Contacts, state: &State) -> Vec<PointState<f64>> {
    contacts.states(model, state.q.as_slice(), &vec![0.0; model.nv()])
}

/// Numbers of the points that are near the ground or in it.
pub(super) fn near_the_ground(model: &Model, contacts: &Contacts, state: &State) -> Vec<usize> {
    let points = points(model, contacts, state);
    let near = |k: &usize| points[*k].depth > -NEAR;
    (0..points.len()).filter(near).collect()
}

/// Moves the robot along gravity until its first point touches; `false` if none ever does.
fn put_down(model: &Model, contacts: &Contacts, state: &mut State) -> bool {
    let Some(down) = model.gravity().try_normalize(0.0) else {
        return false;
    };
    let ways = points(model, contacts, state);
    let ways = ways.iter().filter_map(|point| {
        let rate = -point.normal.dot(&down);
        (rate > 0.0).then_some(-point.depth / rate)
    });
    let Some(way) = ways.reduce(f64::min).filter(|way| way.is_finite()) else {
        return false;
    };
    for (q, along) in state.q.iter_mut().zip(&down) {
        *q += way * along;
    }
    true
}

/// Input and loads that balance gravity, of points near the ground, without those that would have to pull.
fn carried(simulator: &Simulator, contacts: &Contacts, state: &State) -> (DVector<f64>, Vec<Load>) {
    let (model, q) = (simulator.model(), state.q.as_slice());
    let points = points(model, contacts, state);
    let jacobians = contacts.frame_jacobians(model, q, Representation::Mixed);
    let mut carrying = near_the_ground(model, contacts, state);
    loop {
        let all = carrying.iter();
        let all: Vec<_> = all.map(|&k| (k, &points[k], &jacobians[k])).collect();
        let (input, loads) = statics(simulator, q, &all);
        match loads.iter().position(|load| load.normal < 0.0) {
            Some(k) if loads.len() > 1 => drop(carrying.remove(k)),
            _ => return (input, loads),
        }
    }
}

/// Input and loads of points that balance gravity: the least of them, weighted.
///
/// * `carrying` – number, state and Jacobian of each point
fn statics(
    simulator: &Simulator,
    q: &[f64],
    carrying: &[(usize, &PointState<f64>, &DMatrix<f64>)],
) -> (DVector<f64>, Vec<Load>) {
    let (model, nu) = (simulator.model(), simulator.nu());
    let mut columns = DMatrix::zeros(model.nv(), nu + 3 * carrying.len());
    for (k, &coordinate) in simulator.actuated().iter().enumerate() {
        columns[(coordinate, k)] = 1.0;
    }
    let frame = |point: &PointState<f64>| Matrix3::from_columns(&point.axes()) * scale();
    for (i, (_, point, jacobian)) in carrying.iter().enumerate() {
        let force = jacobian.rows(0, 3).tr_mul(&frame(point));
        columns.columns_mut(nu + 3 * i, 3).copy_from(&force);
    }
    let least = least_norm(columns, &gravity_forces(model, q));
    let loads = carrying.iter().enumerate().map(|(i, &(k, point, _))| {
        let [y_n, y_1, y_2] = [0, 1, 2].map_each(|axis| least[nu + 3 * i + axis]);
        Load {
            point: k,
            normal: NORMAL * y_n,
            friction: frame(point) * Vector3::new(0.0, y_1, y_2),
        }
    });
    (least.rows(0, nu).into_owned(), loads.collect())
}

/// Of forces along normal, tangent, tangent.
fn scale() -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(NORMAL, TANGENT, TANGENT))
}

/// The shortest x of least ‖A x − b‖; zero where the decomposition fails.
fn least_norm(a: DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let n = a.ncols();
    let solved = svd(a, [true, true]).and_then(|found| {
        let threshold = SINGULAR * found.singular_values.amax();
        found.solve(b, threshold).ok()
    });
    solved.unwrap_or_else(|| DVector::zeros(n))
}

/// Depth at which the law of a point gives its load, m.
fn depth_under(contacts: &Contacts, load: &Load) -> f64 {
    match &contacts.laws()[load.point] {
        ContactLaw::Soft(soft) if soft.normal.stiffness > 0.0 => {
            let order = 1.0 + soft.normal.stiffness_exponent;
            let ratio = load.normal.max(0.0) / soft.normal.stiffness;
            ratio.powf(1.0 / order).max(TOUCHING)
        }
        _ => TOUCHING,
    }
}

/// Moves joints and base, by as little as can be, until points are at the depths of their loads.
fn sink(model: &Model, contacts: &Contacts, state: &mut State, loads: &[Load]) {
    for _ in 0..MOVES {
        let points = points(model, contacts, state);
        let q = state.q.as_slice();
        let jacobians = contacts.frame_jacobians(model, q, Representation::Mixed);
        let mut rates = DMatrix::zeros(loads.len(), model.nv());
        let mut missing = DVector::zeros(loads.len());
        for (i, load) in loads.iter().enumerate() {
            let (point, jacobian) = (&points[load.point], &jacobians[load.point]);
            let rate = -(point.normal.transpose() * jacobian.rows(0, 3));
            rates.set_row(i, &rate);
            missing[i] = depth_under(contacts, load) - point.depth;
        }
        let dq = least_norm(rates, &missing);
        state.q = model.integrate(q, dq.as_slice());
    }
}

/// Bends the bristles of soft contact such that their springs give the friction of the loads.
fn bend(contacts: &Contacts, loads: &[Load], state: &mut State) {
    for load in loads {
        let ContactLaw::Soft(soft) = &contacts.laws()[load.point] else {
            continue;
        };
        let depth = depth_under(contacts, load);
        let spring = soft.normal.force(depth, 0.0) / depth;
        if spring > 0.0 {
            let mut bristle = state.contact.fixed_rows_mut::<3>(3 * load.point);
            bristle.copy_from(&(-load.friction / spring));
        }
    }
}
