//! Radial Tiling: the plane about the origin cut into segments, one for each side of a polygon with rounded corners.
//!
//! As Blender has it (radial_tiling_shared.h in the kernel of Cycles): the apothem of the polygon of size 1 is 1. A number of sides that is not
//! whole has a last segment that is narrower, whose side is nearer the origin by the factor between the cosines of both half angles.

use glam::{Vec2, Vec3A};
use std::f32::consts::{PI, TAU};

/// The outputs of the node at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tile {
    /// Along the side, and away from the origin.
    pub(crate) coordinates: Vec3A,
    pub(crate) segment: f32,
    /// Half of the length of a side of the polygon of size 1.
    pub(crate) width: f32,
    /// The angle of the segment's middle.
    pub(crate) rotation: f32,
}

/// The polygon of size 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RadialTiling {
    sides: f32,
    roundness: f32,
    normalize: bool,
}

/// Along the side, away from the origin, half of the side's length, and the angle of the segment's middle.
type Found = [f32; 4];

/// Half of a side: from the corner, where two segments meet, to its middle.
#[derive(Clone, Copy)]
struct Half {
    /// The angle of all of it, and of its part that is rounded, both from the corner.
    angle: f32,
    rounded: f32,
    roundness: f32,
}

impl Half {
    /// Angles within which the rounded part runs over into the straight one.
    fn spline(self) -> f32 {
        (1.0 - self.roundness) * self.rounded
    }

    fn straight(self) -> f32 {
        self.angle - self.rounded
    }

    /// The length of the side in the polygon of size 1.
    fn width(self) -> f32 {
        self.straight().tan() + self.spline() + self.roundness * self.rounded
    }

    /// The length of the side in the polygon whose apothem is `apothem`.
    fn length(self, apothem: f32) -> f32 {
        apothem * self.straight().tan() + self.spline() * (0.5 * apothem + 0.5) + self.roundness * self.rounded
    }

    /// The way from the middle to a place of the rounded part: so far from the origin, at an angle from where it begins.
    fn way_to(self, distance: f32, angle: f32) -> f32 {
        let apothem = distance * self.straight().cos();
        let (beside, spline) = (distance * self.straight().sin(), self.spline());
        if angle < spline {
            beside + apothem * angle + 0.5 * (1.0 - apothem) * angle * angle / spline
        } else {
            beside + spline * (0.5 * apothem - 0.5) + angle
        }
    }

    /// The length of the side by which the way along it is normalized: it goes over from that of the apothem to that of the distance.
    fn length_at(self, apothem: f32, distance: f32, angle: f32) -> f32 {
        let by_distance = distance * self.straight().sin()
            + self.spline() * (0.5 * distance * self.straight().cos() + 0.5)
            + self.roundness * self.rounded;
        let part = angle / self.rounded;
        self.length(apothem) * (1.0 - part) + by_distance * part
    }
}

/// The place of a coordinate among the segments.
struct Place {
    distance: f32,
    /// The angles from the x axis, and from the beginning of the segment.
    turn: f32,
    within: f32,
    /// The angle at which its segment begins.
    begin: f32,
}

impl RadialTiling {
    pub(crate) fn new(sides: f32, roundness: f32, normalize: bool) -> Self {
        Self { sides: sides.max(2.0), roundness: roundness.clamp(0.0, 1.0), normalize }
    }

    /// The tile of a place; its z counts nothing.
    pub(crate) fn at(self, p: Vec3A) -> Tile {
        let at = Vec2::new(p.x, p.y);
        let angle = at.y.atan2(at.x);
        let turn = if at.y < 0.0 { angle + TAU } else { angle };
        let half = PI / self.sides;
        let begin = (turn / (2.0 * half)).floor() * 2.0 * half;
        let place = Place { distance: at.length(), turn, within: turn - begin, begin };
        let [mut along, mut away, width, rotation] = if self.sides.fract() == 0.0 {
            self.in_regular(&place, half)
        } else {
            self.in_irregular(&place, half, angle)
        };
        if at == Vec2::ZERO {
            along = 0.0;
        }
        if self.normalize {
            along = 0.5 * along + 0.5;
        } else {
            away -= 1.0;
        }
        let below = if at.y < 0.0 { 1.0 } else { 0.0 };
        let tile = Tile {
            coordinates: Vec3A::new(along, away, 0.0),
            segment: (self.sides * (angle / TAU + below)).floor(),
            width,
            rotation,
        };
        tile.finite()
    }

    fn half(self, angle: f32) -> Half {
        Half { angle, rounded: angle - ((1.0 - self.roundness) * angle.tan()).atan(), roundness: self.roundness }
    }

