// Half section of the block of cone.toml: a cylinder of radius and height 3.2 m, fine under the cone, coarser with the distance. x is the
// radius, y the axis; the origin is the point that the cone touches first. Groups: body (surface), top (the upper side within 40 mm,
// the contact candidates), base.
fine = 1e-3;   // m, a twentieth of the contact's radius
size = 3.2;
Point(1) = {0, -size, 0};
Point(2) = {size, -size, 0};
Point(3) = {size, 0, 0};
Point(4) = {0.04, 0, 0};
Point(5) = {0, 0, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 5};
Line(5) = {5, 1};
Curve Loop(1) = {1 : 5};
Plane Surface(1) = {1};

Field[1] = MathEval;
Field[1].F = Sprintf("%g * Max(1, Sqrt(x^2 + y^2) / 0.025)", fine);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;

Physical Surface("body") = {1};
Physical Curve("top") = {4};
Physical Curve("base") = {1};
