//! Kinematics of a leg: three joints, of abduction, hip and knee, for a place of the foot.

/// Length of thigh and shank, distance of their plane from the axis of abduction, m.
const LINK: f64 = 0.2;
const ASIDE: f64 = 0.0838;

/// Place of a foot under its leg on bent legs, relative to the first joint, m; y is that of a left leg.
pub(crate) const UNDER: [f64; 3] = [0.0, ASIDE, -0.28];

/// The angles of the joints of a leg for a place of its foot relative to its first joint, rad. Places out of reach become the nearest ones that are within it.
///
/// * `side` – 1 for a left leg, −1 for a right one
pub(crate) fn joints(side: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let down = (y * y + z * z - ASIDE * ASIDE).max(1e-4).sqrt();
    let abduction = z.atan2(y) - (-down).atan2(side * ASIDE);
    let reach = x.hypot(down).clamp(0.1, 1.99 * LINK);
    let knee = -2.0 * (reach / (2.0 * LINK)).acos();
    let hip = (-x).atan2(down) - knee / 2.0;
    [wrapped(abduction), hip, knee]
}

fn wrapped(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}
