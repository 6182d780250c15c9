// Half of the block of roller.toml, 100 mm wide and 200 mm high, fine under the roller and coarser with the distance. The origin is
// the point where the roller touches. Groups: body (surface), top (the upper side within 15 mm, the contact candidates), axis (the
// plane of symmetry), base (the lower side).
fine = 2.5e-4;   // m, a twentieth of the half-width of the contact
Point(1) = {0, -0.2, 0};
Point(2) = {0.1, -0.2, 0};
Point(3) = {0.1, 0, 0};
Point(4) = {0.015, 0, 0};
Point(5) = {0, 0, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 5};
Line(5) = {5, 1};
Curve Loop(1) = {1 : 5};
Plane Surface(1) = {1};

Field[1] = MathEval;
Field[1].F = Sprintf("%g * Max(1, Sqrt(x^2 + y^2) / 0.008)", fine);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;

Physical Surface("body") = {1};
Physical Curve("top") = {4};
Physical Curve("axis") = {5};
Physical Curve("base") = {1};
