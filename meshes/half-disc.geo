// Half disc of radius 15 m, flat side up; its lowest point is the origin's height minus 15 m.
// Groups: body (surface), top (flat side, clamped), contact (middle third of the arc,
// polar angles -120 to -60 degrees), side (the two outer thirds of the arc).
radius = 15;
Point(1) = {0, 0, 0};
Point(2) = {-radius, 0, 0};
Point(3) = {radius, 0, 0};
Point(4) = {radius * Cos(-2 * Pi / 3), radius * Sin(-2 * Pi / 3), 0};
Point(5) = {radius * Cos(-Pi / 3), radius * Sin(-Pi / 3), 0};

Line(1) = {2, 3};
Circle(2) = {2, 1, 4};
Circle(3) = {4, 1, 5};
Circle(4) = {5, 1, 3};
Curve Loop(1) = {2, 3, 4, -1};
Plane Surface(1) = {1};

Physical Surface("body") = {1};
Physical Curve("top") = {1};
Physical Curve("contact") = {3};
Physical Curve("side") = {2, 4};
