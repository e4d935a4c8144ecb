# Intersection with a sphere where nothing cancels: Conic::meet of engine/optics/src/surface/conic.rs with k = 0 and side 1, in the branch
# of q > B^2 / 100.
#
# Domain: the start P is within 0.99 radii of the vertex, as it is of a ray that was carried to its point nearest the vertex and hits the
# sphere within 59 degrees of the axis, seen from the centre. -B is the way along the ray from P to the point nearest the centre, in radii.
# The unit of length is the power of two that puts the curvature c into [1/2, 1]: the tracer's numbers change by that power alone.
# c < 0 is the mirror image.
#
# PXC and the like are the same in units of the radius. COS = |N D| is the cosine of incidence.
#
# title: sphere
# domain: cos i from FLOOR
# measured: Points, ordinary
# goal cosine: cosine - COS, of 1
# goal point: (x - X) * c, of the radius
# goal normal: nz - NZ, of 1
# case f64 FLOOR=0.5 LOW=0.25 HIGH=1.2 RHO=0.61: cosine 27, point 38, normal 41
# case f64 FLOOR=0.125 LOW=0.0625 HIGH=1.2 RHO=0.89: cosine 110, point 160, normal 170
# case f32 FLOOR=0.5 LOW=0.25 HIGH=1.2 RHO=0.61: cosine 27, point 38, normal 41
# case f32 FLOOR=0.125 LOW=0.0625 HIGH=1.2 RHO=0.89: cosine 110, point 160, normal 170

@rnd = float<FORMAT, ne>;
px = rnd(px_); py = rnd(py_); pz = rnd(pz_);
dx = rnd(dx_); dy = rnd(dy_); dz = rnd(dz_);
c = rnd(c_);

# P's z + P's z: a doubling, without rounding.
two_pz = 2 * pz;
along rnd= px * dx + py * dy + pz * dz;
across rnd= px * px + py * py + pz * pz;
b rnd= along * c - dz;
cc rnd= across * c - two_pz;
q rnd= b * b - c * cc;
cosine rnd= sqrt(q);
den rnd= cosine - b;
t rnd= cc / den;
# y has x's form, and z too, with other numbers: the bound of x is that of all three.
x rnd= px + dx * t;
z rnd= pz + dz * t;
nz rnd= z * c - 1;

ALONG = px * dx + py * dy + pz * dz;
ACROSS = px * px + py * py + pz * pz;
B = ALONG * c - dz;
CC = ACROSS * c - two_pz;
Q = B * B - c * CC;
COS = sqrt(Q);
DEN = COS - B;
T = CC / DEN;
X = px + dx * T;
Z = pz + dz * T;
NZ = Z * c - 1;

PXC = px * c; PYC = py * c; PZC = pz * c;
ALONG_XY = px * dx + py * dy;
ACROSS_XY = px * px + py * py;
ALONG_XYC = ALONG_XY * c; ALONGC = ALONG * c;
ACROSS_XYC = ACROSS_XY * (c * c); ACROSSC = ACROSS * (c * c);
CCC = CC * c; TC = T * c; XC = X * c; ZC = Z * c;
SHARE = TC / DEN;
ROOT = sqrt(q);
RATIO = cc / den;

{
  c in [0.5, 1]
  /\ |dx| <= 1.001 /\ |dy| <= 1.001 /\ |dz| <= 1.001
  /\ ACROSSC in [0, 0.98]
  /\ COS in [FLOOR, 1.001]
  /\ -B in [LOW, HIGH]
  # follows: from Cauchy and Schwarz, |P| <= 0.99 R and |D| <= 1.001;
  /\ |PXC| <= 0.99 /\ |PYC| <= 0.99 /\ |PZC| <= 0.99
  /\ |ALONG_XYC| <= 0.992 /\ |ALONGC| <= 0.992
  /\ ACROSS_XYC in [0, 0.98]
  # from Q = COS^2, c CC = B^2 - Q and c T = -B - COS;
  /\ Q in [FLOOR_SQUARED, 1.0021]
  /\ CCC in [-1.0021, HIGH_SQUARED]
  /\ |TC| <= HIGH
  /\ |SHARE| <= RHO
  # from |N| = 1 to the rounding of |D|.
  /\ |XC| <= 1.001 /\ |ZC| <= 1.001
  -> GOALS
}

px -> PXC / c { c <> 0 };
py -> PYC / c { c <> 0 };
pz -> PZC / c { c <> 0 };
ALONG -> ALONGC / c { c <> 0 };
ALONG_XY -> ALONG_XYC / c { c <> 0 };
ACROSS -> ACROSSC / (c * c) { c <> 0 };
ACROSS_XY -> ACROSS_XYC / (c * c) { c <> 0 };
CC -> CCC / c { c <> 0 };
T -> TC / c { c <> 0 };
X -> XC / c { c <> 0 };
Z -> ZC / c { c <> 0 };
# by square roots: ROOT - COS, ROOT^2 = q and COS^2 = Q.
ROOT - COS -> (q - Q) / (ROOT + COS) { ROOT + COS <> 0 };
RATIO - T -> (cc - CC) / den - SHARE / c * (den - DEN) * (DEN / den) { den <> 0, DEN <> 0, c <> 0 };
DEN / den -> 1 / (1 + (den - DEN) / DEN) { den <> 0, DEN <> 0 };
$ c in 4;
