// The tapered membrane of membrane.toml: 10 m long, 5 m wide at the root and 1 m at the tip. Groups: body (surface), root.
Point(1) = {0, -2.5, 0};
Point(2) = {10, -0.5, 0};
Point(3) = {10, 0, 0};
Point(4) = {10, 0.5, 0};
Point(5) = {0, 2.5, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 5};
Line(5) = {5, 1};
Curve Loop(1) = {1 : 5};
Plane Surface(1) = {1};

Physical Surface("body") = {1};
Physical Curve("root") = {5};
