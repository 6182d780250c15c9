// Half disc of radius 8 m, flat side up, its lowest point on the origin's height; fine where it is pressed onto a plane
// and up to 1 m coarse elsewhere. Without an element size in the scene the sizes below hold.
// Groups: body (surface), top (flat side), contact (the arc within 15 degrees of the lowest point), side (its rest).
radius = 8;
fine = 0.068;   // m, a tenth of half the contact's width under 10 N/m
Point(1) = {0, radius, 0};
Point(2) = {0, 0, 0};
Point(3) = {radius * Sin(Pi / 12), radius * (1 - Cos(Pi / 12)), 0};
Point(4) = {radius, radius, 0};
Point(5) = {-radius, radius, 0};
Point(6) = {-radius * Sin(Pi / 12), radius * (1 - Cos(Pi / 12)), 0};
Circle(1) = {2, 1, 3};
Circle(2) = {3, 1, 4};
Line(3) = {4, 5};
Circle(4) = {5, 1, 6};
Circle(5) = {6, 1, 2};
Curve Loop(1) = {1, 2, 3, 4, 5};
Plane Surface(1) = {1};

// As fine as said within 1 m of the lowest point, then coarser with the distance.
Field[1] = MathEval;
Field[1].F = Sprintf("%g * Max(1, Sqrt(x^2 + y^2))", fine);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;

Physical Surface("body") = {1};
Physical Curve("top") = {3};
Physical Curve("contact") = {5, 1};
Physical Curve("side") = {2, 4};
