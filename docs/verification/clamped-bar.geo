// The bar of clamped-bar.toml: 1 m long, a strip 0.1 m wide. Groups: see strip.geo.
length = 1;
width = 0.1;
Include "strip.geo";
