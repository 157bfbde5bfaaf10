//! Numbers of contact: of geoms, and which pairs touch.

use super::body::Bodies;
use super::entry::Entry;
use super::scene::{MjcfContacts, MjcfGeom, MjcfOptions};
use super::walk::Part;
use crate::contact::{Impedance, Reference, RelaxedRigid, Sigmoid};
use crate::error::LoadError;
use crate::io::context::Context;

/// Numbers of a geom where nothing else is said.
const FRICTION: [f64; 3] = [1.0, 0.005, 0.0001];
const SOLREF: [f64; 2] = [0.02, 1.0];
const SOLIMP: [f64; 5] = [0.9, 0.95, 0.001, 0.5, 2.0];

/// Dimensions that a contact force can have.
const CONDIMS: [(&str, u8); 4] = [("1", 1), ("3", 3), ("4", 4), ("6", 6)];

/// Least and largest impedance, and the least width of its rise (m), as `MuJoCo` bounds them.
const LEAST_IMPEDANCE: f64 = 1e-4;
const LARGEST_IMPEDANCE: f64 = 0.9999;
const LEAST_WIDTH: f64 = 1e-15;

/// Reads the numbers of a geom.
pub(super) fn of_geom(entry: &Entry<'_, '_>) -> Result<MjcfGeom, LoadError> {
    let friction = entry.some_numbers("friction", FRICTION)?;
    if friction.iter().any(|&mu| mu < 0.0) {
        return Err(entry.malformed("friction", "is negative"));
    }
    Ok(MjcfGeom {
        name: None,
        link: String::new(),
        friction,
        condim: entry.word("condim", &CONDIMS)?.unwrap_or(3),
        priority: entry.integer("priority")?.unwrap_or(0),
        contype: bits(entry, "contype")?,
        conaffinity: bits(entry, "conaffinity")?,
        solref: entry.some_numbers("solref", SOLREF)?,
        solimp: entry.some_numbers("solimp", SOLIMP)?,
        margin: entry.number("margin")?.unwrap_or_default(),
        gap: entry.number("gap")?.unwrap_or_default(),
        solmix: entry.number("solmix")?.unwrap_or(1.0),
    })
}

fn bits(entry: &Entry<'_, '_>, name: &'static str) -> Result<u32, LoadError> {
    Ok(entry.integer(name)?.unwrap_or(1).cast_unsigned())
}

/// Reads a pair of a `<contact>` section.
pub(super) fn read_pair(part: &Part<'_, '_>, contacts: &mut MjcfContacts) -> Result<(), LoadError> {
    let entry = part.entry(&["pair"])?;
    let (names, out) = match entry.node.tag() {
        "exclude" => (["body1", "body2"], &mut contacts.excluded),
        _ => (["geom1", "geom2"], &mut contacts.pairs),
    };
    let [one, other] = names.map(|name| {
        let own = entry.text(name).ok_or_else(|| entry.missing(name));
        own.map(|own| part.naming.of(own))
    });
    out.push([one?, other?]);
    Ok(())
}

impl MjcfContacts {
    /// The pairs with all geoms that touch, and the ground.
    ///
    /// * `floats` – whether the world is no link, so that its shapes do not touch
    pub(super) fn placed(mut self, bodies: &Bodies, floats: bool) -> Self {
        for body in bodies.entries.iter().skip(usize::from(floats)) {
            self.geoms.extend(body.contacts.iter().cloned());
        }
        self.ground.clone_from(&bodies.ground);
        self
    }
}

