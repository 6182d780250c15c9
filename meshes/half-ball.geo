// Half ball of radius 15 m, flat side up; its lowest point is the origin's height minus 15 m.
// Groups: body (volume), top (flat side, clamped), contact (the cap within 30 degrees of the lowest point),
// side (the rest of the sphere).
SetFactory("OpenCASCADE");
radius = 15;
Point(1) = {0, 0, 0};
Point(2) = {0, 0, -radius};
Point(3) = {radius * Sin(Pi / 6), 0, -radius * Cos(Pi / 6)};
Point(4) = {radius, 0, 0};
Line(1) = {1, 2};
Circle(2) = {2, 1, 3};
Circle(3) = {3, 1, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Extrude { {0, 0, 1}, {0, 0, 0}, 2 * Pi } { Surface{1}; }
Recursive Delete { Surface{1}; }

Physical Volume("body") = {1};
Physical Surface("top") = {4};
Physical Surface("contact") = {2};
Physical Surface("side") = {3};

Mesh.Algorithm = 6;             // frontal: the most even triangles
Mesh.Algorithm3D = 10;          // HXT: several times faster than the default, and no worse
Mesh.OptimizeThreshold = 0.4;   // tetrahedra below this quality (gmsh's SICN, 1 for a regular one) are mended where possible
