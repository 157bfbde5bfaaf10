//! Numbers of contact: of geoms, and of two of them.

use super::entry::Entry;
use super::scene::{MjcfGeom, MjcfOptions, MjcfPair};
use super::solver_parameters::{SOLIMP, SOLREF, impedance, reference};
use crate::contact::{Compliance, Material, RelaxedRigid, TurningFriction};
use crate::error::LoadError;
use crate::scalar::{MapEach, from_each};

/// Default contact parameters of a geom.
const FRICTION: [f64; 3] = [1.0, 0.005, 0.0001];

/// Dimensions that a contact force can have.
const CONDIMS: [(&str, u8); 4] = [("1", 1), ("3", 3), ("4", 4), ("6", 6)];

/// Reads the contact parameters of a geom.
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
        margin: margin(entry)?,
        gap: entry.number("gap")?.unwrap_or_default(),
        solmix: entry.number("solmix")?.unwrap_or(1.0),
    })
}

/// Reads the contact parameters of a pair of geoms. Its defaults do not depend on the geoms.
pub(super) fn of_pair(entry: &Entry<'_, '_>, geoms: [String; 2]) -> Result<MjcfPair, LoadError> {
    let [sliding, torsional, rolling] = FRICTION;
    let otherwise = [sliding, sliding, torsional, rolling, rolling];
    let friction = entry.some_numbers("friction", otherwise)?;
    if friction.iter().any(|&mu| mu < 0.0) {
        return Err(entry.malformed("friction", "is negative"));
    }
    Ok(MjcfPair {
        geoms,
        friction,
        condim: entry.word("condim", &CONDIMS)?.unwrap_or(3),
        solref: entry.some_numbers("solref", SOLREF)?,
        solimp: entry.some_numbers("solimp", SOLIMP)?,
        margin: margin(entry)?,
        gap: entry.number("gap")?.unwrap_or_default(),
    })
}

fn margin(entry: &Entry<'_, '_>) -> Result<f64, LoadError> {
    match entry.number("margin")?.unwrap_or_default() {
        margin if margin >= 0.0 => Ok(margin),
        _ => Err(entry.malformed("margin", "is negative")),
    }
}

fn bits(entry: &Entry<'_, '_>, name: &'static str) -> Result<u32, LoadError> {
    Ok(entry.integer(name)?.unwrap_or(1).cast_unsigned())
}

/// Parameters of a contact between two geoms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    friction: f64,
    /// Distance at which it begins, m.
    pub(super) margin: f64,
    pub(super) turning: TurningFriction,
    solref: [f64; 2],
    solimp: [f64; 5],
}

/// Torsional and rolling friction in a contact of a dimension.
fn turning(condim: u8, torsional: f64, rolling: f64) -> TurningFriction {
    TurningFriction {
        torsional: if condim >= 4 { torsional } else { 0.0 },
        rolling: if condim >= 6 { rolling } else { 0.0 },
    }
}

impl MjcfPair {
    /// The parameters of its contact.
    pub(super) fn touch(&self) -> Touch {
        let [friction, _, torsional, rolling, _] = self.friction;
        Touch {
            friction: if self.condim == 1 { 0.0 } else { friction },
            margin: self.margin,
            turning: turning(self.condim, torsional, rolling),
            solref: self.solref,
            solimp: self.solimp,
        }
    }
}

impl MjcfGeom {
    /// Whether another geom has the same contact parameters.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let numbers = |own: &Self| {
            let (slips, turning) = (own.condim == 1, own.turning(own.condim));
            let friction = (slips, own.friction[0], turning, own.margin);
            let compliance = (own.solref, own.solimp, own.solmix);
            (friction, own.condim, own.priority, compliance)
        };
        numbers(self) == numbers(other)
    }

    /// Torsional and rolling friction in a contact of a dimension.
    fn turning(&self, condim: u8) -> TurningFriction {
        let [_, torsional, rolling] = self.friction;
        turning(condim, torsional, rolling)
    }

    /// The parameters of a contact with another geom: those of the one with priority; or the larger friction, and solref and solimp in the ratio of their weights. The margin is the sum in any case.
    ///
    /// # References
    /// The chapter on computation of the manual of `MuJoCo`, contact parameters.
    pub(super) fn touch(&self, other: &Self) -> Touch {
        let of = |own: &Self, condim: u8| Touch {
            friction: if condim == 1 { 0.0 } else { own.friction[0] },
            margin: self.margin + other.margin,
            turning: own.turning(condim),
            solref: own.solref,
            solimp: own.solimp,
        };
        match self.priority.cmp(&other.priority) {
            std::cmp::Ordering::Greater => return of(self, self.condim),
            std::cmp::Ordering::Less => return of(other, other.condim),
            std::cmp::Ordering::Equal => {}
        }
        let condim = self.condim.max(other.condim);
        let [one, two] = [self, other].map_each(|own| of(own, condim));
        let share = share_of(self.solmix, other.solmix);
        let mixed = |a: f64, b: f64| share * a + (1.0 - share) * b;
        let solref = from_each(|i| match one.solref[0] > 0.0 && two.solref[0] > 0.0 {
            true => mixed(one.solref[i], two.solref[i]),
            false => one.solref[i].min(two.solref[i]),
        });
        Touch {
            friction: one.friction.max(two.friction),
            margin: one.margin,
            turning: larger(&one.turning, &two.turning),
            solref,
            solimp: from_each(|i| mixed(one.solimp[i], two.solimp[i])),
        }
    }
}

fn larger(one: &TurningFriction, two: &TurningFriction) -> TurningFriction {
    TurningFriction {
        torsional: one.torsional.max(two.torsional),
        rolling: one.rolling.max(two.rolling),
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
    /// Takes friction and margin of another contact of the same law, if they are larger.
    pub(super) fn merge(&mut self, other: &Self) {
        self.friction = self.friction.max(other.friction);
        self.margin = self.margin.max(other.margin);
        self.turning = larger(&self.turning, &other.turning);
    }

    /// The material that has these numbers.
    pub(super) fn material(&self, options: &MjcfOptions) -> Material {
        let law = self.law(options);
        Material {
            friction: law.friction,
            restitution: 0.0,
            margin: self.margin,
            turning: self.turning,
            compliance: Some(Compliance::Regularised {
                reference: law.reference,
                impedance: law.impedance,
            }),
        }
    }

    /// The law that has these numbers, within the bounds that `MuJoCo` gives them.
    pub(super) fn law(&self, options: &MjcfOptions) -> RelaxedRigid {
        RelaxedRigid {
            friction: self.friction,
            reference: reference(self.solref, options.time_step),
            impedance: impedance(self.solimp),
            friction_impedance_ratio: options.impratio,
        }
    }
}
