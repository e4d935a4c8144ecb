# Intersection with a plane: Conic::meet of engine/optics/src/surface/conic.rs with curvature 0 and side 1.
#
# Domain: the ray comes from either side of the plane, at any angle: D's z from 2^-20 to 1. The unit of length is a power of two that is
# no smaller than the coordinates of P and the way T to the plane. Lower bounds of |P's z| and |T| exclude underflow.
#
# COS = D's z, for it is the root of the square of a positive number; Gappa is told.
#
# title: plane
# domain: D's z from 2^-20
# measured: Points, ordinary
# goal t: t -/ T, of the way
# goal point: x - X, of 1
# goal height: z - Z, of 1
# case f64: t 3.6, point 6.6, height 6.6
# case f32: t 3.5, point 6.6, height 6.6

@rnd = float<FORMAT, ne>;
px = rnd(px_); pz = rnd(pz_);
dx = rnd(dx_); dz = rnd(dz_);

# b = 0 - D's z and cc = 0 - (P's z + P's z): without rounding. q = b * b - 0 * cc.
cc = -2 * pz;
q rnd= dz * dz;
cosine rnd= sqrt(q);
den rnd= cosine + dz;
t rnd= cc / den;
x rnd= px + dx * t;
z rnd= pz + dz * t;

Q = dz * dz;
COS = sqrt(Q);
DEN = COS + dz;
T = cc / DEN;
X = px + dx * T;
Z = pz + dz * T;

{
  dz in [1b-20, 1.001]
  /\ |dx| <= 1.001
  /\ |px| <= 1 /\ |pz| in [1b-60, 1]
  /\ |T| in [1b-60, 1]
  # follows:
  /\ COS in [1b-20, 1.001]
  /\ COS -/ dz in [0, 0]
  -> GOALS
}
