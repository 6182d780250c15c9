// Half section of a rubber cylinder, 20 mm in radius and 30 mm high, under a steel disc 15 mm thick; x is the radius.
// Groups: rubber, steel (surfaces), foot (the rubber's lower end, the contact candidates), top (the steel's upper end).
radius = 0.02;  height = 0.03;  thickness = 0.015;
Point(1) = {0, 0, 0};
Point(2) = {radius, 0, 0};
Point(3) = {radius, height, 0};
Point(4) = {0, height, 0};
Point(5) = {radius, height + thickness, 0};
Point(6) = {0, height + thickness, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Line(5) = {3, 5};
Line(6) = {5, 6};
Line(7) = {6, 4};
Curve Loop(1) = {1, 2, 3, 4};
Curve Loop(2) = {-3, 5, 6, 7};
Plane Surface(1) = {1};
Plane Surface(2) = {2};

Physical Surface("rubber") = {1};
Physical Surface("steel") = {2};
Physical Curve("foot") = {1};
Physical Curve("top") = {6};

Mesh.Algorithm = 6;   // frontal: the most even triangles
