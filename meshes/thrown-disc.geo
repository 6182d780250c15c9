// Disc of radius 0.5 m about the origin. Groups: body (surface), contact (the arc within 60 degrees of the rightmost
// point), hand (the arc within 60 degrees of the leftmost point), side (the two arcs between).
radius = 0.5;
Point(1) = {0, 0, 0};
Point(2) = {radius, 0, 0};
Point(3) = {radius * Cos(Pi / 3), radius * Sin(Pi / 3), 0};
Point(4) = {-radius * Cos(Pi / 3), radius * Sin(Pi / 3), 0};
Point(5) = {-radius, 0, 0};
Point(6) = {-radius * Cos(Pi / 3), -radius * Sin(Pi / 3), 0};
Point(7) = {radius * Cos(Pi / 3), -radius * Sin(Pi / 3), 0};
Circle(1) = {2, 1, 3};
Circle(2) = {3, 1, 4};
Circle(3) = {4, 1, 5};
Circle(4) = {5, 1, 6};
Circle(5) = {6, 1, 7};
Circle(6) = {7, 1, 2};
Curve Loop(1) = {1, 2, 3, 4, 5, 6};
Plane Surface(1) = {1};

Physical Surface("body") = {1};
Physical Curve("contact") = {6, 1};
Physical Curve("hand") = {3, 4};
Physical Curve("side") = {2, 5};
