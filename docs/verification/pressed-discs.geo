// Two half discs of 1 m on each other, the upper one finer where they touch, at the origin. Groups: upper, lower (surfaces), above, below
// (the arcs within 20 degrees), top, floor (the flat sides).
fine = 0.004;
a = Pi / 9;
Point(1) = {0, 1, 0}; Point(2) = {0, 0, 0}; Point(3) = {Sin(a), 1 - Cos(a), 0}; Point(4) = {1, 1, 0}; Point(5) = {-1, 1, 0};
Point(6) = {-Sin(a), 1 - Cos(a), 0};
Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Line(3) = {4, 5}; Circle(4) = {5, 1, 6}; Circle(5) = {6, 1, 2};
Curve Loop(1) = {1, 2, 3, 4, 5}; Plane Surface(1) = {1};
Point(11) = {0, -1, 0}; Point(12) = {0, 0, 0}; Point(13) = {Sin(a), Cos(a) - 1, 0}; Point(14) = {1, -1, 0}; Point(15) = {-1, -1, 0};
Point(16) = {-Sin(a), Cos(a) - 1, 0};
Circle(11) = {12, 11, 13}; Circle(12) = {13, 11, 14}; Line(13) = {14, 15}; Circle(14) = {15, 11, 16}; Circle(15) = {16, 11, 12};
Curve Loop(2) = {11, 12, 13, 14, 15}; Plane Surface(2) = {2};
Field[1] = MathEval;
Field[1].F = Sprintf("%g * Max(1, Sqrt(x^2 + y^2) / 0.12)", fine);
Field[2] = MathEval;
Field[2].F = Sprintf("%g * Max(1, Sqrt(x^2 + y^2) / 0.12)", 1.37 * fine);
Field[3] = Restrict; Field[3].InField = 1; Field[3].SurfacesList = {1}; Field[3].CurvesList = {1 : 5};
Field[4] = Restrict; Field[4].InField = 2; Field[4].SurfacesList = {2}; Field[4].CurvesList = {11 : 15};
Field[5] = Min; Field[5].FieldsList = {3, 4};
Background Field = 5;
Mesh.MeshSizeExtendFromBoundary = 0; Mesh.MeshSizeFromPoints = 0;
Physical Surface("upper") = {1}; Physical Surface("lower") = {2};
Physical Curve("above") = {5, 1}; Physical Curve("below") = {15, 11}; Physical Curve("top") = {3}; Physical Curve("floor") = {13};
