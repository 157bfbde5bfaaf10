//! Where the search for an equilibrium begins: a pose on the ground, with the forces of statics.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::contact::{ContactLaw, Contacts, PointState};
use crate::dynamics::gravity_forces;
use crate::model::Model;
use crate::sim::{Simulator, State};

/// Distance from the ground up to which a point of a robot that has been put down is taken to carry it, m.
const NEAR: f64 = 1e-2;
/// Depth of a point without a spring, m: so little that it touches.
const TOUCHING: f64 = 1e-6;
/// Steps of Newton's method on the depths of points.
const MOVES: usize = 8;
/// Singular values that count as zero, beside the largest.
const SINGULAR: f64 = 1e-9;
/// What a force along the normal may be beside a torque, N per N·m, as it costs nothing.
const NORMAL: f64 = 10.0;
/// What friction may be beside a torque, N per N·m: what need not be is not.
const TANGENT: f64 = 0.3;

/// Puts a floating robot on the ground, with the input and the deflections of bristles that would hold it if it were rigid; others stay as they are.
pub(super) fn begin(simulator: &Simulator, state: &mut State, u: &mut DVector<f64>) {
    let (model, contacts) = (simulator.model(), simulator.contacts());
    let Some(contacts) = contacts.filter(|_| model.has_floating_base()) else {
        return;
    };
    if !state.is_finite() || !put_down(model, contacts, state) {
        return;
    }
    let mut carrying = carrying(model, contacts, state);
    let forces = loop {
        let (input, forces) = statics(simulator, contacts, state, &carrying);
        let pulled = forces.iter().position(|(_, along)| *along < 0.0);
        match pulled {
            Some(k) if carrying.len() > 1 => drop(carrying.remove(k)),
            _ => {
                u.copy_from(&input);
                break forces;
            }
        }
    };
    let laws = contacts.laws();
    let depths = carrying
        .iter()
        .zip(&forces)
        .map(|(&k, &(_, along))| depth_under(&laws[k], along));
    sink(
        model,
        contacts,
        state,
        &carrying,
        &depths.collect::<Vec<_>>(),
    );
    if simulator.n_contact() == 0 {
        return;
    }
    for (&k, (force, along)) in carrying.iter().zip(&forces) {
        let ContactLaw::Soft(soft) = &laws[k] else {
            continue;
        };
        let depth = depth_under(&laws[k], *along);
        let spring = soft.normal.force(depth, 0.0) / depth;
        let normal = states(model, contacts, state)[k].normal;
        let across = force - normal * normal.dot(force);
        let bent = if spring > 0.0 {
            -across / spring
        } else {
            Vector3::zeros()
        };
        state.contact.fixed_rows_mut::<3>(3 * k).copy_from(&bent);
    }
}

fn states(model: &Model, contacts: &Contacts, state: &State) -> Vec<PointState<f64>> {
    contacts.states(model, state.q.as_slice(), &vec![0.0; model.nv()])
}

/// Moves the robot along gravity until its first point touches; `false` if none ever does.
fn put_down(model: &Model, contacts: &Contacts, state: &mut State) -> bool {
    let Some(down) = model.gravity().try_normalize(0.0) else {
        return false;
    };
    let ways = states(model, contacts, state)
        .into_iter()
        .filter_map(|point| {
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

fn carrying(model: &Model, contacts: &Contacts, state: &State) -> Vec<usize> {
    let points = states(model, contacts, state).into_iter().enumerate();
    points
        .filter(|(_, point)| point.depth > -NEAR)
        .map(|(k, _)| k)
        .collect()
}

/// Input and forces of points, in the world and along the normal, that balance gravity: the least of them, weighted.
fn statics(
    simulator: &Simulator,
    contacts: &Contacts,
    state: &State,
    carrying: &[usize],
) -> (DVector<f64>, Vec<(Vector3<f64>, f64)>) {
    let (model, q) = (simulator.model(), state.q.as_slice());
    let (nu, points) = (simulator.nu(), states(model, contacts, state));
    let mut columns = DMatrix::zeros(model.nv(), nu + 3 * carrying.len());
    for (k, &coordinate) in simulator.actuated().iter().enumerate() {
        columns[(coordinate, k)] = 1.0;
    }
    let frames: Vec<_> = carrying
        .iter()
        .map(|&k| Matrix3::from_columns(&points[k].axes()) * scale())
        .collect();
    for (i, (&k, frame)) in carrying.iter().zip(&frames).enumerate() {
        let force = contacts.jacobian(model, q, k).tr_mul(frame);
        columns.columns_mut(nu + 3 * i, 3).copy_from(&force);
    }
    let least = least_norm(columns, &gravity_forces(model, q));
    let forces = frames.iter().enumerate().map(|(i, frame)| {
        let y = least.fixed_rows::<3>(nu + 3 * i);
        (frame * y, NORMAL * y[0])
    });
    (least.rows(0, nu).into_owned(), forces.collect())
}

/// Of forces along normal, tangent, tangent.
fn scale() -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(NORMAL, TANGENT, TANGENT))
}

/// The shortest x of least ‖A x − b‖; zero where the decomposition fails.
fn least_norm(a: DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let (n, steps) = (a.ncols(), 100 * (a.nrows() + a.ncols()));
    let svd = a.try_svd(true, true, f64::EPSILON, steps);
    let solved = svd.and_then(|svd| {
        let threshold = SINGULAR * svd.singular_values.amax();
        svd.solve(b, threshold).ok()
    });
    solved.unwrap_or_else(|| DVector::zeros(n))
}

/// Depth at which a law gives a force along the normal at rest, m.
fn depth_under(law: &ContactLaw, force: f64) -> f64 {
    match law {
        ContactLaw::Soft(soft) if soft.normal.stiffness > 0.0 => {
            let order = 1.0 + soft.normal.stiffness_exponent;
            (force.max(0.0) / soft.normal.stiffness)
                .powf(1.0 / order)
                .max(TOUCHING)
        }
        _ => TOUCHING,
    }
}

/// Moves joints and base, by as little as can be, until points are at depths.
fn sink(model: &Model, contacts: &Contacts, state: &mut State, carrying: &[usize], depths: &[f64]) {
    for _ in 0..MOVES {
        let points = states(model, contacts, state);
        let mut rates = DMatrix::zeros(carrying.len(), model.nv());
        for (i, &k) in carrying.iter().enumerate() {
            let jacobian = contacts.jacobian(model, state.q.as_slice(), k);
            rates.set_row(i, &-(points[k].normal.transpose() * jacobian));
        }
        let missing = carrying
            .iter()
            .zip(depths)
            .map(|(&k, depth)| depth - points[k].depth);
        let missing = DVector::from_iterator(carrying.len(), missing);
        let dq = least_norm(rates, &missing);
        state.q = model.integrate(state.q.as_slice(), dq.as_slice());
    }
}
