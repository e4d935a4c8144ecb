//! How much each way of making a path counts: the power heuristic over all of them, from sums that grow with the path.
//!
//! A path has the scattering places v1 (seen by the camera) to vk (lit by the source), a direction from v1 to the lens
//! and one from vk to the source. The camera's side makes v1 ... vj, the light's side the rest. Let a_i be the density,
//! per unit of area, with which the camera's side chooses v_i, b_i that of the light's side; a_1 and b_k include the
//! direction at the path's end. Making v1 ... vj from the camera has the density a_1 ... a_j b_(j+1) ... b_k, and the sum
//! over all others, in units of the technique in hand, falls apart into a part for either side. A side keeps two numbers
//! ([`Partial`]), so that its part is
//!
//!   b_j² (ends + p_j² before)
//!
//! once the density b_j of its last place, and p_j, the density with which the other side would go on from there, are
//! known (Georgiev 2012, "Implementing Vertex Connection and Merging", where they are called dVCM and dVC). A mirror
//! cannot be connected to: its terms drop out, its densities cancel. The chances of ending a path early, and of passing
//! a transparent surface, are left out of all densities alike.

/// What a side knows of the techniques that end in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Partial {
    /// Of the technique that connects just before the last place.
    pub(super) ends: f64,
    /// Of all before that.
    pub(super) before: f64,
}

impl Partial {
    /// Of the first place of a side: `density` is its own, `other` that with which the end is chosen when the other side
    /// makes this place; `again` is 1 where the end may also be met by chance, else 0.
    pub(super) fn first(density: f64, other: f64, again: f64) -> Self {
        let inverse2 = (1.0 / density).powi(2);
        Self { ends: inverse2 * other * other, before: inverse2 * again }
    }

    /// On a ray that leaves the last place, chosen with `pdf` per steradian, at `cos_out` to the triangle's normal; back
    /// along the path the other side would go with `back_pdf`.
    pub(super) fn scattered(self, pdf: f32, cos_out: f32, back_pdf: f32) -> Self {
        let inverse = 1.0 / f64::from(pdf);
        let ratio = f64::from(cos_out) * inverse;
        Self { ends: inverse * inverse, before: ratio * ratio * (self.ends + squared(back_pdf) * self.before) }
    }

    /// On a ray that was mirrored or bent at the last place.
    pub(super) fn mirrored(self, cos_out: f32) -> Self {
        Self { ends: 0.0, before: squared(cos_out) * self.before }
    }

    /// At the place where that ray arrives after `distance`, at `cos_in` to the triangle's normal.
    pub(super) fn arrived(self, distance: f32, cos_in: f32) -> Self {
        let per_cos2 = 1.0 / squared(cos_in);
        Self { ends: self.ends * per_cos2 * squared(distance).powi(2), before: self.before * per_cos2 }
    }

    /// The sum over this side's techniques, where the other side reaches the last place with `density` per unit of area
    /// and goes on with `back_pdf`.
    pub(super) fn others(self, density: f64, back_pdf: f32) -> f64 {
        density * density * (self.ends + squared(back_pdf) * self.before)
    }
}

/// The weight of a technique beside which the sum of all others is `others`.
pub(super) fn weight(others: f64) -> f32 {
    (1.0 / (1.0 + others)) as f32
}

#[inline]
pub(super) fn squared(x: f32) -> f64 {
    f64::from(x) * f64::from(x)
}
