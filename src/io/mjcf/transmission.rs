//! Targets of actuators: joints, sites and fixed tendons.

use std::collections::HashMap;

use super::entry::Entry;
use super::joint::Kind;
use super::scene::MjcfTransmission;
use super::walk::Part;
use crate::error::LoadError;
use crate::scalar::MapEach;

/// Attributes that name what an actuator acts on.
const TARGETS: [&str; 6] = [
    "joint",
    "jointinparent",
    "tendon",
    "site",
    "cranksite",
    "body",
];

/// The target of an actuator, and why that is not modelled, if it is not.
pub(super) fn read(
    entry: &Entry<'_, '_>,
    part: &Part<'_, '_>,
    kinds: &HashMap<String, Kind>,
    gear: [f64; 6],
) -> Result<(MjcfTransmission, Option<&'static str>), LoadError> {
    let own = TARGETS.map_each(|name| entry.text(name));
    let named = own.iter().zip(TARGETS).find_map(|(own, kind)| {
        let name = part.naming.of((*own)?);
        Some((kind, name))
    });
    let Some((kind, name)) = named else {
        return Err(entry.missing("joint, tendon, site or body"));
    };
    let reference = entry.text("refsite");
    Ok(match kind {
        "joint" | "jointinparent" => {
            let lack = match kinds.get(&name).map(|joint| joint.is_single()) {
                Some(true) => None,
                Some(false) => Some("acts on a joint of several axes"),
                None => Some("acts on a joint that is not modelled"),
            };
            (MjcfTransmission::Joint(name), lack)
        }
        "site" => match reference {
            None => (MjcfTransmission::Site(name, gear), None),
            Some(reference) => {
                let reference = part.naming.of(reference);
                let site = name;
                (
                    MjcfTransmission::SiteFrom {
                        site,
                        reference,
                        gear,
                    },
                    None,
                )
            }
        },
        "tendon" => (MjcfTransmission::Tendon(name), None),
        "cranksite" if entry.text("slidersite").is_none() => {
            return Err(entry.missing("slidersite"));
        }
        _ => {
            let lack = Some("acts on something that is not modelled");
            (MjcfTransmission::Other(name), lack)
        }
    })
}
