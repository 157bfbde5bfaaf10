//! Forces of contact of states and of batches, and the Jacobians at the points between bodies.

use dualbody::cone::Mode;
use dualbody::contact::PointState;
use dualbody::model::FrameId;
use dualbody::sim::{ContactReason, ContactReport, PairReport};
use nalgebra::Vector3;
use numpy::PyUntypedArray;
use rayon::prelude::*;

use crate::prelude::*;

/// Numbers of a link: the force on it, and whether it is in contact.
const LINK: usize = 7;
/// Numbers of a point between links: their indices, position, rotation of its frame, velocity, force, depth, and whether it is in contact.
const POINT: usize = 22;
/// Numbers of a point for its Jacobian: the indices of the links, and its position.
const PLACE: usize = 5;

methods! { PySimulator {
    /// Forces on links (..., n_links, 7), on the points with the ground (..., n, 3), and the points between links (..., m, 22), of which those that a state has fewer than others
    /// have the links -1.
    fn _contact_forces(&self, q, v, u: Option<&Bound<'py, PyAny>>, contact: Option<&Bound<'py, PyAny>>) -> PyResult<[Array<'py>; 3]> {
        let py = q.py();
        let given = self.read(q, v, u, contact)?;
        let (states, inputs) = self.states_and_inputs(&given)?;
        let simulator = &*self.simulator;
        let reports = on_pool(py, || reports(simulator, &states, &inputs))?;
        let most = reports.iter().map(|r| r.pairs.len()).max().unwrap_or(0);
        let (links, points) = (simulator.model().links().len(), simulator.contacts().map_or(0, |c| c.points().len()));
        let new = |tail: [usize; 2]| room(py, &[&given.batch[..], &tail].concat());
        let out = [new([links, LINK])?, new([points, 3])?, new([most, POINT])?];
        let [of_links, of_ground, of_pairs] = &out;
        let rows = numbers_mut(of_links).chunks_mut((links * LINK).max(1));
        rows.zip(&reports).for_each(|(out, r)| write_links(r, out));
        let rows = numbers_mut(of_ground).chunks_mut((points * 3).max(1));
        let forces = |report: &ContactReport, out: &mut [f64]| {
            let rows = out.chunks_mut(3).zip(&report.forces);
            rows.for_each(|(out, force)| out.copy_from_slice(force.as_slice()));
        };
        rows.zip(&reports).for_each(|(out, r)| forces(r, out));
        let index = indices_of_links(simulator.model());
        let rows = numbers_mut(of_pairs).chunks_mut((most * POINT).max(1));
        rows.zip(&reports).for_each(|(out, r)| write_pairs(r, &index, out));
        Ok(out)
    }

    /// Jacobians at points between links, or their rates, (..., m, 6, nv): points (..., m, 5) of links and position.
    fn _pair_jacobians(&self, q, v, points, are_rates: bool) -> PyResult<Array<'py>> {
        let model = self.simulator.model();
        let (nq, nv) = ([model.nq()], [model.nv()]);
        let points = numbers("points", points)?.into_any();
        let shape = points.cast::<PyUntypedArray>()?.shape();
        let places = [shape.iter().rev().nth(1).copied().unwrap_or(0), PLACE];
        let (tail, size) = ([places[0], 6, nv[0]], 6 * nv[0]);
        let arguments = [argument("q", q, &nq), argument("v", v, &nv), argument("points", &points, &places)];
        map_plain((model, self.id()), &arguments, &tail, &|x, out| {
            let (present, report) = report_of(model, x[2]);
            let matrices = match are_rates {
                false => report.pair_jacobians(model, x[0]),
                true => report.pair_jacobian_derivatives(model, x[0], x[1]),
            };
            out.fill(0.0);
            for (k, matrix) in present.into_iter().zip(matrices) {
                let own = &mut out[k * size..][..size];
                own.copy_from_slice(matrix.transpose().as_slice());
            }
        })
    }
} }

fn reports(simulator: &Simulator, states: &[State], inputs: &[f64]) -> Vec<ContactReport> {
    let nu = simulator.nu();
    let all = states.par_iter().enumerate();
    all.map(|(k, state)| simulator.contact_report(state, &inputs[k * nu..(k + 1) * nu]))
        .collect()
}

/// The index of each frame among the links, -1 for other frames.
fn indices_of_links(model: &Model) -> Vec<f64> {
    let mut out = vec![-1.0; model.frames().len()];
    for (k, link) in model.links().iter().enumerate() {
        out[link.frame.0] = k as f64;
    }
    out
}

fn write_links(report: &ContactReport, out: &mut [f64]) {
    let links = report.links.iter().zip(&report.touching);
    for (out, (force, &touching)) in out.chunks_mut(LINK).zip(links) {
        out[..6].copy_from_slice(&force.to_array());
        out[6] = f64::from(u8::from(touching));
    }
}

fn write_pairs(report: &ContactReport, index: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    for (k, out) in out.chunks_mut(POINT).enumerate() {
        let Some(pair) = report.pairs.get(k) else {
            out[..2].fill(-1.0);
            continue;
        };
        let frame = pair.frame();
        out[..2].copy_from_slice(&pair.links.map(|link| index[link.0]));
        out[2..5].copy_from_slice(frame.translation.as_slice());
        out[5..14].copy_from_slice(frame.rotation.transpose().as_slice());
        out[14..17].copy_from_slice(pair.point.velocity.as_slice());
        out[17..20].copy_from_slice(pair.force.as_slice());
        out[20] = pair.point.depth;
        out[21] = f64::from(u8::from(pair.is_touching()));
    }
}

/// The points of a row that there are, and a report that has them.
fn report_of(model: &Model, points: &[f64]) -> (Vec<usize>, ContactReport) {
    let links = model.links();
    let link = |x: f64| links.get(x as usize).filter(|_| x >= 0.0);
    let mut present = Vec::new();
    let mut report = ContactReport::default();
    for (k, place) in points.chunks(PLACE).enumerate() {
        if let (Some(first), Some(second)) = (link(place[0]), link(place[1])) {
            let position = Vector3::from_column_slice(&place[2..]);
            present.push(k);
            report.pairs.push(at([first.frame, second.frame], position));
        }
    }
    (present, report)
}

/// A point without force.
fn at(links: [FrameId; 2], position: Vector3<f64>) -> PairReport {
    PairReport {
        links,
        point: PointState {
            position,
            ..PointState::zero()
        },
        force: Vector3::zeros(),
        mode: Mode::Separated,
        reason: ContactReason::Touching,
    }
}
