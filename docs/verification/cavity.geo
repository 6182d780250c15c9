// Quarter section of a solid with a spherical cavity of radius 1 m, out to 9 m, its upper half. x is the radius, y the axis.
// Groups: body (surface), cavity (its wall), middle (the plane of symmetry).
inner = 1;
outer = 9;
Point(1) = {0, 0, 0};
Point(2) = {inner, 0, 0};
Point(3) = {outer, 0, 0};
Point(4) = {0, outer, 0};
Point(5) = {0, inner, 0};
Line(1) = {2, 3};
Circle(2) = {3, 1, 4};
Line(3) = {4, 5};
Circle(4) = {5, 1, 2};
Curve Loop(1) = {1 : 4};
Plane Surface(1) = {1};

Field[1] = MathEval;
Field[1].F = "0.08 * Sqrt(x^2 + y^2)^0.8";
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;

Physical Surface("body") = {1};
Physical Curve("middle") = {1};
Physical Curve("cavity") = {4};
