// Slider: a plate 100 mm long and 30 mm high on two feet, 15 mm wide and 20 mm high; the soles are on the origin's height.
// Groups: body (surface), soles (the lower ends of the feet, the contact candidates), top.
length = 0.1;  height = 0.05;  foot = 0.015;  gap = 0.02;
Point(1) = {0, 0, 0};
Point(2) = {foot, 0, 0};
Point(3) = {foot, gap, 0};
Point(4) = {length - foot, gap, 0};
Point(5) = {length - foot, 0, 0};
Point(6) = {length, 0, 0};
Point(7) = {length, height, 0};
Point(8) = {0, height, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 5};
Line(5) = {5, 6};
Line(6) = {6, 7};
Line(7) = {7, 8};
Line(8) = {8, 1};
Curve Loop(1) = {1, 2, 3, 4, 5, 6, 7, 8};
Plane Surface(1) = {1};

Physical Surface("body") = {1};
Physical Curve("soles") = {1, 5};
Physical Curve("top") = {7};
