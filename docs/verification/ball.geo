// Half section of a ball of `radius` (m) whose lowest point is the origin; elements are `fine` within `near` of that point, and
// coarser with the distance. x is the radius, y the axis. Included by other meshes.
// Groups: body (surface), contact (the cap within `cap` of the lowest point, the contact candidates).
angle = Asin(cap / radius);
Point(1) = {0, radius, 0};
Point(2) = {0, 0, 0};
Point(3) = {radius * Sin(angle), radius * (1 - Cos(angle)), 0};
Point(4) = {radius, radius, 0};
Point(5) = {0, 2 * radius, 0};
Circle(1) = {2, 1, 3};
Circle(2) = {3, 1, 4};
Circle(3) = {4, 1, 5};
Line(4) = {5, 2};
Curve Loop(1) = {1 : 4};
Plane Surface(1) = {1};

Field[1] = MathEval;
Field[1].F = Sprintf("%g * Max(1, Sqrt(x^2 + y^2) / %g)", fine, near);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;

Physical Surface("body") = {1};
Physical Curve("contact") = {1};
