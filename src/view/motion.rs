//! Motion in the HTML viewer: poses, plots and forces, at the time resolution of a screen.

use std::iter;

use serde::Serialize;

use super::blob::Blob;
use super::recording::Recording;
use super::shape::pose;
use super::touches::{self, ShownTouches};
use super::track::Track;
use crate::dynamics::{
    Kinematics, elastic_energy, forward_kinematics_into, kinetic_energy_at, potential_energy_at,
};
use crate::joint::{Axis, Coordinate, Joint, JointKind};
use crate::model::BodyId;
use crate::nested::IntoNested;
use crate::sim::column_names;
use crate::spatial::Transform;

/// Pictures a second of a screen: more moments are not kept.
const MAX_RATE: f64 = 60.0;

/// Bytes that all moments of an HTML viewer may take before base64, which makes three to four: an hour of a cart-pole at the full rate, an
/// hour of a humanoid at ten pictures a second, between which the HTML viewer interpolates.
const MAX_BYTES: usize = 32 << 20;

/// All that moves.
#[derive(Debug, Serialize)]
pub(super) struct Motion {
    times: Blob,
    robots: Vec<RobotMotion>,
    series: Vec<Plot>,
    /// Times in the recording, of which `times` are a part.
    recorded: usize,
}

#[derive(Debug, Serialize)]
struct RobotMotion {
    /// Positions of each body at each time, x, y, z.
    positions: Blob,
    /// Quaternions, w first.
    rotations: Blob,
    plots: Vec<Plot>,
    forces: Vec<Force>,
    #[serde(skip_serializing_if = "Option::is_none")]
    contacts: Option<ShownTouches>,
}

/// Lines over time that have one unit.
#[derive(Debug, Serialize)]
struct Plot {
    title: String,
    unit: String,
    lines: Vec<Line>,
}

#[derive(Debug, Serialize)]
struct Line {
    name: String,
    values: Blob,
}

#[derive(Debug, Serialize)]
struct Force {
    frame: usize,
    /// x, y, z along the axes of the world, N.
    values: Blob,
}

pub(super) fn motion(recording: &Recording) -> Motion {
    let kept = kept(&recording.times, bytes_per_moment(recording));
    Motion {
        times: Blob::f64(kept.iter().map(|&k| recording.times[k])),
        robots: recording
            .robots
            .iter()
            .map(|track| robot(track, &kept))
            .collect(),
        series: series(recording, &kept),
        recorded: recording.len(),
    }
}

fn bytes_per_moment(recording: &Recording) -> usize {
    let robots = recording.robots.iter().map(|track| {
        let (bodies, numbers) = (track.model.n_bodies(), track.column_names().len());
        20 * bodies + 4 * (numbers + 3) + 24 * touches::most(&track.touches)
    });
    8 + robots.sum::<usize>() + 4 * recording.series.len()
}

/// The times to keep: the first, the last, and between them as many as the rate and the size allow.
pub(super) fn kept(times: &[f64], bytes_per_moment: usize) -> Vec<usize> {
    /// Steps that should just fit are not to be dropped for their rounding.
    const ROUNDING: f64 = 1e-6;
    let (Some(first), Some(last)) = (times.first(), times.last()) else {
        return Vec::new();
    };
    let most = (MAX_BYTES / bytes_per_moment).max(2);
    let interval = (1.0 / MAX_RATE).max((last - first) / (most - 1) as f64) * (1.0 - ROUNDING);
    let (mut kept, mut next) = (vec![0], first + interval);
    for k in 1..times.len() {
        if times[k] >= next || k + 1 == times.len() {
            kept.push(k);
            next = times[k] + interval;
        }
    }
    kept
}

fn robot(track: &Track, kept: &[usize]) -> RobotMotion {
    let (mut positions, mut rotations) = (Vec::new(), Vec::new());
    let mut energies = [const { Vec::new() }; 3];
    let mut kinematics = Kinematics::new(&track.model);
    // A robot with unknown state keeps its last known state; without one it is drawn at its neutral configuration.
    let still = vec![0.0; track.model.nv()];
    let neutral = track.model.neutral();
    forward_kinematics_into(&track.model, neutral.as_slice(), &still, &mut kinematics);
    for &k in kept {
        let (q, v) = (track.q(k), track.v(k));
        let is_known = q.iter().chain(v).all(|x| x.is_finite());
        if is_known {
            forward_kinematics_into(&track.model, q, v, &mut kinematics);
        }
        for body in 0..track.model.n_bodies() {
            let pose = pose(&kinematics.pose(Some(BodyId(body))));
            positions.extend_from_slice(&pose[..3]);
            rotations.extend_from_slice(&pose[3..]);
        }
        let energy = if is_known {
            energy(track, &kinematics, q, v)
        } else {
            [f64::NAN; 3]
        };
        energies
            .iter_mut()
            .zip(energy)
            .for_each(|(all, x)| all.push(x));
    }
    let mut plots = plots(track, kept);
    let names = ["kinetic", "potential", "total"].into_iter();
    plots.push(Plot {
        title: "Energy".into(),
        unit: "J".into(),
        lines: names.zip(energies).map(|(name, x)| line(name, x)).collect(),
    });
    RobotMotion {
        positions: Blob::f32(positions),
        rotations: Blob::unit(rotations),
        plots,
        forces: forces(track, kept),
        contacts: touches::shown(&track.touches, kept),
    }
}

