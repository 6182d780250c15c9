// Beam of 1 m along x, 5 cm wide and high. Groups: body (volume), ends (x = 0 and x = 1), top (the contact candidates: the middle 20 cm
// of the upper face).
SetFactory("OpenCASCADE");
Box(1) = {0, -0.025, -0.025, 0.4, 0.05, 0.05};
Box(2) = {0.4, -0.025, -0.025, 0.2, 0.05, 0.05};
Box(3) = {0.6, -0.025, -0.025, 0.4, 0.05, 0.05};
Coherence;
Physical Volume("body") = {1, 2, 3};
e = 1e-6;
Physical Surface("ends") = {Surface In BoundingBox {-e, -1, -1, e, 1, 1}, Surface In BoundingBox {1 - e, -1, -1, 1 + e, 1, 1}};
Physical Surface("top") = {Surface In BoundingBox {0.4 - e, -1, 0.025 - e, 0.6 + e, 1, 0.025 + e}};
Mesh.Algorithm3D = 10;
