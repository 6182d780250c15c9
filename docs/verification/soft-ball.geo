// The soft ball of soft-ball.toml; contact reaches to 4.3 cm. Groups: see ball.geo.
radius = 0.119;
cap = 0.07;
near = 0.06;
fine = 2.8e-3;
Include "ball.geo";
