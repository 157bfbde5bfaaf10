//! Contact points with forces, over a recording.

use serde::{Deserialize, Serialize};

use super::blob::Blob;
use crate::nested::IntoNested;
use crate::sim::ContactReport;

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

/// Points for the viewer: those of each time, in sequence.
#[derive(Debug, Serialize)]
pub(super) struct ShownTouches {
    counts: Blob,
    values: Blob,
}

/// The points of a report at which a force acts.
pub(super) fn of_report(report: &ContactReport) -> Vec<Touch> {
    let ground = report.points.iter().zip(&report.forces);
    let ground = ground.map(|(point, force)| (point.position, *force));
    let pairs = report.pairs.iter().nested(|pair| {
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

/// Those of the times in the viewer: at each time the last known ones.
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