    /// The coordinates in a polygon of equal sides.
    fn in_regular(self, place: &Place, half: f32) -> Found {
        if self.sides == 2.0 && self.roundness == 0.0 {
            // Two half planes, whose sides have no end.
            let along = self.signed(self.straight_along(place, half, 1.0), place, half);
            return [along, place.distance * (half - place.within).cos(), 0.0, place.begin + half];
        }
        let side =
            if self.roundness == 1.0 { Half { angle: half, rounded: half, roundness: 1.0 } } else { self.half(half) };
        let is_rounded = self.roundness > 0.0
            && (place.within >= 2.0 * half - side.rounded || place.within < side.rounded || self.roundness == 1.0);
        if is_rounded { self.rounded(place, side) } else { self.straight(place, side, side) }
    }

    /// The coordinates in a straight part of a side; normalized by `length_of`.
    fn straight(self, place: &Place, side: Half, length_of: Half) -> Found {
        let apothem = place.distance * (side.angle - place.within).cos();
        let mut along = self.straight_along(place, side.angle, 1.0);
        if self.normalize {
            along /= length_of.length(apothem);
        }
        [self.signed(along, place, side.angle), apothem, side.width(), place.begin + side.angle]
    }

    /// The way along a straight side from its middle, whose apothem is the factor's part of that of a regular side.
    fn straight_along(self, place: &Place, half: f32, factor: f32) -> f32 {
        let angle = half - place.within;
        factor * place.distance * angle.cos() * angle.abs().tan()
    }

    /// The coordinates in a rounded corner between equal sides.
    fn rounded(self, place: &Place, side: Half) -> Found {
        let from_corner = if place.within > side.angle { place.within - 2.0 * side.angle } else { place.within };
        let centre = (1.0 - self.roundness) / side.angle.cos();
        let across = from_corner.cos() * centre;
        let edge = across + (across * across + self.roundness * self.roundness - centre * centre).sqrt();
        let apothem = place.distance / edge;
        let angle = side.rounded - from_corner.abs();
        let mut along = side.way_to(place.distance, angle);
        if self.normalize {
            along /= side.length_at(apothem, place.distance, angle);
        }
        [self.signed(along, place, side.angle), apothem, side.width(), place.begin + side.angle]
    }

    fn signed(self, along: f32, place: &Place, middle: f32) -> f32 {
        if place.within < middle { -along } else { along }
    }

    /// The coordinates in a polygon whose last side, which ends at the x axis, is narrower; `angle` is that from the x axis, signed.
    fn in_irregular(self, place: &Place, half: f32, angle: f32) -> Found {
        let last_half = PI - self.sides.floor() * half;
        let last_begin = TAU - 2.0 * last_half;
        // How much nearer the last side is.
        let factor = half.cos() / last_half.cos();
        if self.roundness == 0.0 {
            let side = Half { angle: half, rounded: 0.0, roundness: 0.0 };
            if place.turn < last_begin {
                return self.straight(place, side, side);
            }
            return self.last_straight(place, Half { angle: last_half, ..side }, factor, last_half.tan());
        }
        let (side, last) = (self.half(half), self.half(last_half));
        let circle = LastCorner::new(side, last);
        // The corners beside the last side: of the sides that they round.
        let outer_roundness = 1.0 - (half - circle.outer).tan() / half.tan();
        let outer = Half { angle: half, rounded: circle.outer, roundness: outer_roundness };
        if place.turn >= circle.outer && place.turn < last_begin - circle.outer {
            let is_next_to_last = place.turn >= last_begin - half || place.turn < half;
            let is_straight = (place.within >= side.rounded && place.within < 2.0 * half - side.rounded)
                || place.turn >= last_begin - side.rounded
                || place.turn < side.rounded;
            return match is_straight {
                true => self.straight(place, side, if is_next_to_last { outer } else { side }),
                false => self.rounded(place, side),
            };
        }
        let last_width =
            last.straight().tan() + factor * (last.spline() * (0.5 / factor + 0.5) + self.roundness * last.rounded);
        if place.turn >= last_begin + last.rounded && place.turn < TAU - last.rounded {
            return self.last_straight(place, last, factor, last_width);
        }
        // Mirrored about the middle of the last side, so that both of its corners are one.
        let is_first_corner = place.turn >= last_begin - circle.outer && place.turn < TAU - last_half;
        let from_corner = if is_first_corner { -(angle + 2.0 * last_half) } else { angle };
        let last_apothem = place.distance / circle.edge(from_corner);
        let apothem = factor * last_apothem;
        let (on, from_begin, scale) = if from_corner < 0.0 {
            (last, last.rounded - from_corner.abs(), factor)
        } else {
            (outer, outer.rounded - from_corner.abs(), 1.0)
        };
        let mut along = scale * on.way_to(place.distance, from_begin);
        if self.normalize {
            along /= scale * on.length_at(apothem / scale, place.distance, from_begin);
        }
        let width = if from_corner < 0.0 { last_width } else { side.width() };
        [self.signed(along, place, on.angle), apothem, width, place.begin + on.angle]
    }

