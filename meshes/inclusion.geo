// Square of 10 cm with a round inclusion of radius 2.5 cm in the middle; its lower side is on the origin's height. Groups:
// matrix, inclusion (surfaces), bottom (the contact candidates), surface (the other sides).
side = 0.1;  radius = 0.025;
Point(1) = {-side / 2, 0, 0};  Point(2) = {side / 2, 0, 0};  Point(3) = {side / 2, side, 0};  Point(4) = {-side / 2, side, 0};
Point(5) = {0, side / 2, 0};
Point(6) = {radius, side / 2, 0};  Point(7) = {0, side / 2 + radius, 0};  Point(8) = {-radius, side / 2, 0};  Point(9) = {0, side / 2 - radius, 0};
Line(1) = {1, 2};  Line(2) = {2, 3};  Line(3) = {3, 4};  Line(4) = {4, 1};
Circle(5) = {6, 5, 7};  Circle(6) = {7, 5, 8};  Circle(7) = {8, 5, 9};  Circle(8) = {9, 5, 6};
Curve Loop(1) = {1, 2, 3, 4};
Curve Loop(2) = {5, 6, 7, 8};
Plane Surface(1) = {1, 2};
Plane Surface(2) = {2};

Physical Surface("matrix") = {1};
Physical Surface("inclusion") = {2};
Physical Curve("bottom") = {1};
Physical Curve("surface") = {2, 3, 4};
