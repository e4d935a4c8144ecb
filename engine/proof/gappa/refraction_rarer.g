# Refraction into the rarer medium: Interfaces::refract of engine/optics/src/interface.rs with |N|^2 = 1, as it is of planes and spheres,
# and side 1, where the radicand is formed as a difference.
#
# Domain: indices whose ratio m = n / n' is 1 to 2. S = cos i' / (m cos i) says how near the critical angle is, where it is 0; below 0.1 the
# code takes the form of refraction_critical.g. e is m^2 - 1, to its own rounding; q is the square of the cosine of incidence; d and n are a
# coordinate of the ray and of the normal. Lower bounds exclude underflow.
#
# title: refraction into the rarer medium
# domain: S from FLOOR
# measured: Directions, ordinary
# goal bend: bend -/ BEND, of the bend
# goal direction: out - OUT, of 1
# case f64 FLOOR=0.5: bend 5.3, direction 13
# case f64 FLOOR=0.0999: bend 18, direction 34
# case f32 FLOOR=0.5: bend 5.3, direction 13
# case f32 FLOOR=0.0999: bend 18, direction 34

@rnd = float<FORMAT, ne>;
m = rnd(m_); e = rnd(e_);
q = rnd(q_);
d = rnd(d_); n = rnd(n_);

w rnd= sqrt(q);
m_squared rnd= m * m;
incident_squared rnd= q * m_squared;
incident rnd= w * m;
radicand rnd= incident_squared - e;
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

{
  m in [1, 2]
  /\ e in [1b-30, 3.001]
  /\ q in [1b-20, 1.0021]
  /\ |d| <= 1.001 /\ |n| <= 1.001
  /\ S in [FLOOR, 1]
  # follows:
  /\ W in [1b-10, 1.0011]
  /\ INCIDENT in [1b-10, 2.0022]
  /\ RADICAND in [1b-30, 1.0021]
  /\ ROOT in [1b-15, 1.0011]
  /\ |BEND| in [1b-40, 1.735]
  /\ |OUT| <= 1.002
  -> GOALS
}

# by square roots: INCIDENT_SQUARED / RADICAND, W^2 = q and ROOT^2 = RADICAND.
INCIDENT_SQUARED / RADICAND -> 1 / (S * S) { RADICAND <> 0, S <> 0 };
ROOT / DEN -> S / (1 + S) { INCIDENT <> 0, DEN <> 0, S + 1 <> 0 };
INCIDENT / DEN -> 1 / (1 + S) { INCIDENT <> 0, DEN <> 0, S + 1 <> 0 };
(incident_squared - e - RADICAND) / RADICAND -> (incident_squared - INCIDENT_SQUARED) / INCIDENT_SQUARED * (INCIDENT_SQUARED / RADICAND)
  { RADICAND <> 0, INCIDENT_SQUARED <> 0 };
(root + incident - DEN) / DEN -> (root - ROOT) / ROOT * (ROOT / DEN) + (incident - INCIDENT) / INCIDENT * (INCIDENT / DEN)
  { DEN <> 0, ROOT <> 0, INCIDENT <> 0 };
$ S in 16;
