//! Blur of moving objects, and of a lens that changes, while the shutter is open.

use super::LensEffect;
use crate::plan::choice::CameraChoice;
use crate::plan::measured::{Known, Measured};
use crate::plan::motion::SceneMotion;

pub(super) struct MotionBlur;

impl LensEffect for MotionBlur {
    fn name(&self) -> &'static str {
        "motion_blur"
    }

    fn is_of_rays(&self) -> bool {
        false
    }

    fn measure(&self, known: &Known<'_>) -> Measured {
        match (known.motion, &known.scene_motion) {
            (Some(lens), None) => Measured::at(lens, self.unit()),
            (Some(lens), Some(motion)) if lens.value > motion.px => Measured::at(lens, self.unit()),
            (_, Some(SceneMotion { px, text })) => Measured::new(*px, text.clone()),
            (None, None) => Measured::nothing("everything stands still"),
        }
    }

    fn is_simulated(&self, choice: &CameraChoice, _known: &Known<'_>) -> bool {
        choice.is_moving
    }
}
