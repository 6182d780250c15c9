// Ball of radius 2 cm about the origin. Groups: body (volume), contact (the cap within 45 degrees of the lowest point), side
// (the rest of the sphere).
SetFactory("OpenCASCADE");
radius = 0.02;
Point(1) = {0, 0, 0};
Point(2) = {0, 0, -radius};
Point(3) = {radius * Sin(Pi / 4), 0, -radius * Cos(Pi / 4)};
Point(4) = {0, 0, radius};
Circle(1) = {2, 1, 3};
Circle(2) = {3, 1, 4};
Line(3) = {4, 2};
Curve Loop(1) = {1, 2, 3};
Plane Surface(1) = {1};
Extrude { {0, 0, 1}, {0, 0, 0}, 2 * Pi } { Surface{1}; }
Recursive Delete { Surface{1}; }

Physical Volume("body") = {1};
Physical Surface("contact") = {2};
Physical Surface("side") = {3};

Mesh.Algorithm = 6;             // frontal: the most even triangles
Mesh.Algorithm3D = 10;          // HXT: several times faster than the default, and no worse
Mesh.OptimizeThreshold = 0.4;   // tetrahedra below this quality (gmsh's SICN, 1 for a regular one) are mended where possible
