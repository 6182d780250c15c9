// Half section of the bar of copper-bar.toml: radius 3.2 mm, length 32.4 mm. x is the radius, y the axis; structured.
// Groups: body (surface), end (the lower end, the contact candidates).
radius = 3.2e-3;
length = 32.4e-3;
Point(1) = {0, 0, 0};
Point(2) = {radius, 0, 0};
Point(3) = {radius, length, 0};
Point(4) = {0, length, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1 : 4};
Plane Surface(1) = {1};
Transfinite Curve{1, 3} = 9;
Transfinite Curve{2, 4} = 82;
Transfinite Surface{1} Alternated;

Physical Surface("body") = {1};
Physical Curve("end") = {1};
