// The truss of truss.toml: 2 m long, its area 0.2 m² as a strip 0.2 m wide and 1 m deep. Groups: see strip.geo.
length = 2;
width = 0.2;
Include "strip.geo";
