//! The list of the kinds of lamp. A kind is a file beside this one, an implementation of [`super::shape::LampShape`]; it is added to
//! [`AnyShape`], to its conversion, and to [`with_shape`].

use super::area::AreaLamp;
use super::ball::Ball;
use super::point::PointLamp;
use super::spot::SpotLamp;
use super::sun::SunLamp;
use crate::scene::lamp::LampKind;

/// The shape of a lamp of any kind.
#[derive(Clone, Copy, Debug)]
pub(super) enum AnyShape {
    Point(PointLamp),
    Spot(SpotLamp),
    Sun(SunLamp),
    Area(AreaLamp),
}

impl From<LampKind> for AnyShape {
    fn from(kind: LampKind) -> Self {
        match kind {
            LampKind::Point { radius, soft } => Self::Point(PointLamp(Ball { radius, soft })),
            LampKind::Spot { radius, half_angle_rad, blend, soft } => {
                Self::Spot(SpotLamp { ball: Ball { radius, soft }, half_angle_rad, blend })
            }
            LampKind::Sun { half_angle_rad } => Self::Sun(SunLamp { half_angle_rad }),
            LampKind::Area { size, ellipse, half_spread_rad } => {
                Self::Area(AreaLamp { size, ellipse, half_spread_rad })
            }
        }
    }
}

/// Evaluates an expression of the [`super::shape::LampShape`] in an [`AnyShape`], compiled for each kind.
macro_rules! with_shape {
    ($any:expr, $shape:ident => $value:expr) => {
        match &$any {
            AnyShape::Point($shape) => $value,
            AnyShape::Spot($shape) => $value,
            AnyShape::Sun($shape) => $value,
            AnyShape::Area($shape) => $value,
        }
    };
}
pub(super) use with_shape;
