//! Contacts over numbers with derivatives in their own parameters: which directions parameters have, and where their derivatives go.

use std::ops::Range;

use crate::contact::{
    COMPLIANCE_NUMBERS, ContactPart, Contacts, LAW_NUMBERS, MATERIAL_NUMBERS, MaterialOf,
    PLANE_NUMBERS, POINT_NUMBERS, SHAPE_NUMBERS, TURNING_NUMBERS,
};
use crate::scalar::{Cast, Scalar};
use crate::sim::terms::local::{BODY_DIRECTIONS, OfBody};
use crate::sim::terms::numbers::Numbers;

/// The directions of a point's own numbers, those of its law, and those of a plane, in place of the above; between bodies those of a shape, of the law, and of
/// the friction of a material.
const LAW: usize = POINT_NUMBERS;
const TERRAIN: usize = LAW + LAW_NUMBERS;
const _: () = assert!(
    TERRAIN + PLANE_NUMBERS <= BODY_DIRECTIONS
        && SHAPE_NUMBERS <= LAW
        && MATERIAL_NUMBERS <= PLANE_NUMBERS,
    "a direction for each number"
);

/// Adds derivatives in the parameters of a point, of its contact model and of a plane to those of all parameters.
pub(super) fn add_numbers<T: Scalar>(x: &OfBody<T>, index: usize, out: &mut Numbers<'_, T>) {
    let slots = out.slots().0;
    let parts = [
        (slots.points[index].clone(), &x.eps[..LAW]),
        (slots.laws[index].clone(), &x.eps[LAW..TERRAIN]),
        (slots.terrain.clone(), &x.eps[TERRAIN..]),
    ];
    for (part, own) in parts {
        out.add(&part, own);
    }
}

/// Adds derivatives in the parameters of a point between bodies: in the sizes of a shape, in the friction of the material by its side, and with that of the first
/// one in the contact model.
pub(super) fn add_pair_numbers<T: Scalar>(
    x: &OfBody<T>,
    contacts: &Contacts<OfBody<T>>,
    (shapes, side): ([usize; 2], usize),
    out: &mut Numbers<'_, T>,
) {
    let slots = out.slots().0;
    let own = MaterialOf::Shape(shapes[side]);
    let [sizes, ..] = parts_of(contacts, own, out);
    let law = slots.pair_law.clone();
    out.add(&sizes, &x.eps[..LAW]);
    if let Some(material) = contacts.material_by_side(shapes, side) {
        let [_, friction, ..] = parts_of(contacts, material, out);
        out.add(&friction, &x.eps[TERRAIN..]);
    }
    if side == 0 {
        out.add(&law, &x.eps[LAW..TERRAIN]);
    }
}

/// Positions of the parameters of a shape or of the material of a pair: sizes, friction with restitution, torsional and rolling friction, compliance.
fn parts_of<T: Scalar>(
    contacts: &Contacts<OfBody<T>>,
    owner: MaterialOf,
    out: &Numbers<'_, T>,
) -> [Range<usize>; 4] {
    let slots = out.slots().0;
    let all = match owner {
        MaterialOf::Shape(k) => slots.shapes[k].clone(),
        MaterialOf::Pair(k) => slots.pair_materials[k].clone(),
    };
    let [friction, turning, compliance] = contacts.material_counts(owner);
    let compliance = last_of(&all, compliance);
    let turning = last_of(&(all.start..compliance.start), turning);
    let friction = last_of(&(all.start..turning.start), friction);
    [all.start..friction.start, friction, turning, compliance]
}

