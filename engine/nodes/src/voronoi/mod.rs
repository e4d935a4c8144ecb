//! The Voronoi texture: one point in each cell of a lattice, and the nearest of them.

mod space;

use crate::choice::choices;
use crate::noise::Dimensions;
use glam::{Vec2, Vec3A, Vec4};
use space::Space;

choices! {
    /// The feature of the points that is computed.
    pub(crate) Feature {
        First = "F1",
        Second = "F2",
        SmoothFirst = "SMOOTH_F1",
        Edge = "DISTANCE_TO_EDGE",
        SphereRadius = "N_SPHERE_RADIUS",
    }
}

choices! {
    /// The metric of the distance to a point.
    pub(crate) Metric {
        Euclidean = "EUCLIDEAN",
        Manhattan = "MANHATTAN",
        Chebychev = "CHEBYCHEV",
        Minkowski = "MINKOWSKI",
    }
}

choices! {
    /// The hash that scatters the points: Blender has changed it, and with it all pictures but those in one dimension.
    pub(crate) CellHash { Lookup3 = "LOOKUP3", Pcg = "PCG" }
}

/// The settings that do not depend on the place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Voronoi {
    pub(crate) hash: CellHash,
    pub(crate) feature: Feature,
    pub(crate) metric: Metric,
    pub(crate) normalize: bool,
    pub(crate) scale: f32,
    pub(crate) detail: f32,
    pub(crate) roughness: f32,
    pub(crate) lacunarity: f32,
    pub(crate) smoothness: f32,
    pub(crate) exponent: f32,
    pub(crate) randomness: f32,
}

/// The outputs of the node. `distance` is the radius for [`Feature::SphereRadius`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Nearest {
    pub(crate) distance: f32,
    pub(crate) colour: Vec3A,
    pub(crate) position: Vec4,
}

/// The result of one octave.
struct OctaveResult<P> {
    distance: f32,
    colour: Vec3A,
    position: P,
}

fn mix<T: std::ops::Add<Output = T> + std::ops::Sub<Output = T> + std::ops::Mul<f32, Output = T> + Copy>(
    a: T,
    b: T,
    t: f32,
) -> T {
    a + (b - a) * t
}

impl Voronoi {
    /// The texture at a place before scaling.
    pub(crate) fn at(mut self, dimensions: Dimensions, p: Vec3A, w: f32) -> Nearest {
        self.detail = self.detail.clamp(0.0, 15.0);
        self.roughness = self.roughness.clamp(0.0, 1.0);
        self.randomness = self.randomness.clamp(0.0, 1.0);
        self.smoothness = (self.smoothness / 2.0).clamp(0.0, 0.5);
        let (p, w) = (p * self.scale, w * self.scale);
        match dimensions {
            Dimensions::One => self.inside(w),
            Dimensions::Two => self.inside(Vec2::new(p.x, p.y)),
            Dimensions::Three => self.inside(p),
            Dimensions::Four => self.inside(p.extend(w)),
        }
    }

    fn inside<P: Space>(&self, p: P) -> Nearest {
        match self.feature {
            Feature::Edge => Nearest { distance: self.edge_octaves(p), ..Nearest::default() },
            Feature::SphereRadius => Nearest { distance: self.sphere_radius(p), ..Nearest::default() },
            _ => self.octaves(p),
        }
    }

    /// True if there are no octaves beyond the first.
    fn is_plain(&self) -> bool {
        self.detail == 0.0 || self.roughness == 0.0
    }

    fn octaves<P: Space>(&self, p: P) -> Nearest {
        let (mut amplitude, mut most, mut frequency) = (1.0, 0.0, 1.0);
        let (mut distance, mut colour, mut position) = (0.0, Vec3A::ZERO, P::ZERO);
        for octave in 0..=self.detail.ceil() as i32 {
            let found = match self.feature {
                Feature::Second => self.second(p * frequency),
                Feature::SmoothFirst if self.smoothness != 0.0 => self.smooth_first(p * frequency),
                _ => self.first(p * frequency),
            };
            if self.is_plain() {
                (most, distance, colour, position) = (1.0, found.distance, found.colour, found.position);
                break;
            }
            let place = mix(position, found.position * (1.0 / frequency), amplitude);
            if octave as f32 <= self.detail {
                most += amplitude;
                distance += found.distance * amplitude;
                colour += found.colour * amplitude;
                position = place;
                frequency *= self.lacunarity;
                amplitude *= self.roughness;
            } else {
                let rest = self.detail - self.detail.floor();
                most = mix(most, most + amplitude, rest);
                distance = mix(distance, distance + found.distance * amplitude, rest);
                colour = mix(colour, colour + found.colour * amplitude, rest);
                position = mix(position, place, rest);
            }
        }
        if self.normalize {
            distance /= most * self.farthest::<P>();
            colour /= most;
        }
        let shrink = if self.scale == 0.0 { 0.0 } else { 1.0 / self.scale };
        Nearest { distance, colour, position: position.outputs() * shrink }
    }

    /// The greatest distance that there can be, about.
    fn farthest<P: Space>(&self) -> f32 {
        let reach = P::splat(0.5 + 0.5 * self.randomness).distance(P::ZERO, self.metric, self.exponent);
        if self.feature == Feature::Second { 2.0 * reach } else { reach }
    }

    fn distance<P: Space>(&self, a: P, b: P) -> f32 {
        a.distance(b, self.metric, self.exponent)
    }

    fn near_points<P: Space>(&self, cell: P) -> P::Near {
        P::near_points(cell, self.hash, self.randomness)
    }

