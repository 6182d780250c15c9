// Half section of the thick-walled tube of tube.toml: radii 3 and 9 m, 1 m long. x is the radius, y the axis.
// Groups: body (surface), inside, outside (the walls), lower, upper (the ends).
Point(1) = {3, 0, 0};
Point(2) = {9, 0, 0};
Point(3) = {9, 1, 0};
Point(4) = {3, 1, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1 : 4};
Plane Surface(1) = {1};

Physical Surface("body") = {1};
Physical Curve("lower") = {1};
Physical Curve("outside") = {2};
Physical Curve("upper") = {3};
Physical Curve("inside") = {4};
