//! A picture out of samples: light, floor, shadow.

use nalgebra::Vector3;

use super::eye::Eye;
use super::raster::{Lens, Sample, Seen};
use super::stage::{Poses, Stage, StagePiece};
use super::{Picture, PictureOptions};
use crate::scalar::{MapEach, from_each};
use crate::spatial::Transform;

/// Samples of a pixel along each side, whose mean it is.
const SAMPLES: usize = 2;

/// Colours of the HTML viewer by day, red, green, blue.
const BACKGROUND: [f64; 3] = [0.955, 0.965, 0.975];
const TILES: [[f64; 3]; 2] = [[0.905, 0.918, 0.932], [0.865, 0.880, 0.897]];

/// Direction towards the sun, and how much of the floor's light is left in the shadow.
const TO_SUN: [f64; 3] = [0.45, -0.3, 0.85];
const SHADE: f64 = 0.7;

/// Light of the sky from below and from above, and of the sun; as in the HTML viewer.
const SKY: [[f64; 3]; 2] = [[0.27, 0.26, 0.25], [0.54, 0.57, 0.62]];
const SUN: [f64; 3] = [0.74, 0.71, 0.65];
const SHINE: f64 = 0.18;
const GLOSS: i32 = 40;

/// Exponent between light and the numbers of a screen.
const GAMMA: f64 = 2.2;

/// Radius of the floor, relative to the objects on it, and the fraction of it at which it starts to fade.
const FLOOR: f64 = 6.0;
const FADE: f64 = 0.35;

/// Thresholds of opacity of neighbouring samples, of 16: what is translucent is drawn in a part of them.
const THRESHOLDS: [[u8; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];

/// A picture that is being drawn.
pub(super) struct Drawing<'e> {
    eye: &'e Eye,
    options: PictureOptions,
    lens: Lens,
    colors: Vec<[u8; 3]>,
    /// Of what is drawn in each sample; 0 where there is nothing.
    nearness: Vec<f64>,
}

impl<'e> Drawing<'e> {
    pub(super) fn new(eye: &'e Eye, options: PictureOptions) -> Self {
        let size = [options.width, options.height].map_each(|n| n as usize * SAMPLES);
        let n = size[0] * size[1];
        Self {
            eye,
            options,
            lens: eye.lens(size),
            colors: vec![BACKGROUND.map_each(number); n],
            nearness: vec![0.0; n],
        }
    }

    /// Draws the robots in poses, and more pieces in the world.
    pub(super) fn draw(mut self, stage: &Stage, more: &[StagePiece], poses: &Poses) -> Picture {
        let pieces = stage.pieces.iter().chain(more);
        let placed: Vec<_> = pieces
            .map(|piece| (piece, stage.pose(piece, poses)))
            .collect();
        if let Some(height) = stage.floor {
            let shadow = self.shadow(&placed, height);
            self.draw_floor(stage, height, &shadow);
        }
        placed
            .iter()
            .for_each(|(piece, pose)| self.draw_piece(piece, pose));
        self.finish()
    }

    fn draw_piece(&mut self, piece: &StagePiece, pose: &Transform<f64>) {
        let opacity = (16.0 * piece.color[3].clamp(0.0, 1.0)).round() as u8;
        let table = screen_of_light();
        for corners in piece.corners.chunks_exact(3) {
            let triangle = [0, 1, 2].map_each(|k| {
                let point = pose.point(&corners[k].position);
                let to_eye = self.eye.position() - point;
                let light = lit(&(pose.rotation * corners[k].normal), &to_eye, &piece.color);
                (self.eye.sees(&point), light)
            });
            self.fill(&triangle, |sample| {
                let level =
                    |light: f64| table[(light.clamp(0.0, 1.0) * (LEVELS - 1) as f64) as usize];
                let is_drawn = THRESHOLDS[sample.y % 4][sample.x % 4] < opacity;
                is_drawn.then(|| sample.values.map_each(level))
            });
        }
    }

    /// Draws a triangle where nothing nearer is.
    fn fill<const N: usize>(
        &mut self,
        triangle: &[Seen<N>; 3],
        color: impl Fn(&Sample<N>) -> Option<[u8; 3]>,
    ) {
        let Self {
            lens,
            colors,
            nearness,
            ..
        } = self;
        lens.each_sample(triangle, &mut |sample| {
            let at = sample.y * lens.size[0] + sample.x;
            if sample.nearness <= nearness[at] {
                return;
            }
            if let Some(color) = color(&sample) {
                colors[at] = color;
                nearness[at] = sample.nearness;
            }
        });
    }

