// Two discs of radius 0.5 m, the left one about the origin, 0.02 m apart, with elements of the sizes 0.06 m and 0.08 m. Groups: left, right
// (surfaces), right side (of the left disc), left side (of the right disc), arcs within 60 degrees of the points that face each other.
r = 0.5;
// disc 1, about (0, 0)
Point(10) = {0, 0, 0}; Point(11) = {0 + r, 0, 0}; Point(12) = {0 + r * Cos(Pi / 3), r * Sin(Pi / 3), 0};
Point(13) = {0 - r * Cos(Pi / 3), r * Sin(Pi / 3), 0}; Point(14) = {0 - r, 0, 0}; Point(15) = {0 - r * Cos(Pi / 3), -r * Sin(Pi / 3), 0};
Point(16) = {0 + r * Cos(Pi / 3), -r * Sin(Pi / 3), 0};
Circle(11) = {11, 10, 12}; Circle(12) = {12, 10, 13}; Circle(13) = {13, 10, 14};
Circle(14) = {14, 10, 15}; Circle(15) = {15, 10, 16}; Circle(16) = {16, 10, 11};
Curve Loop(1) = {11, 12, 13, 14, 15, 16}; Plane Surface(1) = {1};
// disc 2, about (1.02, 0)
Point(20) = {1.02, 0, 0}; Point(21) = {1.02 + r, 0, 0}; Point(22) = {1.02 + r * Cos(Pi / 3), r * Sin(Pi / 3), 0};
Point(23) = {1.02 - r * Cos(Pi / 3), r * Sin(Pi / 3), 0}; Point(24) = {1.02 - r, 0, 0}; Point(25) = {1.02 - r * Cos(Pi / 3), -r * Sin(Pi / 3), 0};
Point(26) = {1.02 + r * Cos(Pi / 3), -r * Sin(Pi / 3), 0};
Circle(21) = {21, 20, 22}; Circle(22) = {22, 20, 23}; Circle(23) = {23, 20, 24};
Circle(24) = {24, 20, 25}; Circle(25) = {25, 20, 26}; Circle(26) = {26, 20, 21};
Curve Loop(2) = {21, 22, 23, 24, 25, 26}; Plane Surface(2) = {2};
MeshSize{PointsOf{Surface{1};}} = 0.06; MeshSize{PointsOf{Surface{2};}} = 0.08;
Physical Surface("left") = {1}; Physical Surface("right") = {2};
Physical Curve("right side") = {16, 11}; Physical Curve("left side") = {23, 24};
