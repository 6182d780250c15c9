// Two unit squares side by side, joined along the lower half of the edge between them: its upper half is a crack, whose nodes
// come in pairs at one place. Groups: body, bottom (y = 0), left (x = 0), boundary (all round, without the crack).
Point(1) = {0, 0, 0};
Point(2) = {1, 0, 0};
Point(3) = {2, 0, 0};
Point(4) = {2, 1, 0};
Point(5) = {1, 1, 0};
Point(6) = {0, 1, 0};
Point(7) = {1, 0.5, 0};
Point(8) = {1, 1, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 8};
Line(5) = {5, 6};
Line(6) = {6, 1};
Line(7) = {2, 7};
Line(8) = {7, 5};
Line(9) = {7, 8};
Curve Loop(1) = {1, 7, 8, 5, 6};
Curve Loop(2) = {2, 3, 4, -9, -7};
Plane Surface(1) = {1};
Plane Surface(2) = {2};
Physical Surface("body") = {1, 2};
Physical Curve("bottom") = {1, 2};
Physical Curve("left") = {6};
Physical Curve("boundary") = {1, 2, 3, 4, 5, 6};
