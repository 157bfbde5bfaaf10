//! Meshes: a page and a hull of any content, or a warning.

use std::fs;
use std::path::Path;

use dualbody::Model;
use dualbody::contact::{ContactLaw, Contacts, SoftContact, Terrain};
use dualbody::view::model_page;

use super::{check_page, check_text};
use crate::input::{Case, Kind};

/// A robot for each format whose one link is a mesh file.
pub(super) struct Meshes(Vec<(Kind, Model)>);

impl Meshes {
    pub(super) fn new(folder: &Path) -> Self {
        let robot = |kind: Kind| (kind, robot(&file(folder, kind)));
        Self(
            [Kind::Stl, Kind::Obj, Kind::Dae, Kind::Msh]
                .map(robot)
                .into(),
        )
    }

    pub(super) fn check(&self, case: &Case, folder: &Path) -> Result<bool, String> {
        fs::write(file(folder, case.kind), &case.bytes).map_err(|error| error.to_string())?;
        let own = self.0.iter().find(|(kind, _)| *kind == case.kind);
        let (_, model) = own.ok_or("no mesh")?;
        let law = ContactLaw::Soft(SoftContact::estimate(1.0, 4, 1e-3));
        let contacts = Contacts::new(model, Terrain::flat(0.0), law);
        for shape in contacts.shapes_without_points() {
            check_text(&shape.reason)?;
        }
        let mut places = contacts.points().iter().map(|point| point.center);
        if places.any(|place| !place.iter().all(|x| x.is_finite())) {
            return Err("contact point that is not finite".into());
        }
        check_page(&model_page(model))?;
        Ok(contacts.shapes_without_points().is_empty())
    }
}

fn file(folder: &Path, kind: Kind) -> std::path::PathBuf {
    folder.join(format!("case.{}", kind.name()))
}

fn robot(file: &Path) -> Model {
    // A file must be there for its path to be remembered.
    fs::write(file, "").unwrap_or_else(|error| panic!("{error}"));
    let mesh = format!(
        "<geometry><mesh filename=\"{}\"/></geometry>",
        file.display()
    );
    let text = format!(
        "<robot name=\"mesh\"><link name=\"part\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" \
         izz=\"1\"/></inertial><visual>{mesh}</visual><collision>{mesh}</collision></link></robot>"
    );
    Model::from_urdf_str(&text).unwrap_or_else(|error| panic!("{error}"))
}
