# Intersection with a sphere at grazing incidence: Conic::meet and Quadratic::solve_with_care of engine/optics/src/surface/conic.rs with
# k = 0 and side 1, where B^2 - A C is formed again by Real::difference_of_products (engine/optics/src/lane.rs) and the root is
# C / (-B + sqrt q).
#
# Domain: the start P is within START radii of the vertex: 0.99 of a ray that was carried to its point nearest the vertex, 16 of a ray in a
# lens that need not be carried. -B is the way along the ray from P to the point nearest the centre, in radii.
# The unit of length is the power of two that puts the curvature c into [1/2, 1]: the tracer's numbers change by that power alone.
# c < 0 is the mirror image.
#
# PXC and the like are the same in units of the radius. COS = |N D| is the cosine of incidence.
#
# title: sphere, grazing
# domain: cos i from FLOOR, P within START R
# measured: Points, tangent
# goal cosine: cosine - COS, of 1
# goal point: (x - X) * c, of the radius
# goal normal: nz - NZ, of 1
# case f64 FLOOR=0.125 START=0.99 LENGTH=0.992 LOW=0.0625 HIGH=2 RHO=0.89: cosine 150, point 210, normal 210
# case f64 FLOOR=0.0078125 START=0.99 LENGTH=0.992 LOW=0.00390625 HIGH=2 RHO=1: cosine 2400, point 3400, normal 3400
# case f64 FLOOR=0.0009765625 START=0.99 LENGTH=0.992 LOW=0.00048828125 HIGH=2 RHO=1: cosine 19000, point 27000, normal 27000
# case f64 FLOOR=0.125 START=16 LENGTH=16.02 LOW=0.0625 HIGH=17.1 RHO=1: cosine 27000, point 45000, normal 45000
# case f32 FLOOR=0.125 START=0.99 LENGTH=0.992 LOW=0.0625 HIGH=2 RHO=0.89: cosine 150, point 210, normal 210
# case f32 FLOOR=0.0078125 START=0.99 LENGTH=0.992 LOW=0.00390625 HIGH=2 RHO=1: cosine 2300, point 3400, normal 3400
# case f32 FLOOR=0.125 START=16 LENGTH=16.02 LOW=0.0625 HIGH=17.1 RHO=1: cosine 27000, point 46000, normal 46000

@rnd = float<FORMAT, ne>;
@double = float<ieee_64, ne>;
px = rnd(px_); py = rnd(py_); pz = rnd(pz_);
dx = rnd(dx_); dy = rnd(dy_); dz = rnd(dz_);
c = rnd(c_);

# P's z + P's z: a doubling, without rounding.
two_pz = 2 * pz;
along rnd= px * dx + py * dy + pz * dz;
across rnd= px * px + py * py + pz * pz;
b rnd= along * c - dz;
cc rnd= across * c - two_pz;
# Kahan's algorithm: two products are fused with a sum, so rounded once. In f32 the products are exact in f64.
product rnd= c * cc; # not f32
lost = rnd(product - c * cc); # not f32
fused = rnd(b * b - product); # not f32
q rnd= fused + lost; # not f32
q = rnd(double(b * b - c * cc)); # not f64
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
  /\ ACROSSC in [0, START_SQUARED]
  /\ COS in [FLOOR, 1.001]
  /\ -B in [LOW, HIGH]
  # follows: from Cauchy and Schwarz, |P| <= START R and |D| <= 1.001;
  /\ |PXC| <= START /\ |PYC| <= START /\ |PZC| <= START
  /\ |ALONG_XYC| <= LENGTH /\ |ALONGC| <= LENGTH
  /\ ACROSS_XYC in [0, START_SQUARED]
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
fused + lost - Q -> (fused - (b * b - product)) + (lost - (product - c * cc)) + (b * b - c * cc - Q); # not f32
b * b - product -> (b * b - c * cc) - (product - c * cc); # not f32
b * b - c * cc -> Q + (b * b - c * cc - Q);
# by square roots: ROOT - COS, ROOT^2 = q and COS^2 = Q.
ROOT - COS -> (q - Q) / (ROOT + COS) { ROOT + COS <> 0 };
RATIO - T -> (cc - CC) / den - SHARE / c * (den - DEN) * (DEN / den) { den <> 0, DEN <> 0, c <> 0 };
DEN / den -> 1 / (1 + (den - DEN) / DEN) { den <> 0, DEN <> 0 };
$ c in 4;
