//! Pictures against where things are: by the colours of their pixels.

use dualbody::model::{Geometry, LinkSpec, ModelBuilder, samples};
use dualbody::spatial::Transform;
use dualbody::view::{Camera, Picture, PictureOptions, Pictures, Recording};
use dualbody::{Model, State};
use nalgebra::Vector3;

const OPTIONS: PictureOptions = PictureOptions {
    width: 160,
    height: 120,
    rate: 25.0,
    speed: 1.0,
};
const RED: [f64; 4] = [1.0, 0.0, 0.0, 1.0];
const BLUE: [f64; 4] = [0.0, 0.0, 1.0, 1.0];

/// From +x at the origin: y is to the right, z up, at a distance of 4 m; half the height of the picture is tan 20° · 4 m there.
const CAMERA: Camera = Camera {
    look_at: [0.0; 3],
    distance: 4.0,
    azimuth: 0.0,
    elevation: 0.0,
};

/// A robot of which nothing is seen: a speck far away.
fn nobody() -> Model {
    let mut builder = ModelBuilder::new("nobody");
    builder.add_link(LinkSpec::new("world"));
    builder.build().expect("a model")
}

fn boxes(boxes: &[([f64; 3], f64, [f64; 4])]) -> Recording {
    let mut recording = Recording::new(&nobody()).with_camera(CAMERA);
    for (k, (at, edge, color)) in boxes.iter().enumerate() {
        let place = Transform::from_translation(Vector3::from(*at));
        recording.add_shape(
            format!("box {k}"),
            Geometry::Box { size: [*edge; 3] },
            place,
            *color,
        );
    }
    recording
}

/// Where pixels are of one colour more than of the others: columns and rows of the least and the largest, and how many.
fn extent(picture: &Picture, channel: usize) -> Option<([usize; 4], usize)> {
    let width = picture.width as usize;
    let is_own =
        |p: &[u8]| (0..3).all(|c| c == channel || u32::from(p[channel]) > 2 * u32::from(p[c]) + 20);
    let own: Vec<_> = picture
        .pixels
        .chunks(3)
        .enumerate()
        .filter(|(_, p)| is_own(p))
        .map(|(k, _)| [k % width, k / width])
        .collect();
    let of = |axis: usize| own.iter().map(move |at| at[axis]);
    let ends = [of(0).min()?, of(0).max()?, of(1).min()?, of(1).max()?];
    Some((ends, own.len()))
}

/// Column and row of a point by the pinhole camera.
fn pixel([x, y, z]: [f64; 3]) -> [f64; 2] {
    let scale = 60.0 / 20_f64.to_radians().tan() / (4.0 - x);
    [80.0 + scale * y, 60.0 - scale * z]
}

#[test]
fn a_box_is_where_the_pinhole_camera_has_it() {
    let picture = boxes(&[([0.5, 0.6, 0.3], 0.4, RED)]).picture(0.0, OPTIONS);
    let ([left, right, top, bottom], count) = extent(&picture, 0).expect("a red box");
    // Its front is at x = 0.7.
    let ([x0, y1], [x1, y0]) = (pixel([0.7, 0.4, 0.1]), pixel([0.7, 0.8, 0.5]));
    for (found, expected) in [(left, x0), (right + 1, x1), (top, y0), (bottom + 1, y1)] {
        assert!(
            (found as f64 - expected).abs() < 2.0,
            "{found} against {expected}"
        );
    }
    assert!(count as f64 > 0.9 * (x1 - x0) * (y1 - y0));
}

#[test]
fn what_is_near_covers_what_is_far_in_either_order() {
    let (near, far) = (([1.0, 0.0, 0.0], 0.3, RED), ([-1.0, 0.0, 0.0], 0.6, BLUE));
    for order in [[near, far], [far, near]] {
        let picture = boxes(&order).picture(0.0, OPTIONS);
        let middle = &picture.pixels[3 * (60 * 160 + 80)..][..3];
        assert!(middle[0] > 100 && middle[2] < 100, "{middle:?}");
        // Behind the red box a rim of the blue one is seen: 60 / 5.3·… against 60 / 2.85·…
        assert!(extent(&picture, 2).is_none_or(|(_, count)| count < 400));
    }
    let beside = boxes(&[near, ([-1.0, 0.9, 0.0], 0.6, BLUE)]).picture(0.0, OPTIONS);
    assert!(extent(&beside, 2).is_some_and(|([left, ..], _)| left > 90));
}

#[test]
fn boxes_through_one_another_are_cut_where_they_meet() {
    // Each sticks out of the other at one side: no order of whole boxes is right.
    let picture =
        boxes(&[([0.0, -0.2, 0.0], 0.6, RED), ([0.1, 0.2, 0.0], 0.6, BLUE)]).picture(0.0, OPTIONS);
    let (red, blue) = (
        extent(&picture, 0).expect("red"),
        extent(&picture, 2).expect("blue"),
    );
    assert!(red.0[1] <= blue.0[0] + 1, "{red:?} {blue:?}");
}

