//! `<compiler>`: units, folders, and what is made of inertias.

use super::defaults::Classes;
use super::entry::{Choice, Entry};
use super::tree::Node;
use crate::error::LoadError;
use crate::scalar::MapEach;

/// Settings of a description.
#[derive(Clone, Debug)]
pub(super) struct Compiler {
    /// Factor from the angles of the file to rad.
    pub(super) angle: f64,
    /// Axes of Euler angles; those in capitals are fixed.
    pub(super) eulerseq: [char; 3],
    pub(super) autolimits: bool,
    pub(super) meshdir: String,
    /// Whether a file is looked for by its name, without folders.
    pub(super) strippath: bool,
    pub(super) inertiafromgeom: Choice,
    /// Groups of geoms that give inertia.
    pub(super) inertiagrouprange: [f64; 2],
    pub(super) balanceinertia: bool,
    /// Least mass, kg, and principal moment, kg·m².
    pub(super) boundmass: f64,
    pub(super) boundinertia: f64,
    /// Mass of all bodies together, kg; not positive where none is requested.
    pub(super) settotalmass: f64,
}

/// Settings that change nothing here, each with why.
const IDLE: [&str; 7] = [
    "usethread",
    "fusestatic",
    "discardvisual",
    "fitaabb",
    "texturedir",
    "exactmeshinertia",
    "saveinertial",
];

impl Compiler {
    /// Reads the settings; later elements win.
    pub(super) fn read<'t>(root: Node<'t>, classes: &Classes<'t>) -> Result<Self, LoadError> {
        let mut out = Self {
            angle: 1_f64.to_radians(),
            eulerseq: ['x', 'y', 'z'],
            autolimits: true,
            meshdir: String::new(),
            strippath: false,
            inertiafromgeom: Choice::Auto,
            inertiagrouprange: [0.0, 5.0],
            balanceinertia: false,
            boundmass: 0.0,
            boundinertia: 0.0,
            settotalmass: -1.0,
        };
        for node in root.all("compiler") {
            out.update(&Entry::plain(node, classes))?;
        }
        Ok(out)
    }

    fn update(&mut self, entry: &Entry<'_, '_>) -> Result<(), LoadError> {
        let units = [("degree", 1_f64.to_radians()), ("radian", 1.0)];
        if let Some(angle) = entry.word("angle", &units)? {
            self.angle = angle;
        }
        if entry.word("coordinate", &[("local", false), ("global", true)])? == Some(true) {
            let reason =
                "global coordinates are not read: save the model with a MuJoCo that reads them";
            return Err(entry.malformed("coordinate", reason));
        }
        if entry.has_own("eulerseq") {
            self.eulerseq = sequence(entry)?;
        }
        self.autolimits = entry.flag("autolimits", self.autolimits)?;
        self.strippath = entry.flag("strippath", self.strippath)?;
        let folder = ["meshdir", "assetdir"].map_each(|name| entry.text(name));
        if let Some(folder) = folder[0].or(folder[1]) {
            self.meshdir = folder.into();
        }
        if entry.has_own("inertiafromgeom") {
            self.inertiafromgeom = entry.choice("inertiafromgeom")?;
        }
        let groups = entry.numbers("inertiagrouprange")?;
        self.inertiagrouprange = groups.unwrap_or(self.inertiagrouprange);
        self.balanceinertia = entry.flag("balanceinertia", self.balanceinertia)?;
        self.boundmass = entry.number("boundmass")?.unwrap_or(self.boundmass);
        self.boundinertia = entry.number("boundinertia")?.unwrap_or(self.boundinertia);
        self.settotalmass = entry.number("settotalmass")?.unwrap_or(self.settotalmass);
        IDLE.into_iter().for_each(|name| {
            entry.node.attribute(name);
        });
        Ok(())
    }
}

fn sequence(entry: &Entry<'_, '_>) -> Result<[char; 3], LoadError> {
    let text: Vec<char> = entry.text("eulerseq").unwrap_or_default().chars().collect();
    let are_axes = text.iter().all(|c| "xyzXYZ".contains(*c));
    match text[..] {
        [a, b, c] if are_axes => Ok([a, b, c]),
        _ => Err(entry.malformed("eulerseq", "expected three of x, y, z, X, Y, Z")),
    }
}
