//! Surfaces that catch shadows: the picture is to be laid over a photograph, and holds the part of light that they lose.
//!
//! The scene is rendered twice, as in Cycles: with all that is in it and with those surfaces alone; the shadow is the ratio of the first to
//! the second (manual of Cycles, "Shadow Catcher"). Both by the same rays and random numbers, so noise that they share cancels.

use super::Job;
use crate::Rgb;
use crate::integrator::path::parts::LightPass;

/// The parts that are kept of the render of everything, for [`Job::shadow`] and [`Job::over_photograph`].
pub const PARTS: [LightPass; 2] = [LightPass::Caught, LightPass::Catches];

/// Settings for laying the picture over a photograph.
#[derive(Clone, Copy, Debug)]
pub struct Laying {
    /// True if the film is opaque.
    pub is_opaque: bool,
    /// True if the shadow is a pass of its own, and not in the picture.
    pub is_apart: bool,
    /// True for the picture with its noise.
    pub is_noisy: bool,
}

/// A pixel of the two renders.
#[derive(Clone, Copy)]
struct Pixel {
    /// Light that the surfaces that catch shadows scatter, and the light that they scatter when alone.
    caught: Rgb,
    lit: Rgb,
    /// The picture of everything.
    light: Rgb,
    alpha: f32,
    /// Shares of its rays that found such a surface, and that found any.
    catches: f32,
    finds: f32,
}

impl Pixel {
    /// The part of the light that is left in the shadow.
    fn shadow(&self) -> Rgb {
        let left = Rgb::select(self.lit.cmpne(Rgb::ZERO), self.caught / self.lit, Rgb::ONE);
        (1.0 - self.alpha) + self.alpha * left
    }

    /// Light and alpha without those surfaces, with the mean of their shadow.
    fn laid(&self, laying: Laying) -> (Rgb, f32) {
        let seen = if laying.is_opaque { 1.0 } else { self.finds };
        let others = if seen == 0.0 { 1.0 } else { 1.0 - self.catches / seen };
        let alpha = self.alpha * others;
        let dark = if laying.is_apart { 0.0 } else { 1.0 - (self.shadow().element_sum() / 3.0).clamp(0.0, 1.0) };
        (self.light - self.caught, (1.0 - alpha) * dark + alpha)
    }
}

impl Job {
    /// The pixels of this render of everything and of that of shadow catchers `alone`; `None` if this keeps not [`PARTS`].
    fn pixels_beside(&self, alone: &Self, is_noisy: bool) -> Option<impl Iterator<Item = Pixel>> {
        let (caught, picture, lit) = match is_noisy {
            false => (self.caught()?, self.picture(), alone.straight()),
            true => (self.part(PARTS[0])?, self.noisy_picture(), alone.film().picture()),
        };
        let kept = caught.into_iter().zip(self.part(PARTS[1])?);
        let seen = picture.into_iter().zip(lit);
        Some(kept.zip(seen).map(|((caught, [catches, finds, _]), ([r, g, b, alpha], [lit_r, lit_g, lit_b, _]))| {
            Pixel {
                caught: caught.into(),
                lit: Rgb::new(lit_r, lit_g, lit_b),
                light: Rgb::new(r, g, b),
                alpha,
                catches,
                finds,
            }
        }))
    }

    /// The part of the light that is left on shadow catchers, rows from below; 1 where none is seen. `None` if this keeps not [`PARTS`].
    pub fn shadow(&self, alone: &Self) -> Option<Vec<[f32; 3]>> {
        Some(self.pixels_beside(alone, false)?.map(|pixel| pixel.shadow().into()).collect())
    }

    /// The picture to be laid over a photograph: shadow catchers are transparent, and the mean of their shadow is alpha. Where there is a
    /// render of the `sky` it is laid over that. `None` if this keeps not [`PARTS`].
    pub fn over_photograph(&self, alone: &Self, sky: Option<&Self>, laying: Laying) -> Option<Vec<[f32; 4]>> {
        let laid = self.pixels_beside(alone, laying.is_noisy)?.map(|pixel| pixel.laid(laying));
        let Some(sky) = sky else {
            return Some(laid.map(|(light, alpha)| light.extend(alpha).into()).collect());
        };
        let over = laid
            .zip(if laying.is_noisy { sky.film().picture() } else { sky.straight() })
            .map(|((light, alpha), [r, g, b, _])| (light + Rgb::new(r, g, b) * (1.0 - alpha)).extend(1.0).into());
        Some(over.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALONE: Pixel =
        Pixel { caught: Rgb::ONE, lit: Rgb::ONE, light: Rgb::ONE, alpha: 1.0, catches: 1.0, finds: 1.0 };
    const LAYING: Laying = Laying { is_opaque: false, is_apart: false, is_noisy: false };

    /// A floor in full light leaves nothing; in the dark it blackens the photograph beneath; half of it half.
    #[test]
    fn only_the_shadow_is_left_of_a_floor() {
        for (left, light) in [(1.0, 0.0), (0.0, 0.0), (0.5, 0.0)] {
            let pixel = Pixel { caught: Rgb::splat(left), light: Rgb::splat(left), ..ALONE };
            assert_eq!(pixel.laid(LAYING), (Rgb::splat(light), 1.0 - left));
            assert_eq!(pixel.shadow(), Rgb::splat(left));
            assert_eq!(pixel.laid(Laying { is_apart: true, ..LAYING }), (Rgb::splat(light), 0.0));
        }
    }

    /// Half a pixel of something else stays, and hides half of the photograph beneath.
    #[test]
    fn what_throws_the_shadow_stays() {
        let pixel = Pixel { caught: Rgb::splat(0.5), lit: Rgb::ONE, light: Rgb::splat(2.0), catches: 0.5, ..ALONE };
        let (light, alpha) = pixel.laid(Laying { is_apart: true, ..LAYING });
        assert_eq!((light, alpha), (Rgb::splat(1.5), 0.5));
    }

    /// Pixels without a catcher or without light have no shadow.
    #[test]
    fn nothing_throws_no_shadow() {
        let sky = Pixel { caught: Rgb::ZERO, lit: Rgb::ZERO, light: Rgb::ZERO, alpha: 0.0, catches: 0.0, finds: 0.0 };
        assert_eq!((sky.shadow(), sky.laid(LAYING)), (Rgb::ONE, (Rgb::ZERO, 0.0)));
        assert_eq!(Pixel { alpha: 1.0, ..sky }.shadow(), Rgb::ONE);
    }
}