#[test]
fn a_translucent_box_lets_half_through() {
    let at = |alpha: f64| {
        let picture = boxes(&[([0.0; 3], 0.8, [1.0, 0.0, 0.0, alpha])]).picture(0.0, OPTIONS);
        let sum = |c: usize| {
            (50..70)
                .map(|y| u32::from(picture.pixels[3 * (160 * y + 80) + c]))
                .sum::<u32>()
        };
        f64::from(sum(1)) / 20.0
    };
    let (clear, half, solid) = (at(0.0), at(0.5), at(1.0));
    assert!(clear > 200.0 && solid < 40.0, "{clear} {solid}");
    assert!((half - 0.5 * (clear + solid)).abs() < 10.0, "{half}");
}

#[test]
fn robots_move_in_pictures_as_their_states_do() {
    let pendulum = samples::pendulum();
    let mut recording = Recording::new(&pendulum).with_camera(CAMERA);
    recording.push(0.0, &State::new(&[0.0], &[0.0]), &[]);
    recording.push(1.0, &State::new(&[1.0], &[0.0]), &[]);
    let pictures = Pictures::new(&recording, OPTIONS);
    assert_eq!(
        recording.picture(0.0, OPTIONS),
        pictures.of(&[&State::new(&[0.0], &[0.0])])
    );
    assert_eq!(
        recording.picture(0.5, OPTIONS),
        pictures.of(&[&State::new(&[0.5], &[0.0])])
    );
    assert_eq!(
        recording.picture(9.0, OPTIONS),
        recording.picture(1.0, OPTIONS)
    );
    assert_eq!(
        recording.picture(-9.0, OPTIONS),
        recording.picture(0.0, OPTIONS)
    );
    assert_ne!(
        recording.picture(0.5, OPTIONS),
        recording.picture(1.0, OPTIONS)
    );
    // A state that is not finite is drawn like the last finite one.
    recording.push(2.0, &State::new(&[f64::NAN], &[0.0]), &[]);
    assert_eq!(
        recording.picture(2.0, OPTIONS),
        recording.picture(1.0, OPTIONS)
    );
}

#[test]
fn the_camera_of_a_recording_without_one_has_everything_in_the_picture() {
    let mut recording = Recording::new(&nobody());
    for (k, at) in [[3.0, 0.0, 0.0], [0.0, -2.0, 5.0], [-4.0, 7.0, 1.0]]
        .into_iter()
        .enumerate()
    {
        let place = Transform::from_translation(Vector3::from(at));
        recording.add_shape(
            format!("ball {k}"),
            Geometry::Sphere { radius: 0.5 },
            place,
            RED,
        );
    }
    let ([left, right, top, bottom], _) =
        extent(&recording.picture(0.0, OPTIONS), 0).expect("red balls");
    assert!(left > 0 && right < 159 && top > 0 && bottom < 119);
    // And is not much farther away than that takes.
    assert!(right - left > 80 || bottom - top > 60);
}

#[test]
fn an_animation_has_the_frames_and_times_of_the_motion() {
    let mut recording = Recording::new(&samples::pendulum());
    for k in 0..=10 {
        let angle = 0.1 * f64::from(k);
        recording.push(angle, &State::new(&[angle], &[0.0]), &[]);
    }
    let slow = PictureOptions {
        speed: 0.5,
        ..OPTIONS
    };
    for (options, count) in [(OPTIONS, 26), (slow, 51)] {
        let gif = recording.to_gif(options);
        assert_eq!(&gif[..6], b"GIF89a");
        assert_eq!((gif[6], gif[8]), (160, 120));
        // Graphic control extensions with the delay of 4 hundredths.
        let frames = gif
            .windows(6)
            .filter(|w| w[..3] == [0x21, 0xf9, 4] && w[4..] == [4, 0])
            .count();
        assert_eq!(frames, count);
        assert_eq!(gif.last(), Some(&0x3b));
    }
}

#[test]
fn pictures_of_odd_recordings_are_drawn() {
    // Without a moment, without a shape, far away, from straight above.
    for camera in [
        CAMERA,
        Camera {
            elevation: 90.0,
            ..CAMERA
        },
        Camera {
            distance: 0.0,
            ..CAMERA
        },
        Camera {
            look_at: [1e9, 0.0, 0.0],
            ..CAMERA
        },
    ] {
        let picture = Recording::new(&nobody())
            .with_camera(camera)
            .picture(0.0, OPTIONS);
        assert_eq!(picture.pixels.len(), 160 * 120 * 3);
    }
    let tiny = PictureOptions {
        width: 1,
        height: 1,
        ..OPTIONS
    };
    assert_eq!(
        Recording::new(&nobody())
            .picture(f64::INFINITY, tiny)
            .pixels
            .len(),
        3
    );
    assert!(!Recording::new(&nobody()).to_gif(tiny).is_empty());
}

#[test]
#[should_panic(expected = "a picture of 100000 × 100000 pixels")]
fn pictures_that_are_too_large_are_refused() {
    let large = PictureOptions {
        width: 100_000,
        height: 100_000,
        ..OPTIONS
    };
    let _ = Recording::new(&nobody()).picture(0.0, large);
}
