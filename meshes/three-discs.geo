// Three discs of radius 0.5 m in a row along x, 0.02 m apart; the second one is about the origin. Groups: disc 1, disc 2, disc 3 (surfaces);
// right 1, left 2, right 2, left 3 (arcs within 60 degrees of the points that face each other), hand (the one of disc 1 on its far side).
r = 0.5; apart = 1.02;
// disc 1, about (-apart, 0)
Point(10) = {-apart, 0, 0}; Point(11) = {-apart + r, 0, 0}; Point(12) = {-apart + r * Cos(Pi / 3), r * Sin(Pi / 3), 0};
Point(13) = {-apart - r * Cos(Pi / 3), r * Sin(Pi / 3), 0}; Point(14) = {-apart - r, 0, 0}; Point(15) = {-apart - r * Cos(Pi / 3), -r * Sin(Pi / 3), 0};
Point(16) = {-apart + r * Cos(Pi / 3), -r * Sin(Pi / 3), 0};
Circle(11) = {11, 10, 12}; Circle(12) = {12, 10, 13}; Circle(13) = {13, 10, 14};
Circle(14) = {14, 10, 15}; Circle(15) = {15, 10, 16}; Circle(16) = {16, 10, 11};
Curve Loop(1) = {11, 12, 13, 14, 15, 16}; Plane Surface(1) = {1};
// disc 2, about (0, 0)
Point(20) = {0, 0, 0}; Point(21) = {0 + r, 0, 0}; Point(22) = {0 + r * Cos(Pi / 3), r * Sin(Pi / 3), 0};
Point(23) = {0 - r * Cos(Pi / 3), r * Sin(Pi / 3), 0}; Point(24) = {0 - r, 0, 0}; Point(25) = {0 - r * Cos(Pi / 3), -r * Sin(Pi / 3), 0};
Point(26) = {0 + r * Cos(Pi / 3), -r * Sin(Pi / 3), 0};
Circle(21) = {21, 20, 22}; Circle(22) = {22, 20, 23}; Circle(23) = {23, 20, 24};
Circle(24) = {24, 20, 25}; Circle(25) = {25, 20, 26}; Circle(26) = {26, 20, 21};
Curve Loop(2) = {21, 22, 23, 24, 25, 26}; Plane Surface(2) = {2};
// disc 3, about (apart, 0)
Point(30) = {apart, 0, 0}; Point(31) = {apart + r, 0, 0}; Point(32) = {apart + r * Cos(Pi / 3), r * Sin(Pi / 3), 0};
Point(33) = {apart - r * Cos(Pi / 3), r * Sin(Pi / 3), 0}; Point(34) = {apart - r, 0, 0}; Point(35) = {apart - r * Cos(Pi / 3), -r * Sin(Pi / 3), 0};
Point(36) = {apart + r * Cos(Pi / 3), -r * Sin(Pi / 3), 0};
Circle(31) = {31, 30, 32}; Circle(32) = {32, 30, 33}; Circle(33) = {33, 30, 34};
Circle(34) = {34, 30, 35}; Circle(35) = {35, 30, 36}; Circle(36) = {36, 30, 31};
Curve Loop(3) = {31, 32, 33, 34, 35, 36}; Plane Surface(3) = {3};
Physical Surface("disc 1") = {1}; Physical Surface("disc 2") = {2}; Physical Surface("disc 3") = {3};
Physical Curve("right 1") = {16, 11}; Physical Curve("left 2") = {23, 24}; Physical Curve("right 2") = {26, 21}; Physical Curve("left 3") = {33, 34};
Physical Curve("hand") = {13, 14};
