# Refraction into the denser medium: Interfaces::refract of engine/optics/src/interface.rs with |N|^2 = 1, as it is of planes and spheres,
# and side 1.
#
# Domain: indices whose ratio m = n / n' is 1/2 to 1, at any angle. e is m^2 - 1, to its own rounding; q is the square of the cosine of
# incidence; d and n are a coordinate of the ray and of the normal. Lower bounds exclude underflow.
#
# title: refraction into the denser medium
# domain: any angle
# measured: Directions, ordinary
# goal bend: bend -/ BEND, of the bend
# goal direction: out - OUT, of 1
# case f64: bend 4.6, direction 6.1
# case f32: bend 4.6, direction 6.1

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

{
  m in [0.5, 1]
  /\ -e in [1b-30, 0.751]
  /\ q in [1b-40, 1.0021]
  /\ |d| <= 1.001 /\ |n| <= 1.001
  # follows:
  /\ W in [1b-20, 1.0011]
  /\ |OUT| <= 1.002
  /\ |BEND| in [1b-40, 0.867]
  -> GOALS
}
