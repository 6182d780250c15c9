// A ball of radius 20 mm above a square plate of 120 mm and 10 mm thick, 1 mm apart; the origin is the middle of the plate's upper side. Fine
// where they touch, coarser with the distance. Groups: ball, plate (volumes), cap (of the ball within 30 degrees of its lowest point),
// top, rim (of the plate).
SetFactory("OpenCASCADE");
R = 0.02; c = R + 1e-3; fine = 1.5e-3;
Point(1) = {0, 0, c}; Point(2) = {0, 0, c - R}; Point(3) = {R * Sin(Pi / 6), 0, c - R * Cos(Pi / 6)}; Point(4) = {0, 0, c + R};
Line(1) = {4, 2}; Circle(2) = {2, 1, 3}; Circle(3) = {3, 1, 4};
Curve Loop(1) = {1, 2, 3}; Plane Surface(1) = {1};
Extrude { {0, 0, 1}, {0, 0, 0}, 2 * Pi } { Surface{1}; }
Recursive Delete { Surface{1}; }
Box(2) = {-0.06, -0.06, -0.01, 0.12, 0.12, 0.01};
cap() = Surface In BoundingBox {-0.0101, -0.0101, 0, 0.0101, 0.0101, 0.006};
top() = Surface In BoundingBox {-0.0601, -0.0601, -1e-6, 0.0601, 0.0601, 1e-6};
rim() = Surface In BoundingBox {-0.0601, -0.0601, -0.0101, -0.0599, 0.0601, 1e-6};
rim() += Surface In BoundingBox {0.0599, -0.0601, -0.0101, 0.0601, 0.0601, 1e-6};
rim() += Surface In BoundingBox {-0.0601, -0.0601, -0.0101, 0.0601, -0.0599, 1e-6};
rim() += Surface In BoundingBox {-0.0601, 0.0599, -0.0101, 0.0601, 0.0601, 1e-6};
Physical Volume("ball") = {1}; Physical Volume("plate") = {2};
Physical Surface("cap") = {cap()}; Physical Surface("top") = {top()}; Physical Surface("rim") = {rim()};
Field[1] = MathEval;
Field[1].F = Sprintf("%g + 0.12 * Max(0, Sqrt(x^2 + y^2 + z^2) - 0.006)", fine);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0; Mesh.MeshSizeFromPoints = 0;