/// Contacts with the derivatives of numbers in themselves, for each point those of its own, and those of a plane; for each shape those of its own.
pub(super) fn seeded<T: Scalar>(contacts: &Contacts) -> Contacts<OfBody<T>> {
    let is_curved = contacts.terrain().is_curved();
    seeded_from(contacts, |part| match part {
        part if part.is_turning() || part.is_compliance() => None,
        ContactPart::Margin(_) => None,
        ContactPart::Terrain if is_curved => None,
        ContactPart::Point(_) | ContactPart::Shape(_) => Some(0),
        ContactPart::Law(_) | ContactPart::PairLaw => Some(LAW),
        _ => Some(TERRAIN),
    })
}

/// First directions of torsional and rolling friction of a point or of a material, of those of pairs of shapes without materials, of compliance, and of the margin of a point.
const OWN_TURNING: usize = 0;
const PAIR_TURNING: usize = OWN_TURNING + TURNING_NUMBERS;
const COMPLIANCE: usize = PAIR_TURNING + TURNING_NUMBERS;
const MARGIN: usize = COMPLIANCE + COMPLIANCE_NUMBERS;
const _: () = assert!(MARGIN < BODY_DIRECTIONS, "a direction for each number");

/// Contacts with the derivatives of torsional and rolling friction, of margins of points and of compliance of materials in themselves.
pub(super) fn seeded_beside<T: Scalar>(contacts: &Contacts) -> Contacts<OfBody<T>> {
    seeded_from(contacts, |part| match part {
        ContactPart::PairTurning => Some(PAIR_TURNING),
        ContactPart::Margin(_) => Some(MARGIN),
        part if part.is_compliance() => Some(COMPLIANCE),
        part => part.is_turning().then_some(OWN_TURNING),
    })
}

/// Contacts with the derivatives of the numbers of some parts, each part's from a direction on.
fn seeded_from<T: Scalar>(
    contacts: &Contacts,
    first: impl Fn(ContactPart) -> Option<usize>,
) -> Contacts<OfBody<T>> {
    let mut out = contacts.cast::<OfBody<T>>();
    let (mut direction, mut last) = (0, None);
    out.each_number(&mut |part, _, x| {
        let Some(first) = first(part) else { return };
        if last.replace(part) != Some(part) {
            direction = first;
        }
        x.eps[direction] = T::one();
        direction += 1;
    });
    out
}

/// So many last parameters of a part: of one with torsional and rolling friction those.
fn last_of(part: &Range<usize>, count: usize) -> Range<usize> {
    part.end.saturating_sub(count).max(part.start)..part.end
}

/// Adds derivatives in torsional and rolling friction and in the margin of a point.
pub(super) fn add_numbers_beside<T: Scalar>(
    x: &OfBody<T>,
    contacts: &Contacts<OfBody<T>>,
    index: usize,
    out: &mut Numbers<'_, T>,
) {
    let [turning, margin] = contacts.counts_beside_law();
    let all = out.slots().0.laws[index].clone();
    let margin = last_of(&all, margin);
    let turning = last_of(&(all.start..margin.start), turning);
    out.add(&turning, &x.eps[OWN_TURNING..PAIR_TURNING]);
    out.add(&margin, &x.eps[MARGIN..]);
}

/// Adds derivatives in torsional and rolling friction and compliance of the material by a side, and with that of the first one in torsional and rolling friction
/// of shapes without.
pub(super) fn add_pair_numbers_beside<T: Scalar>(
    x: &OfBody<T>,
    contacts: &Contacts<OfBody<T>>,
    (shapes, side): ([usize; 2], usize),
    out: &mut Numbers<'_, T>,
) {
    if let Some(material) = contacts.material_by_side(shapes, side) {
        let [_, _, turning, compliance] = parts_of(contacts, material, out);
        out.add(&turning, &x.eps[OWN_TURNING..PAIR_TURNING]);
        out.add(&compliance, &x.eps[COMPLIANCE..MARGIN]);
    }
    if side == 0 && contacts.have_turning_between() {
        let own = last_of(&out.slots().0.pair_law, TURNING_NUMBERS);
        out.add(&own, &x.eps[PAIR_TURNING..COMPLIANCE]);
    }
}
