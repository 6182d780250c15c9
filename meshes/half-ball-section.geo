// Half section of the half ball of half-ball.geo, for axial symmetry: x is the radius, y the height.
// Groups: body (surface), top (flat side, clamped), contact (the cap within 30 degrees of the lowest point),
// side (the rest of the sphere).
radius = 15;
Point(1) = {0, 0, 0};
Point(2) = {0, -radius, 0};
Point(3) = {radius * Sin(Pi / 6), -radius * Cos(Pi / 6), 0};
Point(4) = {radius, 0, 0};
Line(1) = {1, 2};
Circle(2) = {2, 1, 3};
Circle(3) = {3, 1, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};

Physical Surface("body") = {1};
Physical Curve("top") = {4};
Physical Curve("contact") = {2};
Physical Curve("side") = {3};

Mesh.Algorithm = 6;   // frontal: the most even triangles