/// Excludes bodies that several joints connect, as `MuJoCo` excludes those that one does, with what is fixed to them.
pub(super) fn exclude_neighbours(
    bodies: &Bodies,
    contacts: &mut MjcfContacts,
    context: &mut Context<'_>,
) {
    /// Most pairs: files have some tens.
    const MOST: usize = 100_000;
    let entries = &bodies.entries;
    let mut parts: Vec<usize> = vec![0; entries.len()];
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); entries.len()];
    for (i, body) in entries.iter().enumerate() {
        parts[i] = match body.joints.is_empty() {
            true => parts[body.parent],
            false => i,
        };
        if !body.contacts.is_empty() {
            members[parts[i]].push(i);
        }
    }
    let several = (entries.iter().enumerate()).filter(|(_, body)| body.joints.len() > 1);
    for (i, body) in several.filter(|(_, body)| parts[body.parent] != 0) {
        for &a in &members[parts[body.parent]] {
            for &b in &members[i] {
                if contacts.excluded.len() >= MOST {
                    let reason = "too many bodies on several joints: some touch their neighbours";
                    return context.warn(&body.place, reason);
                }
                let names = [a, b].map(|k| entries[k].name.clone());
                contacts.excluded.push(names);
            }
        }
    }
}

/// Numbers of a contact between two geoms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    friction: f64,
    solref: [f64; 2],
    solimp: [f64; 5],
}

impl MjcfGeom {
    /// The numbers of a contact with another geom: those of the one with priority; or the larger friction, and solref and solimp in the ratio of their weights.
    ///
    /// # References
    /// The chapter on computation of the manual of `MuJoCo`, contact parameters.
    pub(super) fn touch(&self, other: &Self) -> Touch {
        let of = |own: &Self, condim: u8| Touch {
            friction: if condim == 1 { 0.0 } else { own.friction[0] },
            solref: own.solref,
            solimp: own.solimp,
        };
        match self.priority.cmp(&other.priority) {
            std::cmp::Ordering::Greater => return of(self, self.condim),
            std::cmp::Ordering::Less => return of(other, other.condim),
            std::cmp::Ordering::Equal => {}
        }
        let condim = self.condim.max(other.condim);
        let [one, two] = [self, other].map(|own| of(own, condim));
        let share = share_of(self.solmix, other.solmix);
        let mixed = |a: f64, b: f64| share * a + (1.0 - share) * b;
        let solref = std::array::from_fn(|i| match one.solref[0] > 0.0 && two.solref[0] > 0.0 {
            true => mixed(one.solref[i], two.solref[i]),
            false => one.solref[i].min(two.solref[i]),
        });
        Touch {
            friction: one.friction.max(two.friction),
            solref,
            solimp: std::array::from_fn(|i| mixed(one.solimp[i], two.solimp[i])),
        }
    }
}

/// Share of the first of two weights.
fn share_of(one: f64, two: f64) -> f64 {
    /// Weights below this are none.
    const NONE: f64 = 1e-15;
    match (one >= NONE, two >= NONE) {
        (true, true) => one / (one + two),
        (false, false) => 0.5,
        (true, false) => 1.0,
        (false, true) => 0.0,
    }
}

impl Touch {
    /// Takes the friction of another contact of the same law, if it is larger.
    pub(super) fn merge(&mut self, other: &Self) {
        self.friction = self.friction.max(other.friction);
    }

    /// The law that has these numbers, within the bounds that `MuJoCo` gives them.
    pub(super) fn law(&self, options: &MjcfOptions) -> RelaxedRigid {
        let impedance = |x: f64| x.clamp(LEAST_IMPEDANCE, LARGEST_IMPEDANCE);
        let [least, largest, width, midpoint, power] = self.solimp;
        let [one, two] = self.solref;
        let is_time = one > 0.0 && two > 0.0;
        let reference = match is_time {
            true => Reference::TimeConstant {
                time_constant: one.max(2.0 * options.time_step),
                damping_ratio: two,
            },
            false => Reference::Direct {
                stiffness: (-one).max(0.0),
                damping: (-two).max(0.0),
            },
        };
        let sigmoid = match (midpoint, power) {
            (0.5, 2.0) => Sigmoid::default(),
            _ => Sigmoid::new(impedance(midpoint), power.max(1.0)),
        };
        RelaxedRigid {
            friction: self.friction,
            reference,
            impedance: Impedance {
                least: impedance(least),
                largest: impedance(largest),
                width: width.max(LEAST_WIDTH),
                sigmoid,
            },
            friction_impedance_ratio: options.impratio,
        }
    }
}
