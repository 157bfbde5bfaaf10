//! `dualbody info`: what a robot is made of.

use std::error::Error;
use std::fmt::Write;

use clap::Args;
use serde::Serialize;

use super::contents::Contents;
use super::output::{Outcome, heading};
use super::robot::Robot;
use crate::model::{Limits, Model};

/// Show the tree of a robot, its masses and the limits of its joints, and the actuators, sensors, keyframes, equalities and contact shapes of its file.
#[derive(Args, Debug)]
pub(super) struct Info {
    #[command(flatten)]
    robot: Robot,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// JSON content for a robot.
#[derive(Serialize)]
struct Summary<'m> {
    name: &'m str,
    base: &'static str,
    nq: usize,
    nv: usize,
    /// kg
    total_mass: f64,
    /// m/s²
    gravity: [f64; 3],
    joints: Vec<JointSummary<'m>>,
    links: Vec<LinkSummary<'m>>,
    #[serde(flatten)]
    contents: Contents,
}

#[derive(Serialize)]
struct JointSummary<'m> {
    name: &'m str,
    kind: String,
    /// First entry and number of entries in q and in v.
    q: [usize; 2],
    v: [usize; 2],
    lower: Option<f64>,
    upper: Option<f64>,
    velocity: Option<f64>,
    effort: Option<f64>,
}

#[derive(Serialize)]
struct LinkSummary<'m> {
    name: &'m str,
    /// kg
    mass: f64,
    /// Centre of mass in the link, m; of a link without mass there is none.
    center_of_mass: Option<[f64; 3]>,
}

impl Info {
    pub(super) fn run(self) -> Result<Outcome, Box<dyn Error>> {
        let loaded = self.robot.load()?;
        let contents = Contents::of(&loaded);
        Ok(match self.json {
            true => Outcome::of(serde_json::to_string_pretty(&summary(
                &loaded.model,
                contents,
            ))?),
            false => Outcome::of(text(&loaded.model) + &contents.text()),
        })
    }
}

fn summary(model: &Model, contents: Contents) -> Summary<'_> {
    let inertias = model.link_inertias();
    let links = model.link_names().into_iter().zip(&inertias);
    Summary {
        name: model.name(),
        base: if model.has_floating_base() {
            "floating"
        } else {
            "fixed"
        },
        nq: model.nq(),
        nv: model.nv(),
        total_mass: model.total_mass(),
        gravity: (*model.gravity()).into(),
        joints: joints(model).collect(),
        links: links
            .map(|(name, inertia)| LinkSummary {
                name,
                mass: inertia.mass,
                center_of_mass: (inertia.mass != 0.0).then(|| inertia.com().into()),
            })
            .collect(),
        contents,
    }
}

fn joints(model: &Model) -> impl Iterator<Item = JointSummary<'_>> {
    model.joint_names().into_iter().filter_map(|name| {
        let id = model.joint(name)?;
        let Limits {
            lower,
            upper,
            velocity,
            effort,
        } = *model.limits(id);
        let body = model.body(model.joint_body(id));
        let (q, v) = (model.joint_q(id), model.joint_v(id));
        Some(JointSummary {
            name,
            kind: body.joint.to_string(),
            q: [q.start, q.len()],
            v: [v.start, v.len()],
            lower,
            upper,
            velocity,
            effort,
        })
    })
}

/// The tree, then a line for each joint.
fn text(model: &Model) -> String {
    let mut out = format!("{}\n\n", model.tree());
    let joints: Vec<_> = joints(model).collect();
    let width = joints
        .iter()
        .map(|own| own.name.chars().count())
        .max()
        .unwrap_or(0)
        .max("joint".len());
    let title = format!(
        "{:width$}  {:12}  {:>9}  {:>9}  {:>9}  {:>9}",
        "joint", "kind", "lower", "upper", "velocity", "effort"
    );
    // Writing to a string does not fail.
    let _ = writeln!(out, "{}", heading(title));
    for own in joints {
        let JointSummary { name, kind, .. } = &own;
        let [lower, upper, velocity, effort] =
            [own.lower, own.upper, own.velocity, own.effort].map(number);
        let _ = writeln!(
            out,
            "{name:width$}  {kind:12}  {lower:>9}  {upper:>9}  {velocity:>9}  {effort:>9}"
        );
    }
    out
}

/// A limit in four digits; a dash where there is none.
fn number(limit: Option<f64>) -> String {
    limit.map_or("–".into(), |x| format!("{}", (1e4 * x).round() / 1e4))
}
