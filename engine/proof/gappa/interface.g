# Indices at an interface: Interface::new of engine/optics/src/interface.rs. The excess (n / n')^2 - 1 keeps its digits where n and n' are
# near, whatever they are.
#
# Domain: indices from 1 to 2.5; no two that differ by less than 2^-60 differ at all.
#
# title: indices
# domain: any two from 1 to 2.5
# goal ratio: m -/ M, of the ratio
# goal excess: e -/ E, of the excess
# case f64: ratio 1.0, excess 4.1
# case f32: ratio 1.0, excess 4.1

@rnd = float<FORMAT, ne>;
n1 = rnd(n1_); n2 = rnd(n2_);

m rnd= n1 / n2;
difference rnd= n1 - n2;
sum rnd= n1 + n2;
square rnd= n2 * n2;
product rnd= difference * sum;
e rnd= product / square;

M = n1 / n2;
DIFFERENCE = n1 - n2;
SUM = n1 + n2;
SQUARE = n2 * n2;
PRODUCT = DIFFERENCE * SUM;
E = PRODUCT / SQUARE;

{
  n1 in [1, 2.5]
  /\ n2 in [1, 2.5]
  /\ |DIFFERENCE| in [1b-60, 1.5]
  # follows:
  /\ |E| in [1b-64, 8]
  -> GOALS
}

# So that |product / square| is seen to be bounded away from underflow.
product / square -> E * (1 + (product / square - E) / E) { E <> 0 };
