// The steel ball of steel-ball.toml, 1 kg; contact reaches to 2.1 mm, of the slow impact to 0.53 mm. Groups: see ball.geo.
radius = 0.03128;
cap = 3e-3;
near = 7e-4;
fine = 3.5e-5;
Include "ball.geo";
