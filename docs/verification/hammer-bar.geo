// A bar of length 1 and height 0.05 along x, in 320 elements. Groups: body (surface), hit (x = 0), far (x = 1).
height = 0.05;
Point(1) = {0, 0, 0};
Point(2) = {1, 0, 0};
Point(3) = {1, height, 0};
Point(4) = {0, height, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 3} = 321;
Transfinite Curve {2, 4} = 2;
Transfinite Surface {1};

Physical Surface("body") = {1};
Physical Curve("hit") = {4};
Physical Curve("far") = {2};
