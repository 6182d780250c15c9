// The unit square with 5000 nodes on its top, whatever the element size, which the rest of it answers to.
Include "square.geo";
Transfinite Curve {3} = 5000;
