// Disc of radius 20 m about the origin. Groups: body (surface), contact (the arc within 60 degrees of the lowest point),
// side (the rest of the circle).
radius = 20;
Point(1) = {0, 0, 0};
Point(2) = {0, -radius, 0};
Point(3) = {radius * Sin(Pi / 3), -radius * Cos(Pi / 3), 0};
Point(4) = {0, radius, 0};
Point(5) = {-radius * Sin(Pi / 3), -radius * Cos(Pi / 3), 0};
Circle(1) = {2, 1, 3};
Circle(2) = {3, 1, 4};
Circle(3) = {4, 1, 5};
Circle(4) = {5, 1, 2};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};

Physical Surface("body") = {1};
Physical Curve("contact") = {4, 1};
Physical Curve("side") = {2, 3};
