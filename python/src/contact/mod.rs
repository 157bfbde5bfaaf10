//! Contacts, terrain, motors, constraints and forces of a simulator, from the small classes of Python that describe them.

mod activations;
mod collisions;
mod law;
mod motors;
mod nearest;
mod parts;
mod points;
mod terrain;

pub(crate) use collisions::{_srdf, _surface_grid};
pub(crate) use law::{_estimate_soft_contact, _impact_time, _restitution, _with_restitution};
pub(crate) use motors::actuation_of;
pub(crate) use nearest::_nearest;
pub(crate) use parts::with_parts;
pub(crate) use points::{contacts_of, point_numbers};
pub(crate) use terrain::{_terrain_surface, _tiled, terrain_of};
