//! Photographs of several seeds against the truth, pixel by pixel, in units of their own noise.

use super::exact::Truth;
use super::studio::{Exposure, shoot};
use petzval_render::camera::CameraDescription;
use petzval_render::integrator::PreparedScene;
use std::sync::Arc;

/// Photographs of each kind.
pub(crate) const SEEDS: u32 = 4;

/// Several photographs together.
pub(crate) struct Mean {
    /// Mean and the variance of that mean, by pixel and channel.
    pub(crate) pixels: Vec<[[f64; 2]; 3]>,
    size: [usize; 2],
    shots: Vec<Vec<[f64; 3]>>,
}

pub(crate) fn photographs(stage: &Arc<PreparedScene>, d: &CameraDescription, e: &Exposure) -> Mean {
    let shots: Vec<_> = (0..SEEDS).map(|k| shoot(stage, d, e, 100 + k)).collect();
    let n = f64::from(SEEDS);
    let one = |i: usize, c: usize| {
        let mean = shots.iter().map(|s| s[i][c]).sum::<f64>() / n;
        [mean, shots.iter().map(|s| (s[i][c] - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))]
    };
    let pixels = (0..shots[0].len()).map(|i| [0, 1, 2].map(|c| one(i, c))).collect();
    Mean { pixels, size: e.pixels.map(|p| p as usize), shots }
}

/// The fit of photographs to the truth.
#[derive(Debug)]
pub(crate) struct Fit {
    /// Mean of the squared differences over their variances, over the pixels where light is expected.
    pub(crate) chi2: f64,
    /// Number of pixels where light is expected.
    pub(crate) pixels: usize,
    /// The photographs' light over the truth's, and its standard error.
    pub(crate) light: [f64; 2],
    /// The part of the light that lies where neither a pixel nor its neighbours have any by exact rays.
    pub(crate) beyond: f64,
}

/// A pixel that is compared.
struct Pixel {
    truth: f64,
    /// Variance of the truth, if its rays were random.
    truth_error2: f64,
    value: f64,
    error2: f64,
}

impl Mean {
    /// One channel about one lamp: pixels further than `reach` from the lamp's own belong to other lamps.
    pub(crate) fn fit(&self, truth: &Truth, channel: usize, reach: f64) -> Fit {
        let [width, height] = self.size;
        let middle = truth.centroids[channel];
        let mut compared = Vec::new();
        let mut lights = vec![0.0; self.shots.len()];
        let (mut pixels_error2, mut expected, mut beyond) = (0.0, 0.0, 0.0);
        let brightest = truth.counts.iter().map(|c| c[channel]).max().unwrap_or(0);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let away = [x as f64 + 0.5 - middle.x, y as f64 + 0.5 - middle.y];
            if away[0].abs().max(away[1].abs()) > reach {
                continue;
            }
            let i = y * width + x;
            let (truth_value, count, [value, error2]) =
                (truth.pixels[i][channel], truth.counts[i][channel], self.pixels[i][channel]);
            (pixels_error2, expected) = (pixels_error2 + error2, expected + truth_value);
            lights.iter_mut().zip(&self.shots).for_each(|(light, shot)| *light += shot[i][channel]);
            let columns = x.saturating_sub(1)..(x + 2).min(width);
            let is_near = (y.saturating_sub(1)..(y + 2).min(height))
                .any(|j| columns.clone().any(|k| truth.counts[j * width + k][channel] > 0));
            if !is_near {
                beyond += value.abs();
            }
            // Darker pixels have too few hits to have a normal distribution.
            if count * 16 > brightest {
                let truth_error2 = truth.squares[i][channel];
                compared.push(Pixel { truth: truth_value, truth_error2, value, error2 });
            }
        }
        // Few hits tell a pixel's own variance badly. It is in proportion to that of the truth, whose rays weigh as
        // much as the camera's; all pixels together tell by what factor.
        let sum = |of: fn(&Pixel) -> f64| compared.iter().map(of).sum::<f64>();
        let factor = sum(|p| p.error2) / sum(|p| p.truth_error2);
        let score2 = |p: &Pixel| (p.value - p.truth).powi(2) / ((factor + 1.0) * p.truth_error2);
        // By the pixels, and, as light of one path may reach several, by the photographs, which are few.
        let n = lights.len() as f64;
        let light = lights.iter().sum::<f64>() / n;
        let shots_error2 = lights.iter().map(|l| (l - light).powi(2)).sum::<f64>() / (n * (n - 1.0));
        Fit {
            chi2: compared.iter().map(score2).sum::<f64>() / compared.len() as f64,
            pixels: compared.len(),
            light: [light / expected, shots_error2.max(pixels_error2).sqrt() / expected],
            beyond: beyond / expected,
        }
    }
}

impl Fit {
    /// The standard deviation of chi2 is the root of 2 / pixels, 0.1 to 0.2. It lies a little above 1 where samples lie evenly:
    /// that leaves the inside of a spot less noise than its edge. The light's own noise is known roughly; the truth's is
    /// 0.2 %.
    fn is_good(&self) -> bool {
        self.pixels >= 12
            && self.chi2 < 1.2 + 5.0 * (2.0 / self.pixels as f64).sqrt()
            && (self.light[0] - 1.0).abs() < 5.0 * self.light[1] + 0.002
            && self.beyond < 1e-3
    }

    pub(crate) fn check(&self, what: &str) {
        println!("{what}: {self:.3?}");
        assert!(self.is_good(), "{what}: {self:?}");
    }

    /// Asserts that a wrong picture is told from the truth.
    pub(crate) fn check_not(&self, what: &str) {
        println!("not {what}: {self:.3?}");
        assert!(!self.is_good(), "{what} fits as well: {self:?}");
    }
}