/// Passes the pose of each body at some times to a function; unknown poses are skipped.
pub(super) fn each_pose(track: &Track, moments: &[usize], mut each: impl FnMut(&Transform<f64>)) {
    let mut kinematics = Kinematics::new(&track.model);
    for &k in moments {
        let (q, v) = (track.q(k), track.v(k));
        if q.iter().chain(v).all(|x| x.is_finite()) {
            forward_kinematics_into(&track.model, q, v, &mut kinematics);
            let bodies = (0..track.model.n_bodies()).map(BodyId);
            bodies.for_each(|body| each(&kinematics.pose(Some(body))));
        }
    }
}

/// Kinetic, potential (of gravity and springs), total.
fn energy(track: &Track, kinematics: &Kinematics<f64>, q: &[f64], v: &[f64]) -> [f64; 3] {
    let kinetic = kinetic_energy_at(&track.model, kinematics, v);
    let potential = potential_energy_at(&track.model, kinematics) + elastic_energy(&track.model, q);
    [kinetic, potential, kinetic + potential]
}

fn line(name: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Line {
    Line {
        name: name.into(),
        values: Blob::f32(values),
    }
}

fn forces(track: &Track, kept: &[usize]) -> Vec<Force> {
    let forces = track.forces.iter().map(|force| Force {
        frame: force.frame.0,
        values: Blob::f32(kept.iter().nested(|&k| force.values[k].iter().copied())),
    });
    forces.collect()
}

/// q, v and u, each split by units.
fn plots(track: &Track, kept: &[usize]) -> Vec<Plot> {
    let model = &track.model;
    let (mut plots, names) = (Vec::new(), column_names(model));
    let independent = || model.independent().map(|body| body.joint);
    let of_q = independent().nested(units_of_q);
    let of_v = independent().nested(|kind| kind.axes().map(unit_of_v));
    let (q, v) = names.split_at(model.nq());
    let of_u = iter::repeat(("Input", "N, N·m"));
    let u: Vec<_> = (0..track.nu()).map(|k| track.input_name(k)).collect();
    let q = q.iter().zip(of_q).zip((0..).map(|j| (&track.q, j)));
    let v = v.iter().zip(of_v).zip((0..).map(|j| (&track.v, j)));
    let without_kind = |name: &'_ String| name[2..].to_owned();
    let states = q
        .chain(v)
        .map(|((name, of), at)| ((without_kind(name), of), at));
    let u = u.into_iter().zip(of_u).zip((0..).map(|j| (&track.u, j)));
    for ((name, (title, unit)), (rows, j)) in states.chain(u) {
        let values = kept.iter().map(|&k| rows.row(k)[j]);
        add(&mut plots, title, unit, line(name, values));
    }
    plots
}

/// Adds a line to the plot of its title and unit.
fn add(plots: &mut Vec<Plot>, title: &str, unit: &str, line: Line) {
    let fits = |plot: &&mut Plot| plot.title == title && plot.unit == unit;
    match plots.iter_mut().find(fits) {
        Some(plot) => plot.lines.push(line),
        None => plots.push(Plot {
            title: title.into(),
            unit: unit.into(),
            lines: vec![line],
        }),
    }
}

/// Titles and units of the numbers of q of a joint.
fn units_of_q(kind: JointKind) -> impl Iterator<Item = (&'static str, &'static str)> {
    (0..kind.nq()).map(move |k| match kind.measures(k) {
        Coordinate::Length => ("Position", "m"),
        Coordinate::Angle => ("Angle", "rad"),
        Coordinate::Quaternion => ("Quaternion", ""),
    })
}

fn unit_of_v(axis: Axis) -> (&'static str, &'static str) {
    if axis.is_angular() {
        ("Angular velocity", "rad/s")
    } else {
        ("Velocity", "m/s")
    }
}

/// Series of the same unit share a plot; one without a unit has its own.
fn series(recording: &Recording, kept: &[usize]) -> Vec<Plot> {
    let mut plots = Vec::new();
    for series in &recording.series {
        let values = kept.iter().map(|&k| series.values[k]);
        match unit_at_end(&series.name) {
            Some((name, unit)) => add(&mut plots, "Series", unit, line(name, values)),
            None => add(&mut plots, &series.name, "", line(&series.name, values)),
        }
    }
    plots
}

/// `height [m]` is `height` and `m`.
fn unit_at_end(name: &str) -> Option<(&str, &str)> {
    name.strip_suffix(']')?.rsplit_once(" [")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_kept_of_an_hour_equal_rate_and_size_of_the_page() {
        let times: Vec<f64> = (0..=3_600_000).map(|k| 1e-3 * f64::from(k)).collect();
        for (bytes, rate) in [(92, 1000.0 / 17.0), (1000, 9.3)] {
            let kept = kept(&times, bytes);
            assert!(
                (kept.len() as f64 / 3600.0 - rate).abs() < 0.1,
                "{}",
                kept.len()
            );
            assert!(kept.len() * bytes <= MAX_BYTES);
            assert_eq!((kept[0], kept[kept.len() - 1]), (0, 3_600_000));
        }
    }

    #[test]
    fn moments_kept_of_a_short_motion_equal_those_that_were_recorded() {
        let at = |rate: f64| {
            (0..100)
                .map(move |k| f64::from(k) / rate)
                .collect::<Vec<_>>()
        };
        assert_eq!(kept(&at(60.0), 100).len(), 100);
        assert_eq!(kept(&at(10.0), 100).len(), 100);
        assert_eq!(kept(&at(120.0), 100).len(), 51);
        assert_eq!((kept(&[], 9), kept(&[1.0], 9)), (vec![], vec![0]));
    }
}
