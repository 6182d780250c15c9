// Beam of 1 m along x, 5 cm wide and high, fine in the middle of its upper face, where there is a node, and 1.25 cm coarse elsewhere.
// Without an element size in the scene the sizes below hold.
// Groups: body (volume), ends (x = 0 and x = 1), top (the contact candidates: the middle 20 cm of the upper face).
SetFactory("OpenCASCADE");
fine = 0.002;     // m, two thirds of the contact's radius under 17 kN
coarse = 0.0125;  // m, a quarter of the height
Box(1) = {0, -0.025, -0.025, 0.4, 0.05, 0.05};
Box(2) = {0.4, -0.025, -0.025, 0.2, 0.05, 0.05};
Box(3) = {0.6, -0.025, -0.025, 0.4, 0.05, 0.05};
Point(100) = {0.5, 0, 0.025};
BooleanFragments{ Volume{:}; Delete; }{ Point{100}; Delete; }

// As fine as said within 6 mm of the middle, then coarser with the distance.
Field[1] = MathEval;
Field[1].F = Sprintf("Min(%g, %g * Max(1, Sqrt((x - 0.5)^2 + y^2 + (z - 0.025)^2) / 0.006))", coarse, fine);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;

Physical Volume("body") = {1, 2, 3};
e = 1e-6;
Physical Surface("ends") = {Surface In BoundingBox {-e, -1, -1, e, 1, 1}, Surface In BoundingBox {1 - e, -1, -1, 1 + e, 1, 1}};
Physical Surface("top") = {Surface In BoundingBox {0.4 - e, -1, 0.025 - e, 0.6 + e, 1, 0.025 + e}};
Mesh.Algorithm3D = 10;
