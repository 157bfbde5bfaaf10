//! `dualbody convert`: a robot in another format.

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use clap::Args;

use super::output::{Outcome, complain, heading};
use super::robot::{Format, Robot};
use crate::io::MjcfScene;
use crate::nested::IntoNested;

/// Write a robot in another format, and list lost content.
///
/// URDF, SDF and MJCF are read; URDF and MJCF are written.
#[derive(Args, Debug)]
pub(super) struct Convert {
    #[command(flatten)]
    robot: Robot,
    /// The file to write, `-` for the standard output; its extension selects the format: .urdf, or .xml or .mjcf for MJCF.
    output: PathBuf,
    /// Format to write, if the extension does not select it.
    #[arg(long, value_name = "FORMAT")]
    to: Option<Format>,
}

impl Convert {
    pub(super) fn run(self) -> Result<Outcome, Box<dyn Error>> {
        let format = self.format()?;
        let loaded = self.robot.load()?;
        let text = match format {
            Format::Urdf => loaded.model.to_urdf()?,
            Format::Mjcf => loaded.model.to_mjcf()?,
            Format::Sdf => return Err("SDF is read, not written: choose urdf or mjcf".into()),
        };
        let ignored = loaded.report.ignored.iter().map(ToString::to_string);
        let beside = loaded.scene.iter().nested(beside_the_model);
        let lost = ignored.chain(left_out(&text)).chain(beside);
        let lost: Vec<String> = lost.collect();
        if self.output.as_os_str() == "-" {
            lost.iter().for_each(|loss| complain("warning", loss));
            return Ok(Outcome::of(text));
        }
        let path = self.output.display();
        fs::write(&self.output, text)
            .map_err(|error| format!("{path} cannot be written: {error}"))?;
        let mut out = format!("{}: {} lost\n", heading(path), lost.len());
        lost.iter().for_each(|loss| out += &format!("  {loss}\n"));
        Ok(Outcome::of(out))
    }

    fn format(&self) -> Result<Format, Box<dyn Error>> {
        let ending = self.output.extension().unwrap_or_default();
        let by_ending = match ending == "xml" {
            true => Some(Format::Mjcf),
            false => Format::by_ending(&self.output),
        };
        let unknown = || format!("{}: give the format with --to", self.output.display());
        Ok(self.to.or(by_ending).ok_or_else(unknown)?)
    }
}

/// Content of an MJCF file that its model does not contain, and so no file that is written of it.
fn beside_the_model(scene: &MjcfScene) -> impl Iterator<Item = String> {
    let contacts = &scene.contacts;
    let counts = [
        (usize::from(contacts.ground.is_some()), "ground"),
        (scene.actuation.len(), "actuators"),
        (scene.sensors.len(), "sensors"),
        (scene.constraints.len(), "equalities and springs of tendons"),
        (scene.tendons.len(), "fixed tendons"),
        (scene.keyframes.len(), "keyframes"),
        (contacts.geoms.len(), "contact parameters of geoms"),
        (contacts.pairs.len(), "contact pairs of geoms"),
        (contacts.excluded.len(), "pairs of bodies without contact"),
    ];
    let lost = counts.into_iter().filter(|(count, _)| *count > 0);
    lost.map(|(count, what)| format!("left out: {what} of the MJCF file: {count}"))
}

/// Comments of a written file on content that it cannot represent, with the name of the joint that follows.
fn left_out(text: &str) -> impl Iterator<Item = String> {
    let comments = text
        .split("<!--")
        .skip(1)
        .filter_map(|rest| rest.split_once("-->"));
    comments.filter_map(|(comment, after)| {
        let comment = comment.trim();
        let name = after
            .split_once("name=\"")
            .and_then(|(_, rest)| rest.split('"').next());
        let named = format!("of joint {}", name.unwrap_or_default());
        comment
            .starts_with("left out")
            .then(|| comment.replace("of the next joint", &named))
    })
}
