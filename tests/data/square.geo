// Unit square. Groups: body, bottom, left, top, rest (all sides but the bottom), boundary (all four).
Point(1) = {0, 0, 0};
Point(2) = {1, 0, 0};
Point(3) = {1, 1, 0};
Point(4) = {0, 1, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Physical Surface("body") = {1};
Physical Curve("bottom") = {1};
Physical Curve("rest") = {2, 3, 4};
Physical Curve("boundary") = {1, 2, 3, 4};
Physical Curve("top") = {3};
Physical Curve("left") = {4};
