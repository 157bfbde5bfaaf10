//! The robots of a kit.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, SoftContact, Terrain};
use dualbody::{Model, Simulator};

/// Time step of all robots, s.
const TIME_STEP: f64 = 1e-3;
/// Time step on soft ground, where light feet on stiff springs need a shorter one, s.
const SOFT_TIME_STEP: f64 = 2e-4;
/// Depth to which a robot sinks into soft ground, m.
const DEPTH: f64 = 5e-3;

/// The ground under a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ground {
    /// There is none.
    Absent,
    /// With springs and dampers.
    Soft,
    /// Without penetration, as a convex problem: in double precision only.
    Relaxed,
}

/// A robot, with the ground that it stands on.
pub(crate) struct Robot {
    pub(crate) name: String,
    pub(crate) ground: Ground,
    pub(crate) simulator: Simulator,
}

/// Robots that stand: the name of the file, the links of the feet, the ground.
const STANDING: [(&str, &[&str], Ground); 4] = [
    ("quadruped", &QUADRUPED, Ground::Soft),
    ("humanoid", &HUMANOID, Ground::Soft),
    ("sphere", &[], Ground::Relaxed),
    ("quadruped", &QUADRUPED, Ground::Relaxed),
];
const QUADRUPED: [&str; 4] = ["FR_foot", "FL_foot", "RR_foot", "RL_foot"];
const HUMANOID: [&str; 2] = ["left_ankle_roll_link", "right_ankle_roll_link"];

/// All robots of a folder of URDF files, those that stand on the ground too.
///
/// * `only` – names of files without `.urdf`; all if there are none
pub(crate) fn robots(folder: &Path, only: &[String]) -> Result<Vec<Robot>, Box<dyn Error>> {
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .map_err(|error| format!("{}: {error}", folder.display()))?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    files.retain(|path| path.extension().is_some_and(|end| end == "urdf"));
    files.retain(|path| only.is_empty() || only.contains(&stem(path)));
    // Small robots first: where the time is over, those are left out that take long.
    files.sort_by_key(|path| {
        (
            fs::metadata(path).map_or(0, |file| file.len()),
            path.clone(),
        )
    });
    if files.is_empty() {
        return Err(format!("{}: there is no URDF file of {only:?}", folder.display()).into());
    }
    let mut out = Vec::new();
    for file in files {
        let (name, model) = (stem(&file), Model::from_urdf_file(&file)?);
        let standing = STANDING.iter().filter(|(own, ..)| *own == name);
        for (_, feet, ground) in standing {
            out.push(on_ground(&name, &model, feet, *ground)?);
        }
        out.push(Robot {
            name,
            ground: Ground::Absent,
            simulator: Simulator::new(model).with_time_step(TIME_STEP),
        });
    }
    Ok(out)
}

/// A robot whose feet touch flat ground.
fn on_ground(
    name: &str,
    model: &Model,
    feet: &[&str],
    ground: Ground,
) -> Result<Robot, Box<dyn Error>> {
    let points = 4;
    let (law, word, time_step) = match ground {
        Ground::Soft => {
            let law = SoftContact::estimate(model.total_mass(), points, DEPTH);
            (ContactLaw::Soft(law), "soft", SOFT_TIME_STEP)
        }
        _ => {
            let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
            (law, "relaxed", TIME_STEP)
        }
    };
    let mut contacts = Contacts::new(model, Terrain::flat(0.0), law);
    if !feet.is_empty() {
        contacts = contacts.with_links(model, feet)?;
    }
    let simulator = Simulator::new(model.clone()).with_contacts(contacts);
    Ok(Robot {
        name: format!("{name} on {word} ground"),
        ground,
        simulator: simulator.with_time_step(time_step),
    })
}

/// The name of a file without its ending.
fn stem(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}
