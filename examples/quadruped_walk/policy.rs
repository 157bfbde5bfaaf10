//! The policy: offsets of the feet, linear in the observations; one matrix for legs on the ground, and one for legs in the air.

use super::task::{ACTIONS, OBSERVED, SPEED};

/// Number of observations of a leg: one, then the vertical along x and y, angular velocity, error of the speed along x, speed along y, direction.
pub(crate) const KNOWN: usize = 9;
/// Numbers of a policy: stride and lift, then for each half of the trot the rows of a front and a hind leg.
pub(crate) const NUMBERS: usize = 2 + 2 * 2 * 3 * KNOWN;

/// Sign of each observation in a mirror that exchanges left and right.
const MIRRORED: [f64; KNOWN] = [1.0, 1.0, -1.0, -1.0, 1.0, -1.0, 1.0, -1.0, -1.0];
/// Whether each leg is a left one, is a hind one, and its place in the trot.
const LEGS: [(bool, bool, f64); 4] = [
    (false, false, 0.0),
    (true, false, 0.5),
    (false, true, 0.5),
    (true, true, 0.0),
];

/// The action for an observation.
pub(crate) fn act(numbers: &[f64], observed: &[f64], action: &mut [f64]) {
    assert_eq!((observed.len(), action.len()), (OBSERVED, ACTIONS));
    let ((gait, numbers), (first, offsets)) = (numbers.split_at(2), action.split_at_mut(2));
    first.copy_from_slice(gait);
    for (k, &(is_left, is_hind, place)) in LEGS.iter().enumerate() {
        let mut known = [0.0; KNOWN];
        known[0] = 1.0;
        known[1..].copy_from_slice(&observed[1..]);
        known[6] -= SPEED;
        if is_left {
            known
                .iter_mut()
                .zip(MIRRORED)
                .for_each(|(x, sign)| *x *= sign);
        }
        // From 1 in the middle of the stance to 0 in the middle of the swing.
        let phase = std::f64::consts::TAU * (observed[0] + place);
        let stance = (0.5 + phase.sin()).clamp(0.0, 1.0);
        for axis in 0..3 {
            let row = |half: usize| {
                let start = KNOWN * (3 * (2 * half + usize::from(is_hind)) + axis);
                let row = &numbers[start..start + KNOWN];
                row.iter().zip(&known).map(|(w, x)| w * x).sum::<f64>()
            };
            let side = if axis == 1 && is_left { -1.0 } else { 1.0 };
            offsets[3 * k + axis] = side * (stance * row(0) + (1.0 - stance) * row(1));
        }
    }
}

/// Reads the text of a policy.
///
/// # Panics
/// If it is not one.
pub(crate) fn of_text(text: &str) -> Vec<f64> {
    let number = |word: &str| word.parse::<f64>().expect("a number of the policy");
    let numbers: Vec<f64> = text.split_whitespace().map(number).collect();
    assert_eq!(numbers.len(), NUMBERS, "the numbers of a policy");
    numbers
}
