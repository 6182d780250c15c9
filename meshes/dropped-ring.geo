// Ring about the origin, 10 cm outside and 8 cm inside. Groups: body (surface), outside (its arc within 60 degrees of the lowest
// point, the contact candidates).
outer = 0.1;  inner = 0.08;
Point(1) = {0, 0, 0};
Point(2) = {0, -outer, 0};
Point(3) = {outer * Sin(Pi / 3), -outer * Cos(Pi / 3), 0};
Point(4) = {0, outer, 0};
Point(5) = {-outer * Sin(Pi / 3), -outer * Cos(Pi / 3), 0};
Point(6) = {0, -inner, 0};
Point(7) = {inner, 0, 0};
Point(8) = {0, inner, 0};
Point(9) = {-inner, 0, 0};
Circle(1) = {5, 1, 2};
Circle(2) = {2, 1, 3};
Circle(3) = {3, 1, 4};
Circle(4) = {4, 1, 5};
Circle(5) = {6, 1, 7};
Circle(6) = {7, 1, 8};
Circle(7) = {8, 1, 9};
Circle(8) = {9, 1, 6};
Curve Loop(1) = {1, 2, 3, 4};
Curve Loop(2) = {5, 6, 7, 8};
Plane Surface(1) = {1, 2};

Physical Surface("body") = {1};
Physical Curve("outside") = {1, 2};
