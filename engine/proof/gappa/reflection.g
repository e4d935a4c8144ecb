# Reflection: reflect of engine/optics/src/interface.rs with |N|^2 = 1, as it is of planes and spheres, and side 1.
#
# Domain: any angle. d and n are a coordinate of the ray and of the normal, w is the cosine of incidence.
#
# title: reflection
# domain: any angle
# measured: Directions, mirror
# goal direction: out - OUT, of 1
# case f64: direction 3.1
# case f32: direction 3.1

@rnd = float<FORMAT, ne>;
d = rnd(d_); n = rnd(n_); w = rnd(w_);

# w * (side + side) / |N|^2: a doubling and a division by 1, without rounding.
twice = 2 * w;
out rnd= d - n * twice;

OUT = d - n * twice;

{
  |d| <= 1.001 /\ |n| <= 1.001
  /\ w in [0, 1.001]
  # follows: the reflected direction is of D's length.
  /\ |OUT| <= 1.001
  -> GOALS
}
