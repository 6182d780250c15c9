// Quarter of the elliptic membrane of ellipse.toml, fine at the point D = (2, 0) of the inner edge. Groups: body (surface),
// outer (the loaded edge), left, lower (the planes of symmetry).
fine = 0.01;   // m
Point(1) = {0, 0, 0};
Point(2) = {2, 0, 0};
Point(3) = {3.25, 0, 0};
Point(4) = {0, 2.75, 0};
Point(5) = {0, 1, 0};
Line(1) = {2, 3};
Ellipse(2) = {3, 1, 3, 4};
Line(3) = {4, 5};
Ellipse(4) = {5, 1, 2, 2};
Curve Loop(1) = {1 : 4};
Plane Surface(1) = {1};

Field[1] = MathEval;
Field[1].F = Sprintf("Min(0.1, %g * Max(1, Sqrt((x - 2)^2 + y^2) / 0.06))", fine);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;

Physical Surface("body") = {1};
Physical Curve("lower") = {1};
Physical Curve("outer") = {2};
Physical Curve("left") = {3};
