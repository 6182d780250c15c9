// Unit cube in six even parts a side, the same by every gmsh, where cube.geo's mesh is another by each.
// Groups: body (volume), boundary (all six sides), bottom, top, left (z = 0, z = 1, x = 0).
Point(1) = {0, 0, 0};
Point(2) = {1, 0, 0};
Point(3) = {1, 1, 0};
Point(4) = {0, 1, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1:4} = 7;
Transfinite Surface {1};
Extrude {0, 0, 1} { Surface{1}; Layers{6}; }
Physical Volume("body") = {1};
Physical Surface("boundary") = Surface{:};
Physical Surface("bottom") = {1};
Physical Surface("top") = Surface In BoundingBox {-0.1, -0.1, 0.9, 1.1, 1.1, 1.1};
Physical Surface("left") = Surface In BoundingBox {-0.1, -0.1, -0.1, 0.1, 1.1, 1.1};
