//! Contacts over numbers with derivatives in their own parameters: which directions parameters have, and where their derivatives go.

use std::ops::Range;

use crate::contact::{
    ContactPart, Contacts, LAW_NUMBERS, MATERIAL_NUMBERS, PLANE_NUMBERS, POINT_NUMBERS,
    SHAPE_NUMBERS, TURNING_NUMBERS,
};
use crate::scalar::{Cast, Scalar};
use crate::sim::terms::local::{BODY_DIRECTIONS, OfBody};
use crate::sim::terms::numbers::Numbers;

/// The directions of a point's own numbers, those of its law, and those of a plane, in place of the above; between bodies those of a shape, of the law, and of
/// the material of the shape.
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

/// Adds derivatives in the parameters of the contact model between bodies, and in those of a shape.
pub(super) fn add_pair_numbers<T: Scalar>(
    x: &OfBody<T>,
    (shape, has_material, has_turning): (usize, bool, bool),
    with_law: bool,
    out: &mut Numbers<'_, T>,
) {
    let slots = out.slots().0;
    let (own, law) = (slots.shapes[shape].clone(), slots.pair_law.clone());
    let material = if has_material { MATERIAL_NUMBERS } else { 0 };
    let end = match has_material && has_turning {
        true => last_of(&own, TURNING_NUMBERS).start,
        false => own.end,
    };
    let sizes_end = last_of(&(own.start..end), material).start;
    out.add(&(own.start..sizes_end), &x.eps[..LAW]);
    out.add(&(sizes_end..end), &x.eps[TERRAIN..]);
    if with_law {
        out.add(&law, &x.eps[LAW..TERRAIN]);
    }
}

/// Contacts with the derivatives of numbers in themselves, for each point those of its own, and those of a plane; for each shape those of its own.
pub(super) fn seeded<T: Scalar>(contacts: &Contacts) -> Contacts<OfBody<T>> {
    let is_curved = contacts.terrain().is_curved();
    seeded_from(contacts, |part| match part {
        part if part.is_turning() => None,
        ContactPart::Terrain if is_curved => None,
        ContactPart::Point(_) | ContactPart::Shape(_) => Some(0),
        ContactPart::Law(_) | ContactPart::PairLaw => Some(LAW),
        _ => Some(TERRAIN),
    })
}

/// First directions of torsional and rolling friction of a point or of a shape, and of pairs of shapes without materials.
const OWN_TURNING: usize = 0;
const PAIR_TURNING: usize = TURNING_NUMBERS;

/// Contacts with the derivatives of torsional and rolling friction in themselves.
pub(super) fn seeded_turning<T: Scalar>(contacts: &Contacts) -> Contacts<OfBody<T>> {
    seeded_from(contacts, |part| match part {
        ContactPart::PairTurning => Some(PAIR_TURNING),
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

/// Adds derivatives in torsional and rolling friction of a point.
pub(super) fn add_turning_numbers<T: Scalar>(
    x: &OfBody<T>,
    index: usize,
    out: &mut Numbers<'_, T>,
) {
    let own = last_of(&out.slots().0.laws[index], TURNING_NUMBERS);
    out.add(&own, &x.eps[OWN_TURNING..PAIR_TURNING]);
}

/// Adds derivatives in torsional and rolling friction of a shape with a material, and in those of pairs without.
pub(super) fn add_pair_turning_numbers<T: Scalar>(
    x: &OfBody<T>,
    shape: Option<usize>,
    with_law: bool,
    out: &mut Numbers<'_, T>,
) {
    if let Some(shape) = shape {
        let own = last_of(&out.slots().0.shapes[shape], TURNING_NUMBERS);
        out.add(&own, &x.eps[OWN_TURNING..PAIR_TURNING]);
    }
    if with_law {
        let own = last_of(&out.slots().0.pair_law, TURNING_NUMBERS);
        out.add(&own, &x.eps[PAIR_TURNING..]);
    }
}
