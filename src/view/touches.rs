//! Points at which something touches, with the forces there, over a recording.

use serde::{Deserialize, Serialize};

use super::blob::Blob;
use super::motion::kept;
use super::track::Track;
use crate::sim::{ContactReport, Simulator};

/// Position and force of a point, x, y, z each, in the world, m and N. Of a point between two bodies there are two, with opposite forces.
type Touch = [f64; 6];

/// The points that touch from a moment on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Touches {
    /// Index of the time.
    pub(super) moment: usize,
    pub(super) points: Vec<Touch>,
}

/// Points for the page: those of each moment, one after the other.
#[derive(Debug, Serialize)]
pub(super) struct ShownTouches {
    counts: Blob,
    values: Blob,
}

/// Finds what touches a robot at the moments that a page can show, under the recorded inputs. Moments at which a number is unknown are left out.
pub(super) fn find(track: &Track, times: &[f64], simulator: &Simulator) -> Vec<Touches> {
    // Of one byte a moment the rate alone decides.
    let moments = kept(times, 1).into_iter();
    let known = moments.filter(|&k| {
        let numbers = track.q(k).iter().chain(track.v(k)).chain(track.u(k));
        track.u(k).len() == simulator.nu() && numbers.into_iter().all(|x| x.is_finite())
    });
    known
        .map(|moment| {
            let report = simulator.contact_report(&track.state(moment), track.u(moment));
            let points = of_report(&report);
            Touches { moment, points }
        })
        .collect()
}

fn of_report(report: &ContactReport) -> Vec<Touch> {
    let ground = report.points.iter().zip(&report.forces);
    let ground = ground.map(|(point, force)| (point.position, *force));
    let pairs = report.pairs.iter().flat_map(|pair| {
        let at = pair.point.position;
        [(at, pair.force), (at, -pair.force)]
    });
    let touching = ground.chain(pairs).filter(|(_, f)| f.norm() > 0.0);
    touching
        .map(|(p, f)| [p.x, p.y, p.z, f.x, f.y, f.z])
        .collect()
}

/// The largest number of points at a moment.
pub(super) fn most(all: &[Touches]) -> usize {
    all.iter().map(|at| at.points.len()).max().unwrap_or(0)
}

/// Those of the moments that a page keeps: of each the last ones that are known.
pub(super) fn shown(all: &[Touches], kept: &[usize]) -> Option<ShownTouches> {
    if all.is_empty() {
        return None;
    }
    let at = |k: &usize| {
        let after = all.partition_point(|at| at.moment <= *k);
        after.checked_sub(1).map_or(&[][..], |i| &all[i].points)
    };
    let rows = || kept.iter().map(at);
    Some(ShownTouches {
        counts: Blob::u32(rows().map(|points| points.len() as u32)),
        values: Blob::f32(rows().flatten().flatten().copied()),
    })
}