    /// The point of a cell, from the corner of the cell at `offset` 0.
    fn point<P: Space>(&self, cell: P, offset: P) -> P {
        offset + P::point(cell + offset, self.hash) * self.randomness
    }

    fn first<P: Space>(&self, p: P) -> OctaveResult<P> {
        let cell = p.floor();
        let local = p - cell;
        let (mut least, mut nearest, mut at) = (f32::MAX, P::ZERO, P::ZERO);
        for (offset, &point) in P::near().zip(self.near_points(cell).as_ref()) {
            let distance = self.distance(point, local);
            if distance < least {
                (least, nearest, at) = (distance, offset, point);
            }
        }
        OctaveResult { distance: least, colour: P::colour(cell + nearest, self.hash), position: at + cell }
    }

    fn second<P: Space>(&self, p: P) -> OctaveResult<P> {
        let cell = p.floor();
        let local = p - cell;
        let mut first = (f32::MAX, P::ZERO, P::ZERO);
        let mut second = first;
        for (offset, &point) in P::near().zip(self.near_points(cell).as_ref()) {
            let distance = self.distance(point, local);
            if distance < first.0 {
                second = first;
                first = (distance, offset, point);
            } else if distance < second.0 {
                second = (distance, offset, point);
            }
        }
        OctaveResult { distance: second.0, colour: P::colour(cell + second.1, self.hash), position: second.2 + cell }
    }

    fn smooth_first<P: Space>(&self, p: P) -> OctaveResult<P> {
        let cell = p.floor();
        let local = p - cell;
        let (mut smooth, mut colour, mut position) = (0.0, Vec3A::ZERO, P::ZERO);
        let points = P::wider_points(cell, self.hash, self.randomness);
        for (number, (offset, &point)) in P::wider().zip(points.as_ref()).enumerate() {
            let distance = self.distance(point, local);
            let share = match number {
                0 => 1.0,
                _ => smoothstep(0.5 + 0.5 * (smooth - distance) / self.smoothness),
            };
            if share == 0.0 {
                continue;
            }
            let mut correction = self.smoothness * share * (1.0 - share);
            smooth = mix(smooth, distance, share) - correction;
            correction /= 1.0 + 3.0 * self.smoothness;
            colour = mix(colour, P::colour(cell + offset, self.hash), share) - correction;
            position = mix(position, point, share) - correction;
        }
        OctaveResult { distance: smooth, colour, position: cell + position }
    }

    fn edge_octaves<P: Space>(&self, p: P) -> f32 {
        let farthest = 0.5 + 0.5 * self.randomness;
        let (mut amplitude, mut most, mut frequency, mut distance) = (1.0, farthest, 1.0, 8.0);
        for octave in 0..=self.detail.ceil() as i32 {
            let found = self.edge(p * frequency);
            if self.is_plain() {
                distance = found;
                break;
            }
            let (nearer, lesser) = (
                mix(distance, f32::min(distance, found / frequency), amplitude),
                mix(most, farthest / frequency, amplitude),
            );
            if octave as f32 <= self.detail {
                (most, distance) = (lesser, nearer);
                frequency *= self.lacunarity;
                amplitude *= self.roughness;
            } else {
                let rest = self.detail - self.detail.floor();
                most = mix(most, lesser, rest);
                distance = mix(distance, distance.min(nearer), rest);
            }
        }
        if self.normalize { distance / most } else { distance }
    }

    /// Distance to the nearest place that is equally far from two points.
    fn edge<P: Space>(&self, p: P) -> f32 {
        // Directions between points closer than this are not trusted.
        const LEAST_SQUARE: f32 = 0.0001;
        let cell = p.floor();
        let local = p - cell;
        if P::DIMENSIONS == 1 {
            return self.edge_on_a_line(cell, local);
        }
        let points = self.near_points(cell);
        let (mut least, mut to_nearest) = (f32::MAX, P::ZERO);
        for &point in points.as_ref() {
            let to_point = point - local;
            let square = to_point.dot(to_point);
            if square < least {
                (least, to_nearest) = (square, to_point);
            }
        }
        let mut edge = f32::MAX;
        for &point in points.as_ref() {
            let to_point = point - local;
            let across = to_point - to_nearest;
            let square = across.dot(across);
            if square > LEAST_SQUARE {
                edge = edge.min(((to_nearest + to_point) * 0.5).dot(across * (1.0 / square.sqrt())));
            }
        }
        edge
    }

    /// The distance to the edge in one dimension, where Blender looks at the own cell's point and its two neighbours.
    fn edge_on_a_line<P: Space>(&self, cell: P, local: P) -> f32 {
        let middle = self.point(cell, P::ZERO);
        let edges = [-1.0, 1.0].map(|side| {
            let beside = self.point(cell, P::splat(side));
            ((middle + beside) * 0.5 - local).length()
        });
        edges[0].min(edges[1])
    }

    /// Half the distance from the nearest point to the point nearest to that.
    fn sphere_radius<P: Space>(&self, p: P) -> f32 {
        let cell = p.floor();
        let local = p - cell;
        let mut nearest = (f32::MAX, P::ZERO, P::ZERO);
        for (offset, &point) in P::near().zip(self.near_points(cell).as_ref()) {
            let distance = (point - local).length();
            if distance < nearest.0 {
                nearest = (distance, offset, point);
            }
        }
        let mut least = f32::MAX;
        for offset in P::near() {
            if offset.dot(offset) == 0.0 {
                continue;
            }
            least = least.min((self.point(cell, offset + nearest.1) - nearest.2).length());
        }
        least / 2.0
    }
}

fn smoothstep(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
