//! Robots: loading, questions, changes.
//!
//! | file | what it is |
//! |---|---|
//! | `handle` | the class `Model`, and how it pickles |
//! | `load`, `scene`, `report`, `samples`, `build`, `shapes` | where robots come from |
//! | `questions`, `random_state`, `engines` | what they are asked |
//! | `changes`, `hardware` | robots with something changed, with other sizes of links |

mod build;
mod changes;
mod engines;
mod handle;
mod hardware;
mod load;
mod questions;
mod random_state;
mod report;
mod samples;
mod scene;
mod shapes;

pub(crate) use build::_build_model;
pub(crate) use engines::PyEngineCoordinates;
pub(crate) use handle::{_edited, PyModel, next_id};
pub(crate) use hardware::{_hardware, _hardware_jacobian, _hardware_model};
pub(crate) use load::{_load_model, is_text};
pub(crate) use random_state::{_random_state, _unit_joint_forces};
pub(crate) use report::{_import_report, PyImportReport};
pub(crate) use samples::{_sample, _sample_urdf};
pub(crate) use scene::{_load_scene, _scene_model, PyScene};
pub(crate) use shapes::{_solid_inertia, read_geometry, read_pose};
