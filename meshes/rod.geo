// Half section of a rod, 20 mm in diameter and 0.5 m long, about the axis x = 0; structured. The element size is that along the rod.
// Groups: body (surface), foot (y = 0), head (y = 0.5).
radius = 0.01;
length = 0.5;
Point(1) = {0, 0, 0};
Point(2) = {radius, 0, 0};
Point(3) = {radius, length, 0};
Point(4) = {0, length, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve{1, 3} = 5;
Transfinite Surface{1} = {1, 2, 3, 4};

Physical Surface("body") = {1};
Physical Curve("foot") = {1};
Physical Curve("head") = {3};
