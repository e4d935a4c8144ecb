# Refraction into the rarer medium: Interfaces::refract of engine/optics/src/interface.rs with |N|^2 = 1, as it is of planes and spheres,
# and side 1, near the critical angle, where the radicand is formed as a product.
#
# Domain: indices whose ratio m = n / n' is 1.001 to 2. S = cos i' / (m cos i) says how near the critical angle is, where it is 0; above 0.1 the
# code takes the form of refraction_rarer.g. e is m^2 - 1, to its own rounding; q is the square of the cosine of incidence; d and n are a
# coordinate of the ray and of the normal. Lower bounds exclude underflow.
#
# title: refraction near the critical angle
# domain: S from FLOOR
# measured: Directions, near-critical
# goal bend: bend -/ BEND, of the bend
# goal direction: out - OUT, of 1
# case f64 FLOOR=0.03125: bend 120, direction 200
# case f64 FLOOR=0.0009765625: bend 23000, direction 40000
# case f32 FLOOR=0.03125: bend 120, direction 200
# case f32 FLOOR=0.0078125: bend 680, direction 1200

@rnd = float<FORMAT, ne>;
m = rnd(m_); e = rnd(e_);
q = rnd(q_);
d = rnd(d_); n = rnd(n_);

w rnd= sqrt(q);
incident rnd= w * m;
# |N|^2 * e: a product with 1, without rounding.
critical rnd= sqrt(e);
radicand rnd= (incident - critical) * (incident + critical);
root rnd= sqrt(radicand);
den rnd= root + incident;
bend rnd= e / den;
out rnd= d * m - n * bend;

W = sqrt(q);
INCIDENT = W * m;
INCIDENT_SQUARED = q * (m * m);
RADICAND = INCIDENT_SQUARED - e;
ROOT = sqrt(RADICAND);
DEN = ROOT + INCIDENT;
BEND = e / DEN;
OUT = d * m - n * BEND;
S = ROOT / INCIDENT;
CRITICAL = sqrt(e);
K = CRITICAL / INCIDENT;

{
  m in [1.001, 2]
  /\ e in [0.002, 3.001]
  /\ q in [0.0004, 1.0021]
  /\ |d| <= 1.001 /\ |n| <= 1.001
  /\ S in [FLOOR, 0.101]
  # follows:
  /\ W in [0.02, 1.0011]
  /\ INCIDENT in [0.02, 2.0022]
  /\ RADICAND in [1b-40, 1.0021]
  /\ ROOT in [1b-20, 1.0011]
  /\ CRITICAL in [0.04, 1.7324]
  /\ K in [0.99, 1]
  /\ |BEND| in [1b-40, 1.735]
  /\ |OUT| <= 1.002
  -> GOALS
}

ROOT / DEN -> S / (1 + S) { INCIDENT <> 0, DEN <> 0, S + 1 <> 0 };
INCIDENT / DEN -> 1 / (1 + S) { INCIDENT <> 0, DEN <> 0, S + 1 <> 0 };
# by square roots: RADICAND, the product of INCIDENT - CRITICAL and INCIDENT + CRITICAL.
RADICAND -> (INCIDENT - CRITICAL) * (INCIDENT + CRITICAL);
(incident - critical - (INCIDENT - CRITICAL)) / (INCIDENT - CRITICAL) ->
  ((incident - INCIDENT) / INCIDENT - (critical - CRITICAL) / CRITICAL * K) * (INCIDENT / (INCIDENT - CRITICAL))
  { INCIDENT <> 0, CRITICAL <> 0, INCIDENT - CRITICAL <> 0 };
# by square roots: INCIDENT / (INCIDENT - CRITICAL), S^2 = 1 - K^2.
INCIDENT / (INCIDENT - CRITICAL) -> (1 + K) / (S * S) { INCIDENT - CRITICAL <> 0, S <> 0 };
(root + incident - DEN) / DEN -> (root - ROOT) / ROOT * (ROOT / DEN) + (incident - INCIDENT) / INCIDENT * (INCIDENT / DEN)
  { DEN <> 0, ROOT <> 0, INCIDENT <> 0 };
$ S in 16;
