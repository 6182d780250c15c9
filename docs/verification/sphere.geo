// Quarter section of the hollow sphere of sphere.toml: radii 1.8 and 6 m, its upper half. x is the radius, y the axis.
// Groups: body (surface), inside, outside (the spheres), middle (the plane of symmetry).
inner = 1.8;
outer = 6;
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
Field[1].F = "0.1 * Sqrt(x^2 + y^2)";
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;

Physical Surface("body") = {1};
Physical Curve("middle") = {1};
Physical Curve("outside") = {2};
Physical Curve("inside") = {4};