    /// Whether the sun does not reach the floor, for each sample.
    fn shadow(&self, placed: &[(&StagePiece, Transform<f64>)], height: f64) -> Vec<bool> {
        let mut out = vec![false; self.colors.len()];
        let sun = Vector3::from(TO_SUN);
        for (piece, pose) in placed.iter().filter(|(piece, _)| piece.color[3] > 0.5) {
            for corners in piece.corners.chunks_exact(3) {
                let triangle = [0, 1, 2].map_each(|k| {
                    let point = pose.point(&corners[k].position);
                    // Nothing below the floor throws a shadow on it.
                    let above = (point.z - height).max(0.0);
                    (self.eye.sees(&(point - sun * (above / sun.z))), [])
                });
                let width = self.lens.size[0];
                self.lens.each_sample(&triangle, &mut |sample: Sample<0>| {
                    out[sample.y * width + sample.x] = true;
                });
            }
        }
        out
    }

    fn draw_floor(&mut self, stage: &Stage, height: f64, shadow: &[bool]) {
        let [low, high] = stage.bounds();
        let (middle, radius) = ((low + high) * 0.5, FLOOR * stage.radius());
        let spacing = 10_f64.powf((stage.radius() / 2.0).log10().round());
        let corner = |x: f64, y: f64| {
            let point = Vector3::new(middle.x + x * radius, middle.y + y * radius, height);
            (self.eye.sees(&point), [x, y])
        };
        let [a, b, c, d] = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        let width = self.lens.size[0];
        for triangle in [[a, b, c], [a, c, d]] {
            self.fill(&triangle, |sample| {
                let [x, y] = sample.values;
                let tile =
                    |unit: f64, middle: f64| ((unit * radius + middle) / spacing).floor() as i64;
                let parity = (tile(x, middle.x) + tile(y, middle.y)).rem_euclid(2) as usize;
                let fade = ((x.hypot(y) - FADE) / (1.0 - FADE)).clamp(0.0, 1.0);
                let shade = if shadow[sample.y * width + sample.x] {
                    SHADE
                } else {
                    1.0
                };
                let of = |k: usize| TILES[parity][k] * shade * (1.0 - fade) + BACKGROUND[k] * fade;
                Some([of(0), of(1), of(2)].map_each(number))
            });
        }
    }

    /// The mean of the samples of each pixel.
    fn finish(self) -> Picture {
        let PictureOptions { width, height, .. } = self.options;
        let mut pixels = Vec::with_capacity(3 * width as usize * height as usize);
        for y in 0..height as usize {
            for x in 0..width as usize {
                let mut sum = [0; 3];
                for k in 0..SAMPLES * SAMPLES {
                    let row = y * SAMPLES + k / SAMPLES;
                    let sample = self.colors[row * self.lens.size[0] + x * SAMPLES + k % SAMPLES];
                    (0..3).for_each(|c| sum[c] += usize::from(sample[c]));
                }
                pixels.extend(sum.map_each(|sum| (sum / (SAMPLES * SAMPLES)) as u8));
            }
        }
        Picture {
            width,
            height,
            pixels,
        }
    }
}

/// A part of the brightest as a number of the screen.
fn number(part: f64) -> u8 {
    (255.0 * part).round() as u8
}

/// Light of a surface towards the eye, as the HTML viewer computes it; open meshes show their inner sides.
fn lit(normal: &Vector3<f64>, to_eye: &Vector3<f64>, color: &[f64; 4]) -> [f64; 3] {
    let (sun, v) = (Vector3::from(TO_SUN).normalize(), to_eye.normalize());
    let n = if normal.dot(&v) < 0.0 {
        -normal
    } else {
        *normal
    };
    let direct = n.dot(&sun).max(0.0);
    let shine = SHINE * direct * n.dot(&(sun + v).normalize()).max(0.0).powi(GLOSS);
    let up = 0.5 + 0.5 * n.z;
    [0, 1, 2].map_each(|k| {
        let sky = SKY[0][k] + (SKY[1][k] - SKY[0][k]) * up;
        color[k].clamp(0.0, 1.0).powf(GAMMA) * (sky + SUN[k] * direct) + shine
    })
}

/// Steps of light between dark and bright.
const LEVELS: usize = 1024;

/// The number of the screen for each level of light.
fn screen_of_light() -> [u8; LEVELS] {
    let of = |k: usize| 255.0 * (k as f64 / (LEVELS - 1) as f64).powf(1.0 / GAMMA);
    from_each(|k| of(k).round() as u8)
}
