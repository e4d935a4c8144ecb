//! Triangles, eight at a time, and a test that leaves no gap between neighbours (Woo, Benthin and Wald 2013).

use fearless_simd::{Simd, SimdBase, SimdMask, f32x8};
use glam::{Vec3, Vec3A};

/// Triangles of a leaf at most.
pub(super) const LANES: usize = 8;

/// A leaf's triangles, a lane each.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(super) struct Block {
    /// Corners, then axes. NaN in lanes without a triangle.
    corners: [[[f32; LANES]; 3]; 3],
    /// Index into the scene's instances; of no meaning in trees of one mesh.
    pub(super) instance: [u32; LANES],
    /// Index into the mesh's triangles.
    pub(super) triangle: [u32; LANES],
}

/// The hits of a ray in the lanes of a block.
pub(super) struct Met {
    /// Lanes that the ray hits, as bits.
    pub(super) lanes: u32,
    /// Distances of the hits.
    pub(super) t: [f32; LANES],
    /// Weights of the second corner.
    pub(super) u: [f32; LANES],
    /// Weights of the third corner.
    pub(super) v: [f32; LANES],
}

impl Block {
    /// A block without triangles.
    pub(super) const EMPTY: Self =
        Self { corners: [[[f32::NAN; LANES]; 3]; 3], instance: [0; LANES], triangle: [0; LANES] };

    /// Puts a triangle into a lane.
    pub(super) fn set(&mut self, lane: usize, corners: &[Vec3; 3], [instance, triangle]: [u32; 2]) {
        for (to, p) in self.corners.iter_mut().zip(corners) {
            (0..3).for_each(|axis| to[axis][lane] = p[axis]);
        }
        self.instance[lane] = instance;
        self.triangle[lane] = triangle;
    }

    /// These triangles moved by a part of the way to their places in another block.
    #[inline(always)]
    pub(super) fn towards(&self, to: &Self, part: f32) -> Self {
        let mut now = self.clone();
        for (now, to) in now.corners.as_flattened_mut().iter_mut().zip(to.corners.as_flattened()) {
            for (now, to) in now.iter_mut().zip(to) {
                *now += (*to - *now) * part;
            }
        }
        now
    }

    pub(super) fn holds(&self, lane: usize) -> bool {
        !self.corners[0][0][lane].is_nan()
    }

    fn corners(&self, lane: usize) -> [Vec3; 3] {
        self.corners.map(|p| Vec3::new(p[0][lane], p[1][lane], p[2][lane]))
    }

    /// The triangles that a ray hits before `t_max`.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(&self, simd: S, ray: &Shear, t_max: f32) -> Option<Met> {
        let (ax, ay, az) = self.seen(simd, ray, 0);
        let (bx, by, bz) = self.seen(simd, ray, 1);
        let (cx, cy, cz) = self.seen(simd, ray, 2);
        // Without fused products: an edge must give its two triangles opposite numbers.
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        let (least, most) = (u.min(v).min(w), u.max(v).max(w));
        let zero = f32x8::splat(simd, 0.0);
        let inside = least.simd_ge(zero) | most.simd_le(zero);
        if !inside.any_true() {
            return None;
        }
        let det = u + v + w;
        let t = (u * az + v * bz + w * cz) * ray.sz / det;
        // On an edge as single precision sees it: double decides.
        let edge = (u.simd_eq(zero) | v.simd_eq(zero) | w.simd_eq(zero)) & inside;
        // Also refuses NaN, which a triangle seen exactly edge-on can give.
        let hit = inside & t.simd_gt(zero) & t.simd_lt(f32x8::splat(simd, t_max));
        let (edge, hit) = (edge.to_bitmask() as u32, hit.to_bitmask() as u32);
        let lanes = hit & !edge;
        if (lanes | edge) == 0 {
            return None;
        }
        let mut met = Met { lanes, t: t.to_array(), u: (v / det).to_array(), v: (w / det).to_array() };
        if edge != 0 {
            self.meet_edges(ray, t_max, edge, &mut met);
        }
        Some(met)
    }

    /// One corner of each triangle as the turned ray sees it. (A function, since closures are not inlined.)
    #[inline(always)]
    fn seen<S: Simd>(&self, simd: S, ray: &Shear, corner: usize) -> (f32x8<S>, f32x8<S>, f32x8<S>) {
        let corner = &self.corners[corner];
        let z = f32x8::load_array_ref(simd, &corner[ray.kz]) - ray.origin[ray.kz];
        let x = f32x8::load_array_ref(simd, &corner[ray.kx]) - ray.origin[ray.kx];
        let y = f32x8::load_array_ref(simd, &corner[ray.ky]) - ray.origin[ray.ky];
        (x - z * ray.sx, y - z * ray.sy, z)
    }

    #[cold]
    #[inline(never)]
    fn meet_edges(&self, ray: &Shear, t_max: f32, lanes: u32, met: &mut Met) {
        for lane in (0..LANES).filter(|&lane| lanes >> lane & 1 != 0) {
            if let Some((t, u, v)) = ray.intersect(&self.corners(lane), t_max) {
                met.lanes |= 1 << lane;
                (met.t[lane], met.u[lane], met.v[lane]) = (t, u, v);
            }
        }
    }
}

/// A ray turned so that it runs along +z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shear {
    origin: [f32; 3],
    kx: usize,
    ky: usize,
    kz: usize,
    sx: f32,
    sy: f32,
    sz: f32,
}

impl Shear {
    #[inline(always)]
    pub(super) fn new(origin: Vec3A, direction: Vec3A) -> Self {
        let a = direction.abs();
        let kz = if a.x > a.y && a.x > a.z {
            0
        } else if a.y > a.z {
            1
        } else {
            2
        };
        let (mut kx, mut ky) = ((kz + 1) % 3, (kz + 2) % 3);
        let d = direction.to_array();
        // Keeps the winding when the ray runs backwards.
        if d[kz] < 0.0 {
            std::mem::swap(&mut kx, &mut ky);
        }
        Self { origin: origin.into(), kx, ky, kz, sx: d[kx] / d[kz], sy: d[ky] / d[kz], sz: 1.0 / d[kz] }
    }

    /// Distance and the weights of the second and third corner, of either side: the edges in double precision, the
    /// same way for both neighbours.
    fn intersect(&self, corners: &[Vec3; 3], t_max: f32) -> Option<(f32, f32, f32)> {
        let local = corners.map(|p| {
            let p: [f32; 3] = std::array::from_fn(|axis| p[axis] - self.origin[axis]);
            (p[self.kx] - self.sx * p[self.kz], p[self.ky] - self.sy * p[self.kz], p[self.kz])
        });
        let [(ax, ay, az), (bx, by, bz), (cx, cy, cz)] = local;
        let cross = |px: f32, py: f32, qx: f32, qy: f32| (px as f64 * qy as f64 - py as f64 * qx as f64) as f32;
        let u = cross(cx, cy, bx, by);
        let v = cross(ax, ay, cx, cy);
        let w = cross(bx, by, ax, ay);
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let t = (u * az + v * bz + w * cz) * self.sz / det;
        (t > 0.0 && t < t_max).then(|| (t, v / det, w / det))
    }
}
