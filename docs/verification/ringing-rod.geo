// Half section of the rod of ringing-rod.toml: radius 5 cm, length 1 m. x is the radius, y the axis; structured.
// Groups: body (surface).
Point(1) = {0, 0, 0};
Point(2) = {0.05, 0, 0};
Point(3) = {0.05, 1, 0};
Point(4) = {0, 1, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1 : 4};
Plane Surface(1) = {1};
Transfinite Curve{1, 3} = 3;
Transfinite Curve{2, 4} = 31;
Transfinite Surface{1} Alternated;

Physical Surface("body") = {1};
