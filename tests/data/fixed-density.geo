// The unit square in 2 * 70 * 70 cells, whatever the element size.
Include "square.geo";
Transfinite Curve {1, 2, 3, 4} = 71;
Transfinite Surface {1};