    /// The coordinates in the straight part of the last side.
    fn last_straight(self, place: &Place, last: Half, factor: f32, width: f32) -> Found {
        let last_apothem = place.distance * (last.angle - place.within).cos();
        let mut along = self.straight_along(place, last.angle, factor);
        if self.normalize {
            along /= factor * last.length(last_apothem);
        }
        [self.signed(along, place, last.angle), factor * last_apothem, width, place.begin + last.angle]
    }
}

/// The circle that rounds the corner between a regular side and the last one, at the x axis.
struct LastCorner {
    centre: Vec2,
    radius: f32,
    /// The angle at which it ends on the regular side.
    outer: f32,
}

impl LastCorner {
    fn new(side: Half, last: Half) -> Self {
        let radius = last.roundness * last.angle.tan() / (0.5 * (side.angle + last.angle)).tan();
        let start = 1.0 / last.straight().cos();
        let centre = Vec2::new(
            last.rounded.cos() * start - radius * last.angle.cos(),
            radius * last.angle.sin() - last.rounded.sin() * start,
        );
        let end = centre + radius * Vec2::from_angle(side.angle);
        Self { centre, radius, outer: (end.y / end.x).atan() }
    }

    /// The distance of the corner's edge from the origin, in apothems of the last side, at an angle from the x axis.
    fn edge(&self, angle: f32) -> f32 {
        let across = Vec2::from_angle(angle).dot(self.centre);
        across + (across * across + self.radius * self.radius - self.centre.length_squared()).sqrt()
    }
}

impl Tile {
    /// The tile without numbers that are none: those are zero.
    fn finite(self) -> Self {
        let number = |v: f32| if v.is_finite() { v } else { 0.0 };
        Self {
            coordinates: Vec3A::from_array(self.coordinates.to_array().map(number)),
            segment: number(self.segment),
            width: number(self.width),
            rotation: number(self.rotation),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A place of the square about the origin, by hand.
    #[test]
    fn squares_have_their_sides_at_one() {
        let tiling = RadialTiling::new(4.0, 0.0, false);
        let tile = tiling.at(Vec3A::new(1.5, 1.0, 7.0));
        // The first side lies across the diagonal.
        let (along, away) = (-0.5 / 2f32.sqrt(), 2.5 / 2f32.sqrt() - 1.0);
        assert!((tile.coordinates - Vec3A::new(along, away, 0.0)).length() < 1e-5, "{tile:?}");
        assert_eq!(tile.segment, 0.0);
        assert!((tile.width - 1.0).abs() < 1e-6 && (tile.rotation - 0.25 * PI).abs() < 1e-6);
    }

    /// Distances away from the origin grow steadily, also where straight and rounded parts and the segments meet.
    #[test]
    fn edges_are_continuous() {
        for sides in [2.0, 3.0, 5.0, 3.4, 5.7, 2.3] {
            for roundness in [0.0, 0.3, 0.7, 1.0] {
                if sides == 2.0 && roundness > 0.0 {
                    continue;
                }
                let tiling = RadialTiling::new(sides, roundness, false);
                let at = |turn: f32| tiling.at(Vec3A::new(turn.cos(), turn.sin(), 0.0)).coordinates.y;
                let steps = 20_000u16;
                for step in 0..steps {
                    let [a, b] = [step, step + 1].map(|i| at(TAU * f32::from(i) / f32::from(steps)));
                    assert!((a - b).abs() < 2e-3, "{sides} sides, {roundness}: {a} and {b} at {step}");
                }
            }
        }
    }

    #[test]
    fn no_place_is_no_number() {
        for sides in [0.0, 2.0, 2.5, 3.0, f32::NAN, 1e9] {
            for roundness in [0.0, 0.5, 1.0, f32::NAN] {
                for p in [Vec3A::ZERO, Vec3A::X, -Vec3A::X, Vec3A::NAN, Vec3A::splat(1e30)] {
                    for normalize in [false, true] {
                        let tile = RadialTiling::new(sides, roundness, normalize).at(p);
                        assert!(tile.coordinates.is_finite() && tile.width.is_finite() && tile.rotation.is_finite());
                    }
                }
            }
        }
    }
}
