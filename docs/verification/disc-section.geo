// Half section of a disc of radius 1 m, 2 cm thick: x is the radius, y the axis. Groups: body (surface).
Point(1) = {0, -0.01, 0};
Point(2) = {1, -0.01, 0};
Point(3) = {1, 0.01, 0};
Point(4) = {0, 0.01, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1 : 4};
Plane Surface(1) = {1};
Transfinite Curve{1, 3} = 51;
Transfinite Curve{2, 4} = 2;
Transfinite Surface{1} Alternated;

Physical Surface("body") = {1};
